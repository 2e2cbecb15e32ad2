#pragma once

#include <CLI/CLI.hpp>
#include <clbvh/core/build_options.hpp>
#include <string>

namespace clbvh::tool {

/// What every command that builds is told: where, and how.
struct BuildArguments {
    std::string device;  ///< A selector as pick_device() takes it.
    BuildOptions options;

    /// Adds the options to a command; parsing fills this object.
    void add_options(CLI::App& command);
};

}  // namespace clbvh::tool
