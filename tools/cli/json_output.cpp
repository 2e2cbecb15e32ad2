#include "cli/json_output.hpp"

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "cli/output_file.hpp"

namespace clbvh::tool {

void JsonOutput::add_option(CLI::App& command) {
    command.add_option("--json", target_, "Write the result as JSON; - is standard output, and silences the rest")
        ->type_name("FILE");
}

void JsonOutput::require_writable() const {
    if (!target_.empty()) require_writable_target(target_);
}

void JsonOutput::write(const nlohmann::ordered_json& document) const {
    if (target_.empty()) return;
    // Paths need not be UTF-8, but JSON is.
    write_target(target_, document.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + '\n');
}

}  // namespace clbvh::tool
