#include "result_json.hpp"

#include <fmt/format.h>

#include <string>

namespace clbvh::tool {
namespace {

using nlohmann::ordered_json;

ordered_json sample_json(const Sample& sample) {
    return {{"median", sample.median}, {"min", sample.min}, {"max", sample.max}};
}

ordered_json stages_json(const BuildResult& result) {
    ordered_json list = ordered_json::array();
    for (const StageStats& stage : result.stages) {
        ordered_json entry{{"name", stage.name}};
        if (result.kind == BuilderKind::device) entry["device_ms"] = stage.device_ms;
        entry["host_ms"] = stage.host_ms;
        if (result.kind == BuilderKind::device) entry["launches"] = stage.launches;
        list.push_back(std::move(entry));
    }
    return list;
}

/// Who built what, and how.
ordered_json identity_json(const BuildResult& result) {
    ordered_json json{
        {"scene", result.scene},
        {"triangles", result.triangles},
        {"builder", result.builder},
        {"kind", to_string(result.kind)},
    };
    if (result.kind == BuilderKind::device) {
        json["shape"] = to_string(result.shape);
        json["radius"] = result.radius;
    } else {
        json["peer"] = result.is_peer;
        json["threads"] = result.threads;
    }
    return json;
}

ordered_json result_json(const BuildResult& result) {
    ordered_json json = identity_json(result);
    json["build_ms"] = sample_json(result.build_ms);
    json["mtris_per_s"] = result.mtris_per_s();
    json["stages"] = stages_json(result);
    if (result.kind == BuilderKind::device) {
        json["launches"] = result.launches;
        json["iterations"] = result.iterations;
    }
    json["sah"] = result.sah;
    json["depth"] = result.depth;
    json["nodes"] = result.nodes;
    json["leaves"] = result.leaves;
    json["references"] = result.references;
    json["peak_bytes_per_primitive"] = result.peak_bytes_per_primitive();
    json["inactive_primitives"] = result.inactive_primitives;
    if (result.valid) json["valid"] = *result.valid;
    if (result.first_build_ms) json["first_build_ms"] = *result.first_build_ms;
    if (result.native_sort_ms) json["native_sort_ms"] = sample_json(*result.native_sort_ms);
    return json;
}

/// The double that is written with as few digits as the float: 1.2, not 1.2000000476837158.
double shortest(float value) {
    return std::stod(fmt::format("{}", value));
}

ordered_json options_json(const BuildOptions& options) {
    return {
        {"inner_cost", shortest(options.inner_cost)},
        {"primitive_cost", shortest(options.primitive_cost)},
        {"max_leaf_size", options.max_leaf_size},
        {"bin_count", options.bin_count},
        {"bin_longest_axis_only", options.bin_longest_axis_only},
        {"split_alpha", shortest(options.split_alpha)},
        {"reference_budget", shortest(options.reference_budget)},
        {"presplit_level", options.presplit_level},
        {"thread_count", options.thread_count},
        {"search_radius", options.search_radius},
        {"shape", to_string(options.shape)},
        {"sort_shape", to_string(options.sort_shape)},
        {"morton_code", to_string(options.morton_code)},
        {"neighbour_encoding", to_string(options.neighbour_encoding)},
        {"neighbour_search", to_string(options.neighbour_search)},
        {"single_group_threshold", options.single_group_threshold},
        {"chunk_size", options.chunk_size},
        {"work_group_size", options.work_group_size},
        {"range_count", options.range_count},
    };
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

ordered_json to_json(const std::optional<Context>& context, const BuildOptions& options,
                     std::span<const BuildResult> results) {
    ordered_json list = ordered_json::array();
    for (const BuildResult& result : results)
        list.push_back(result_json(result));
    return {{"device", context ? to_json(context->device()) : ordered_json()},
            {"options", options_json(options)},
            {"results", std::move(list)}};
}

}  // namespace clbvh::tool
