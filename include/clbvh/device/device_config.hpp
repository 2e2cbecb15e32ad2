#pragma once

#include <cstdint>
#include <string_view>

#include "clbvh/device/shape.hpp"

namespace clbvh {

/// Which spatial code orders the primitives.
enum class MortonCode : std::uint8_t {
    cubic,     ///< 3D; each bit halves the axis on which cells are longest. Where more than a few primitives share a
               ///< code, they get codes within their own bounds; not with code_bits 63, and not in batches.
    xyz,       ///< 3D, 21 bits an axis, as the papers have it: cells are as stretched as the scene is.
    extended,  ///< 4D extended (Vinkler, Bittner, Havran 2017): axes split longest first, with bits for the primitive's
               ///< size.
};

/// Options that every device builder reads: how kernels lay their work out, and the order of the primitives.
struct DeviceConfig {
    Shape shape = Shape::automatic;       ///< Of all kernels but the sort's.
    Shape sort_shape = Shape::automatic;  ///< Of the sort; automatic: lane on CPU devices that pass the self-test.
    MortonCode morton_code = MortonCode::cubic;  ///< See MortonCode.
    /// Leading bits of the 63-bit spatial code that order primitives, equal ones by id. 33 or 44 (as many of them as
    /// leave room for the id): code and id are sorted as one 64-bit key. 63: as PLOC++ has it, 32-bit keys with a
    /// value, twice.
    std::uint32_t code_bits = 44;
};

/// "cubic", "xyz", "extended"; empty for what is no enumerator.
[[nodiscard]] constexpr std::string_view to_string(MortonCode code) noexcept {
    switch (code) {
        case MortonCode::cubic: return "cubic";
        case MortonCode::xyz: return "xyz";
        case MortonCode::extended: return "extended";
    }
    return {};
}

}  // namespace clbvh
