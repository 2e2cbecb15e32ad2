#include "tools/result_fields.hpp"

#include <catch2/catch.hpp>
#include <clbvh/options.hpp>

namespace clbvh::test {
namespace {

using nlohmann::ordered_json;
using Names = std::vector<std::string>;

void check_sample(const ordered_json& sample) {
    CHECK(field_names(sample) == Names{"median", "min", "max"});
    CHECK(sample["min"].get<double>() > 0.0);
    CHECK(sample["min"].get<double>() <= sample["median"].get<double>());
    CHECK(sample["median"].get<double>() <= sample["max"].get<double>());
}

bool ran_on_device(const ordered_json& result) {
    return result["kind"] == "device";
}

/// The bytes that a stage moved, and their speed: its own time's, and relative to the copy's where there was one.
void check_traffic(const ordered_json& stage, const ordered_json& result) {
    CHECK(stage["bytes_moved"].get<std::uint64_t>() > 0);
    const double speed = stage["gb_per_s"];
    CHECK(speed == Approx(stage["bytes_moved"].get<double>() * 1e-6 / stage["device_ms"].get<double>()));
    if (stage.contains("of_copy"))
        CHECK(stage["of_copy"].get<double>() == Approx(speed / result["copy_gb_per_s"]["median"].get<double>()));
}

void check_device_stages(const ordered_json& result) {
    Names names;
    std::uint64_t launches = 0;
    for (const ordered_json& stage : result["stages"]) {
        Names fields{"name", "device_ms", "host_ms", "launches", "bytes_moved", "gb_per_s"};
        if (result.contains("copy_gb_per_s")) fields.emplace_back("of_copy");
        REQUIRE(field_names(stage) == fields);
        check_traffic(stage, result);
        CHECK(stage["device_ms"].is_number_float());
        CHECK(stage["host_ms"].is_number_float());
        CHECK(stage["launches"].is_number_unsigned());
        names.push_back(stage["name"]);
        launches += stage["launches"].get<std::uint64_t>();
    }
    CHECK(names == Names{"bounds", "morton", "sort", "cluster", "root"});
    CHECK(result["launches"] == launches);
}

void check_host_stages(const ordered_json& result) {
    REQUIRE_FALSE(result["stages"].empty());
    CHECK(result["stages"][0]["name"] == "bounds");
    for (const ordered_json& stage : result["stages"]) {
        CHECK(field_names(stage) == Names{"name", "host_ms"});
        CHECK_FALSE(stage["name"].get<std::string>().empty());
        CHECK(stage["host_ms"].get<double>() >= 0.0);
    }
}

/// Names of the fields of every result, in their order.
Names common_names(bool on_device, bool is_peer) {
    Names names{"scene", "triangles", "builder", "kind"};
    const Names identity = on_device ? Names{"shape", "radius"} : Names{"peer", "threads"};
    const Names options = is_peer ? Names{} : Names{"optimizers", "optimize_passes", "max_leaf_size", "split_quota"};
    const Names cost{"build_ms", "mtris_per_s", "stages"};
    const Names launches = on_device ? Names{"launch_overhead_ms", "launches", "iterations"} : Names{};
    const Names tree{
        "sah", "ray_cost", "depth", "nodes", "leaves", "references", "peak_bytes_per_primitive", "inactive_primitives"};
    for (const Names& part : {identity, options, cost, launches, tree})
        names.insert(names.end(), part.begin(), part.end());
    return names;
}

void check_identity(const ordered_json& result) {
    if (ran_on_device(result)) {
        CHECK((result["shape"] == "group" || result["shape"] == "lane"));
        CHECK(result["radius"].is_number_unsigned());
        CHECK(result["iterations"].is_number_unsigned());
        CHECK(result["launch_overhead_ms"]["median"].get<double>() >= 0.0);
        CHECK(result["launch_overhead_ms"]["max"].get<double>() <= result["build_ms"]["max"].get<double>());
    } else {
        CHECK(result["kind"] == "host");
        CHECK(result["peer"].is_boolean());
        CHECK(result["threads"].get<std::uint64_t>() > 0);
    }
}

}  // namespace

Names field_names(const ordered_json& object) {
    Names names;
    for (const auto& field : object.items())
        names.push_back(field.key());
    return names;
}

void check_result(const ordered_json& result, const Names& extra) {
    INFO(result.dump(2));
    const bool on_device = ran_on_device(result);
    Names names = common_names(on_device, result.value("peer", false));
    names.insert(names.end(), extra.begin(), extra.end());
    REQUIRE(field_names(result) == names);
    for (const char* name : {"scene", "builder"})
        CHECK(result[name].is_string());
    for (const char* name : {"triangles", "depth", "nodes", "leaves", "references", "inactive_primitives"}) {
        INFO(name);
        CHECK(result[name].is_number_unsigned());
    }
    check_identity(result);
    check_sample(result["build_ms"]);
    if (on_device) {
        check_device_stages(result);
    } else {
        check_host_stages(result);
    }
    const double triangles = result["triangles"];
    CHECK(result["mtris_per_s"].get<double>() == Approx(triangles / result["build_ms"]["median"].get<double>() / 1e3));
    const std::uint64_t active =
        result["triangles"].get<std::uint64_t>() - result["inactive_primitives"].get<std::uint64_t>();
    CHECK(result["references"] >= active);
    CHECK(result["leaves"] <= result["references"]);
    CHECK(result["nodes"] == 2 * result["leaves"].get<std::uint64_t>() - 1);
    CHECK(result["sah"].get<double>() > 1.0);
    CHECK(result["ray_cost"].get<double>() > 1.0);
    // The finished nodes of a device builder are 64 bytes per primitive; a host builder's references alone are 32.
    CHECK(result["peak_bytes_per_primitive"].get<double>() >= (on_device ? 64.0 : 32.0));
}

void check_options(const ordered_json& options) {
    INFO(options.dump(2));
    REQUIRE(options.size() == clbvh::options().size());
    for (const OptionInfo& option : clbvh::options()) {
        INFO(option.name);
        const ordered_json& value = options.at(std::string(option.name));
        CHECK(value.is_number_unsigned() == (option.type == OptionType::whole));
        CHECK(value.is_number_float() == (option.type == OptionType::real));
        CHECK(value.is_boolean() == (option.type == OptionType::boolean));
        CHECK(value.is_string() == (option.type == OptionType::choice || option.type == OptionType::text));
    }
}

void check_device(const ordered_json& device) {
    INFO(device.dump(2));
    for (const char* name : {"name", "vendor", "platform", "version", "driver_version", "type"}) {
        INFO(name);
        CHECK(device.at(name).is_string());
    }
    for (const char* name : {"index", "compute_units", "max_work_group_size", "local_memory_bytes",
                             "global_memory_bytes", "max_allocation_bytes"}) {
        INFO(name);
        CHECK(device.at(name).is_number_unsigned());
    }
    CHECK(device.at("int64_atomics").is_boolean());
}

}  // namespace clbvh::test
