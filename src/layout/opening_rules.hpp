#pragma once

#include <array>
#include <cstdint>
#include <tuple>

namespace clbvh::layout {

inline constexpr std::uint32_t kNone = 0xFFFFFFFFU;

/// Where the primitives of a block stand in primitive_ids; kNone behind the last.
using Places = std::array<std::uint32_t, 4>;

/// In which order the children of a node are.
enum class Slots {
    by_area,   ///< Large ones first: rays that look for any hit try them in this order. None is missing between others.
    by_octant  ///< See OctantSlots.
};

/// Width: children a node. Joined: most primitives of several leaves that are joined to one. MaxLeaf: most primitives
/// of a leaf; larger ones get nodes of their own. Block: primitives of a block.
template <std::uint32_t WidthValue, std::uint32_t JoinedValue, std::uint32_t MaxLeafValue, std::uint32_t BlockValue,
          Slots SlotsValue = Slots::by_area>
struct OpeningRules {
    static constexpr std::uint32_t Width = WidthValue;
    static constexpr std::uint32_t Joined = JoinedValue;
    static constexpr std::uint32_t MaxLeaf = MaxLeafValue;
    static constexpr std::uint32_t Block = BlockValue;
    static constexpr bool kHasGaps = SlotsValue == Slots::by_octant;  ///< Between the children of a node.
    static_assert(Joined <= Block && Block <= std::tuple_size_v<Places>);

    static constexpr std::uint32_t kLeaf = 1U << 31U;
    static constexpr std::uint32_t kBlockCountShift = 28;
};

}  // namespace clbvh::layout
