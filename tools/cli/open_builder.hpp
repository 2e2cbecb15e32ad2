#pragma once

#include <clbvh/builder.hpp>
#include <clbvh/device/context.hpp>
#include <optional>
#include <string_view>

namespace clbvh::tool {

/// A builder on `context`, which a host builder leaves alone and which is needed for a device builder.
[[nodiscard]] inline Builder open_builder(std::string_view id, const std::optional<Context>& context,
                                          const BuildOptions& options) {
    if (find_builder(id).kind == BuilderKind::host) return Builder(id, options);
    return Builder(id, context.value(), options);
}

}  // namespace clbvh::tool
