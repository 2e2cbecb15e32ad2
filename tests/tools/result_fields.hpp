#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace clbvh::test {

/// Names of an object's fields, in the order in which they were written.
[[nodiscard]] std::vector<std::string> field_names(const nlohmann::ordered_json& object);

/// Checks the names, the types and the arithmetic of one entry of "results". `extra` are the fields after the ones that
/// every result has.
void check_result(const nlohmann::ordered_json& result, const std::vector<std::string>& extra);

/// Checks the names and the types of "options".
void check_options(const nlohmann::ordered_json& options);

/// Checks the fields of "device".
void check_device(const nlohmann::ordered_json& device);

}  // namespace clbvh::test
