#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "cli/cli_fwd.hpp"

namespace clbvh::tool {

/// Where a command's JSON goes: nowhere, to a file, or ("-") to standard output, which then carries nothing else.
class JsonOutput {
public:
    /// Adds --json to a command; parsing fills this object.
    void add_option(CLI::App& command);

    /// Throws Error(io) where write() could not succeed, so that a typing error is found before the long work.
    void require_writable() const;
    /// False where text for people has to stay away from standard output.
    [[nodiscard]] bool leaves_standard_output() const { return target_ != "-"; }
    /// Writes `document` where one was asked for. Throws Error(io).
    void write(const nlohmann::ordered_json& document) const;

private:
    std::string target_;
};

}  // namespace clbvh::tool
