#include "cli/json_output.hpp"

#include <CLI/CLI.hpp>
#include <cerrno>
#include <clbvh/core/error.hpp>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <system_error>

#include "cli/output_file.hpp"

namespace clbvh::tool {
namespace {

namespace fs = std::filesystem;

void write_to_stream(std::ostream& stream, const std::string& text, const std::string& name) {
    if (!(stream << text << std::flush)) {
        throw Error(ErrorCode::io, "cannot write '" + name + "': " + std::generic_category().message(errno));
    }
}

}  // namespace

void JsonOutput::add_option(CLI::App& command) {
    command.add_option("--json", target_, "Write the result as JSON; - is standard output, and silences the rest")
        ->type_name("FILE");
}

bool JsonOutput::target_is_special() const {
    std::error_code ignored;
    const fs::file_status status = fs::status(target_, ignored);
    return fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status);
}

void JsonOutput::require_writable() const {
    if (!target_.empty() && target_ != "-" && !target_is_special()) tool::require_writable(target_);
}

void JsonOutput::write(const nlohmann::ordered_json& document) const {
    if (target_.empty()) return;
    // Paths need not be UTF-8, but JSON is.
    const std::string text = document.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + '\n';
    if (target_ == "-") {
        write_to_stream(std::cout, text, "standard output");
    } else if (target_is_special()) {
        std::ofstream stream(target_);
        write_to_stream(stream, text, target_);
    } else {
        write_file(target_, text);
    }
}

}  // namespace clbvh::tool
