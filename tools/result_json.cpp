#include "result_json.hpp"

namespace clbvh::tool {
namespace {

using nlohmann::ordered_json;

ordered_json sample_json(const Sample& sample) {
    return {{"median", sample.median}, {"min", sample.min}, {"max", sample.max}};
}

ordered_json stages_json(const std::vector<StageStats>& stages) {
    ordered_json list = ordered_json::array();
    for (const StageStats& stage : stages) {
        list.push_back({{"name", stage.name},
                        {"device_ms", stage.device_ms},
                        {"host_ms", stage.host_ms},
                        {"launches", stage.launches}});
    }
    return list;
}

ordered_json result_json(const BuildResult& result) {
    ordered_json json{
        {"scene", result.scene},
        {"triangles", result.triangles},
        {"builder", result.builder},
        {"shape", to_string(result.shape)},
        {"radius", result.radius},
        {"build_ms", sample_json(result.build_ms)},
        {"mtris_per_s", result.mtris_per_s()},
        {"stages", stages_json(result.stages)},
        {"launches", result.launches},
        {"iterations", result.iterations},
        {"sah", result.sah},
        {"depth", result.depth},
        {"nodes", result.nodes},
        {"leaves", result.leaves},
        {"peak_bytes_per_primitive", result.peak_bytes_per_primitive()},
        {"inactive_primitives", result.inactive_primitives},
    };
    if (result.valid) json["valid"] = *result.valid;
    if (result.first_build_ms) json["first_build_ms"] = *result.first_build_ms;
    if (result.native_sort_ms) json["native_sort_ms"] = sample_json(*result.native_sort_ms);
    return json;
}

}  // namespace

ordered_json to_json(const DeviceInfo& device) {
    return {
        {"index", device.index},
        {"name", device.name},
        {"vendor", device.vendor},
        {"platform", device.platform},
        {"version", device.version},
        {"driver_version", device.driver_version},
        {"type", to_string(device.type)},
        {"compute_units", device.compute_units},
        {"max_work_group_size", device.max_work_group_size},
        {"local_memory_bytes", device.local_memory_bytes},
        {"global_memory_bytes", device.global_memory_bytes},
        {"max_allocation_bytes", device.max_allocation_bytes},
        {"int64_atomics", device.int64_atomics},
    };
}

ordered_json to_json(const DeviceInfo& device, std::span<const BuildResult> results) {
    ordered_json list = ordered_json::array();
    for (const BuildResult& result : results)
        list.push_back(result_json(result));
    return {{"device", to_json(device)}, {"results", std::move(list)}};
}

}  // namespace clbvh::tool
