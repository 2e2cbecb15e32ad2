#include "build_report.hpp"

#include <fmt/format.h>

#include <iterator>
#include <string_view>

#include "table.hpp"

namespace clbvh::tool {
namespace {

std::string stage_table(const BuildResult& result) {
    Table table({"stage", "device ms", "host ms", "launches"});
    for (const StageStats& stage : result.stages) {
        table.add_row({stage.name, fmt::format("{:.3f}", stage.device_ms), fmt::format("{:.3f}", stage.host_ms),
                       std::to_string(stage.launches)});
    }
    return table.text();
}

}  // namespace

std::string build_report(const DeviceInfo& device, const BuildResult& result, double load_ms) {
    std::string text;
    const auto line = [&text](std::string_view label, const std::string& value) {
        fmt::format_to(std::back_inserter(text), "{:<9}  {}\n", label, value);
    };
    line("scene", fmt::format("{}: {} triangles, loaded in {:.2f} s", result.scene, result.triangles, load_ms / 1e3));
    line("device", fmt::format("{}: {} ({})", device.index, device.name, device.platform));
    const std::string radius = result.radius > 0 ? fmt::format(", radius {}", result.radius) : "";
    line("builder", fmt::format("{}, {} shape{}", result.builder, to_string(result.shape), radius));
    line("build", fmt::format("{:.3f} ms, {:.2f} Mtris/s, {} launches, {} iterations", result.build_ms.median,
                              result.mtris_per_s(), result.launches, result.iterations));
    if (result.first_build_ms) {
        line("first",
             fmt::format("{:.0f} ms, with the upload and the compilation of the kernels", *result.first_build_ms));
    }
    line("tree", fmt::format("SAH {:.3f}, depth {}, {} nodes, {} leaves", result.sah, result.depth, result.nodes,
                             result.leaves));
    line("memory", fmt::format("{:.1f} bytes per primitive at the peak", result.peak_bytes_per_primitive()));
    if (result.inactive_primitives > 0) line("inactive", fmt::format("{} primitives", result.inactive_primitives));
    if (result.valid) line("valid", *result.valid ? "yes" : "no");
    return text + '\n' + stage_table(result);
}

}  // namespace clbvh::tool
