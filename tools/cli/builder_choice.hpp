#pragma once

#include <clbvh/catalog.hpp>
#include <clbvh/device/context.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace clbvh::tool {

/// The builders that a benchmark is to run, and where.
struct BuilderChoice {
    std::vector<std::string> ids;              ///< Each once, in the order in which they were asked for.
    std::vector<std::string> named_ids;        ///< Those that were asked for by their ids, not as part of a group.
    std::optional<Context> context;            ///< Open where one of them runs on a device.
    std::vector<std::string> unavailable_ids;  ///< What "all" stands for and cannot run here.
    std::string reason;                        ///< Why they cannot.
};

/// Advice of commands where no device can be had: those that take one builder, and those that take several.
inline constexpr const char* kOneBuilderWayOut =
    "--builder binned-sah (a host builder; see clbvh builders) needs no device";
inline constexpr const char* kBuildersWayOut = "--builders host needs no device (see clbvh builders)";

/// Resolves a list of ids, of builders or presets, and groups with commas, and spaces where liked, between them. The
/// groups are "all", "host" and "device" builders, and "presets".
///
/// Device builders that only "all" asks for are left out where no device can be had; where one is asked for by its id,
/// by "device", "presets" or by a `device` selector, that is an error. Throws what require_builder and Context::open
/// throw; where no device was selected and none can be had, the message ends with `way_out`.
[[nodiscard]] BuilderChoice choose_builders(std::string_view list, std::string_view device, std::string_view way_out);

/// find_builder, whose error also tells where builders of other libraries are.
const BuilderInfo& require_builder(std::string_view id);

}  // namespace clbvh::tool
