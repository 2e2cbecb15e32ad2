#pragma once

#include <clbvh/core/bvh.hpp>
#include <clbvh/core/mesh.hpp>
#include <clbvh/core/ray.hpp>
#include <clbvh/device/context.hpp>
#include <clbvh/options.hpp>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "cli/cli_fwd.hpp"
#include "measure/ray_engine.hpp"

namespace clbvh::tool {

/// Where and how a command traces rays.
class TracerArguments {
public:
    bool on_device = false;
    TriangleTest triangle_test = TriangleTest::watertight;

    /// Adds the options to a command; parsing fills this object.
    void add_options(CLI::App& command);
    /// Adds --triangle-test alone, for a command that chooses the place itself.
    void add_triangle_test(CLI::App& command);

    /// The device of `selector` where rays are traced on it and `context` is not open yet; else `context`.
    [[nodiscard]] std::optional<Context> context(std::optional<Context> context, std::string_view selector) const;
    /// An engine over a tree; of `options` the number of threads matters. On a device, `context` is open.
    [[nodiscard]] std::unique_ptr<RayEngine> engine(const Bvh& bvh, const Mesh& mesh, const BuildOptions& options,
                                                    const std::optional<Context>& context) const;
    /// "host", or the device's name.
    [[nodiscard]] std::string place(const std::optional<Context>& context) const;
    /// Threads that trace on the host; 0 on a device.
    [[nodiscard]] std::uint32_t threads(const BuildOptions& options) const;
};

}  // namespace clbvh::tool
