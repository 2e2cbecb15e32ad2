#include "catalog/device_optimizers.hpp"

#include <algorithm>

#include "catalog/optimizer_rows.hpp"
#include "clbvh/catalog.hpp"

namespace clbvh {

std::vector<device::ChosenOptimizer> find_device_optimizers(std::string_view ids) {
    check_device_optimizers(ids);
    std::vector<device::ChosenOptimizer> chosen;
    for (const std::string_view id : optimizer_ids(ids))
        chosen.push_back({find_optimizer(id).id, find_device_row(id)});
    return chosen;
}

device::OptimizerChain make_optimizer_chain(device::Session& session, const BuildOptions& options) {
    if (options.optimizers.empty()) return {};
    DeviceOptimizerOptions device_options;
    device_options.shape = options.device.shape;
    device_options.passes = std::min(options.optimize_passes, device::kMostPasses);
    return {session, find_device_optimizers(options.optimizers), device_options};
}

}  // namespace clbvh
