#include "report/result_json.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "measure/machine.hpp"

namespace clbvh::tool {
namespace {

using nlohmann::ordered_json;

/// The double that is written with as few digits as the float: 1.2, not 1.2000000476837158.
double shortest(float value) {
    return std::stod(fmt::format("{}", value));
}

/// The bytes that the stage's kernels moved, and their speed: absolute, and relative to a copy where one was measured.
void set_traffic(ordered_json& entry, const StageStats& stage, const std::optional<Sample>& copy_gb_per_s) {
    entry["launches"] = stage.launches;
    entry["bytes_moved"] = stage.bytes_moved;
    const double speed = gb_per_s(stage);
    if (!std::isfinite(speed)) return;
    entry["gb_per_s"] = speed;
    if (copy_gb_per_s) entry["of_copy"] = speed / copy_gb_per_s->median;
}

ordered_json stages_json(const BuildResult& result) {
    ordered_json list = ordered_json::array();
    for (const StageStats& stage : result.stages) {
        ordered_json entry{{"name", stage.name}};
        if (result.kind == BuilderKind::device) entry["device_ms"] = stage.device_ms;
        entry["host_ms"] = stage.host_ms;
        if (result.kind == BuilderKind::device) set_traffic(entry, stage, result.copy_gb_per_s);
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
    if (result.options) {
        json["optimizers"] = result.options->optimizers;
        json["optimize_passes"] = result.options->optimize_passes;
        json["max_leaf_size"] = result.options->max_leaf_size;
        json["split_quota"] = shortest(result.options->split_quota);
    }
    return json;
}

void set_tree(ordered_json& json, const BuildResult& result) {
    json["sah"] = result.sah;
    json["ray_cost"] = result.ray_cost;
    json["depth"] = result.depth;
    json["nodes"] = result.nodes;
    json["leaves"] = result.leaves;
    json["references"] = result.references;
}

ordered_json result_json(const BuildResult& result) {
    ordered_json json = identity_json(result);
    json["build_ms"] = sample_json(result.build_ms);
    json["mtris_per_s"] = result.mtris_per_s();
    json["stages"] = stages_json(result);
    if (result.kind == BuilderKind::device) {
        json["launch_overhead_ms"] = sample_json(result.launch_overhead_ms);
        json["launches"] = result.launches;
        json["iterations"] = result.iterations;
    }
    if (result.has_tree) set_tree(json, result);
    json["peak_bytes_per_primitive"] = result.peak_bytes_per_primitive();
    json["inactive_primitives"] = result.inactive_primitives;
    if (result.has_tree && result.valid) json["valid"] = *result.valid;
    if (result.first_build_ms) json["first_build_ms"] = *result.first_build_ms;
    if (result.native_sort_ms) json["native_sort_ms"] = sample_json(*result.native_sort_ms);
    if (result.copy_gb_per_s) json["copy_gb_per_s"] = sample_json(*result.copy_gb_per_s);
    if (result.rays) {
        json["ray_count"] = result.rays->ray_count;
        json["mrays_per_s"] = result.rays->mrays_per_s();
        json["ns_per_ray"] = result.rays->ns_per_ray();
        json["binary_ns_per_ray"] = result.binary_ns_per_ray;
        json["steps_per_ray"] = result.rays->steps_per_ray();
        json["triangles_per_ray"] = result.rays->triangles_per_ray;
    }
    if (result.sweep) json["sweep"] = {{"what", result.sweep->what}, {"value", result.sweep->value}};
    return json;
}

ordered_json option_json(const OptionInfo& option, const std::string& value) {
    switch (option.type) {
        case OptionType::whole: return std::stoul(value);
        case OptionType::real: return std::stod(value);
        case OptionType::boolean: return value == "on";
        case OptionType::choice:
        case OptionType::text: break;
    }
    return value;
}

ordered_json options_json(const BuildOptions& options) {
    ordered_json json;
    for (const OptionInfo& option : clbvh::options())
        json[std::string(option.name)] = option_json(option, get_option(options, option.name));
    return json;
}

/// The file of the profile in use, else null.
ordered_json profile_json(const std::optional<Context>& context) {
    if (!context || !context->profile().profile) return nullptr;
    return context->profile().path.string();
}

}  // namespace

ordered_json sample_json(const Sample& sample) {
    return {{"median", sample.median}, {"min", sample.min}, {"max", sample.max}};
}

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

ordered_json document_json(const std::optional<Context>& context, const SceneArguments& loading,
                           const BuildOptions& options, ordered_json results) {
    return {{"machine", to_json(describe_machine(), context)},
            {"device", context ? to_json(context->device()) : ordered_json()},
            {"profile", profile_json(context)},
            {"rotate_degrees", loading.rotate_degrees},
            {"options", options_json(options)},
            {"results", std::move(results)}};
}

ordered_json to_json(std::span<const BuildResult> results) {
    ordered_json list = ordered_json::array();
    for (const BuildResult& result : results)
        list.push_back(result_json(result));
    return list;
}

}  // namespace clbvh::tool
