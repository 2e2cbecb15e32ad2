#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "aila2013/aila_builders.hpp"
#include "aila2013/aila_tree.hpp"
#include "rays/ray_arguments.hpp"
#include "rays/tracer_arguments.hpp"
#include "rays/view_arguments.hpp"
#include "report/metrics_result.hpp"

namespace clbvh::tool {

/// The work of `clbvh table` for each scene.
struct AilaSettings {
    std::vector<AilaBuilder> builders;
    AilaTreeSettings trees;
    std::uint32_t runs = 5;
    std::uint64_t epo_samples = 0;  ///< 0: exact.
    TriangleTest triangle_test = TriangleTest::watertight;
    bool traces_on_device = false;  ///< As well as on the host; the context is open then.
};

/// The trees of one scene, and what they are worth.
struct AilaScene {
    std::string name;
    std::uint64_t triangles = 0;
    std::vector<AilaBuilder> builders;
    std::vector<double> build_ms;       ///< Of each builder.
    std::vector<MetricsResult> host;    ///< The same with rays on the host.
    std::vector<MetricsResult> device;  ///< And on the device; empty where none traces.
};

/// Builds the trees, describes them, and traces the same rays through all of them, on the host and then on the device.
/// The rays, of one kind, are made on the first tree, and its hits on the host are what all others are compared with.
[[nodiscard]] AilaScene measure_aila_scene(const AilaSettings& settings, const RayArguments& rays,
                                           const std::string& scene, const ViewedScene& viewed, ProgressBar& bar);

}  // namespace clbvh::tool
