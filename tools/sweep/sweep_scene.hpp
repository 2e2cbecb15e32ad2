#pragma once

#include <string>
#include <vector>

#include "bench/bench_scene.hpp"
#include "cli/progress_bar.hpp"
#include "measure/build_result.hpp"
#include "sweep/sweep.hpp"

namespace clbvh::tool {

/// Times every builder of `settings` at every value of `sweep` on one scene, in the same rounds (run_rounds) with a
/// native sort of each mesh and a copy on the device. The results of one builder follow each other, from value to
/// value. `values` are those of the sweep, or sweep_sizes(scene, ...).
[[nodiscard]] std::vector<BuildResult> sweep_scene(const BenchSettings& settings, const Sweep& sweep,
                                                   const std::vector<std::uint32_t>& values, const std::string& scene,
                                                   ProgressBar& bar);

}  // namespace clbvh::tool
