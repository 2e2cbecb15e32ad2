#include "result_fields.hpp"

#include <catch2/catch.hpp>

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

void check_stages(const ordered_json& result) {
    Names names;
    std::uint64_t launches = 0;
    for (const ordered_json& stage : result["stages"]) {
        CHECK(field_names(stage) == Names{"name", "device_ms", "host_ms", "launches"});
        CHECK(stage["device_ms"].is_number_float());
        CHECK(stage["host_ms"].is_number_float());
        CHECK(stage["launches"].is_number_unsigned());
        names.push_back(stage["name"]);
        launches += stage["launches"].get<std::uint64_t>();
    }
    CHECK(names == Names{"bounds", "morton", "sort", "cluster", "layout"});
    CHECK(result["launches"] == launches);
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
    Names names{"scene",
                "triangles",
                "builder",
                "shape",
                "radius",
                "build_ms",
                "mtris_per_s",
                "stages",
                "launches",
                "iterations",
                "sah",
                "depth",
                "nodes",
                "leaves",
                "peak_bytes_per_primitive",
                "inactive_primitives"};
    names.insert(names.end(), extra.begin(), extra.end());
    CHECK(field_names(result) == names);
    for (const char* name : {"scene", "builder"})
        CHECK(result[name].is_string());
    for (const char* name :
         {"triangles", "radius", "launches", "iterations", "depth", "nodes", "leaves", "inactive_primitives"}) {
        INFO(name);
        CHECK(result[name].is_number_unsigned());
    }
    CHECK((result["shape"] == "group" || result["shape"] == "lane"));
    check_sample(result["build_ms"]);
    check_stages(result);
    const double triangles = result["triangles"];
    CHECK(result["mtris_per_s"].get<double>() == Approx(triangles / result["build_ms"]["median"].get<double>() / 1e3));
    CHECK(result["leaves"] ==
          result["triangles"].get<std::uint64_t>() - result["inactive_primitives"].get<std::uint64_t>());
    CHECK(result["nodes"] == 2 * result["leaves"].get<std::uint64_t>() - 1);
    CHECK(result["sah"].get<double>() > 1.0);
    // The finished nodes alone are 64 bytes per primitive.
    CHECK(result["peak_bytes_per_primitive"].get<double>() >= 64.0);
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
