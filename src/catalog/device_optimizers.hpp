#pragma once

#include <string_view>
#include <vector>

#include "clbvh/options.hpp"
#include "device/tree/optimize.hpp"

namespace clbvh {

/// The optimisers of `ids`, ids with commas between them, as they run on devices. Throws what
/// check_device_optimizers throws.
[[nodiscard]] std::vector<device::ChosenOptimizer> find_device_optimizers(std::string_view ids);

/// Those of `options`, in its shape. Throws what find_device_optimizers and OptimizerChain throw.
[[nodiscard]] device::OptimizerChain make_optimizer_chain(device::Session& session, const BuildOptions& options);

}  // namespace clbvh
