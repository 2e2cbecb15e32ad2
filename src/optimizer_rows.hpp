#pragma once

#include <string_view>
#include <vector>

#include "device/optimize.hpp"

namespace clbvh {

/// The optimisers of `ids`, ids with commas between them, as they run on devices. Throws what check_optimizers throws,
/// and Error(unsupported) naming the first that runs on the host only.
[[nodiscard]] std::vector<device::ChosenOptimizer> find_device_optimizers(std::string_view ids);

/// Those of `options`, in its shape. Throws what find_device_optimizers and OptimizerChain throw.
[[nodiscard]] device::OptimizerChain make_optimizer_chain(device::Session& session, const BuildOptions& options);

}  // namespace clbvh
