#include "report/build_report.hpp"

#include <fmt/format.h>

#include <iterator>
#include <string_view>
#include <vector>

#include "report/table.hpp"

namespace clbvh::tool {
namespace {

std::string stage_table(const BuildResult& result) {
    const bool on_device = result.kind == BuilderKind::device;
    Table table(on_device ? std::vector<std::string>{"stage", "device ms", "host ms", "launches"}
                          : std::vector<std::string>{"stage", "ms"});
    for (const StageStats& stage : result.stages) {
        const std::string host_ms = fmt::format("{:.3f}", stage.host_ms);
        if (on_device) {
            table.add_row(
                {stage.name, fmt::format("{:.3f}", stage.device_ms), host_ms, std::to_string(stage.launches)});
        } else {
            table.add_row({stage.name, host_ms});
        }
    }
    return table.text();
}

/// The builder's own part: where and how it ran.
std::string builder_line(const BuildResult& result) {
    if (result.kind == BuilderKind::host) {
        return fmt::format("{}, on the host, {}", result.builder, threads_text(result.threads));
    }
    const std::string radius = result.radius > 0 ? fmt::format(", radius {}", result.radius) : "";
    return fmt::format("{}, {} shape{}", result.builder, to_string(result.shape), radius);
}

std::string build_line(const BuildResult& result) {
    std::string line = fmt::format("{:.3f} ms, {:.2f} Mtris/s", result.build_ms.median, result.mtris_per_s());
    if (result.kind == BuilderKind::host) return line;
    return line + fmt::format(", {} launches, {} iterations", result.launches, result.iterations);
}

std::string first_build_line(const BuildResult& result, double milliseconds) {
    return fmt::format("{:.0f} ms, with {}", milliseconds,
                       result.kind == BuilderKind::host ? "a copy of the mesh and the first touch of memory"
                                                        : "the upload and the compilation of the kernels");
}

std::string tree_line(const BuildResult& result) {
    return fmt::format("SAH {:.3f}, rays from surfaces {:.2f}, depth {}, {} nodes, {} leaves of {:.2f} primitives",
                       result.sah, result.ray_cost, result.depth, result.nodes, result.leaves,
                       result.primitives_per_leaf());
}

}  // namespace

std::string build_report(const std::optional<Context>& context, const SceneArguments& loading,
                         const BuildResult& result, double load_ms, std::string_view output) {
    std::string text;
    const auto line = [&text](std::string_view label, const std::string& value) {
        fmt::format_to(std::back_inserter(text), "{:<9}  {}\n", label, value);
    };
    line("scene", fmt::format("{}: {} triangles, loaded in {:.2f} s", result.scene, result.triangles, load_ms / 1e3));
    if (!loading.note().empty()) line("turned", loading.note());
    if (context) {
        const DeviceInfo& device = context->device();
        line("device", fmt::format("{}: {} ({})", device.index, device.name, device.platform));
    }
    line("builder", builder_line(result));
    line("build", build_line(result));
    if (result.first_build_ms) line("first", first_build_line(result, *result.first_build_ms));
    line("tree", tree_line(result));
    line("memory", fmt::format("{:.1f} bytes per primitive at the peak", result.peak_bytes_per_primitive()));
    if (result.inactive_primitives > 0) line("inactive", fmt::format("{} primitives", result.inactive_primitives));
    if (result.valid) line("valid", *result.valid ? "yes" : "no");
    if (!output.empty()) line("output", std::string(output));
    return text + '\n' + stage_table(result);
}

}  // namespace clbvh::tool
