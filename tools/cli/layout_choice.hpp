#pragma once

#include <clbvh/core/error.hpp>
#include <clbvh/io/layout_file.hpp>
#include <string_view>

namespace clbvh::tool {

/// Calls action(layout) with an empty layout of this kind, and returns what it returns.
template <typename Action>
auto with_layout(LayoutKind kind, const Action& action) {
    switch (kind) {
        case LayoutKind::wide8: return action(Wide8{});
        case LayoutKind::wide4: return action(Wide4{});
        case LayoutKind::compressed8: return action(Compressed8{});
        case LayoutKind::pair: return action(PairLayout{});
        case LayoutKind::skip: return action(SkipLayout{});
    }
    throw Error(ErrorCode::unsupported, "a kind of layouts that the command does not know");
}

/// The one of this name; the name is one of them.
[[nodiscard]] inline LayoutKind layout_kind(std::string_view name) {
    for (const LayoutKind kind :
         {LayoutKind::wide8, LayoutKind::wide4, LayoutKind::compressed8, LayoutKind::pair, LayoutKind::skip}) {
        if (to_string(kind) == name) return kind;
    }
    throw Error(ErrorCode::invalid_input, "there is no layout \"" + std::string(name) + "\"");
}

}  // namespace clbvh::tool
