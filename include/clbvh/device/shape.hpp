#pragma once

#include <cstdint>
#include <string_view>

namespace clbvh {

/// How a kernel lays its work out. Both shapes give the same tree.
enum class Shape : std::uint8_t {
    automatic,  ///< lane on CPU devices that pass the self-test, group elsewhere.
    group,      ///< A work group shares a chunk in local memory with barriers, as the papers write it.
    lane,       ///< Work-group size 1: one work item owns a chunk and loops over it.
};

/// "auto", "group", "lane"; empty for what is no enumerator.
[[nodiscard]] constexpr std::string_view to_string(Shape shape) noexcept {
    switch (shape) {
        case Shape::automatic: return "auto";
        case Shape::group: return "group";
        case Shape::lane: return "lane";
    }
    return {};
}

}  // namespace clbvh
