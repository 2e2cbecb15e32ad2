#pragma once

#include <clbvh/core/build_options.hpp>
#include <functional>
#include <string>
#include <vector>

#include "cli/cli_fwd.hpp"

namespace clbvh::tool {

/// What every command that builds is told: where, and how.
class BuildArguments {
public:
    std::string device;  ///< A selector as pick_device() takes it.
    BuildOptions options;

    /// Adds the options to a command; parsing fills this object.
    void add_options(CLI::App& command);
    /// Throws what check_options throws, with the name of the command line's option in front.
    void check() const;

private:
    /// An option that check_options may refuse, and how to copy its value alone.
    struct Checked {
        std::string name;
        std::function<void(const BuildOptions& from, BuildOptions& to)> copy;
    };

    void add_device_options(CLI::App& command);
    void add_device_tuning(CLI::App& command);
    void add_hploc_options(CLI::App& command);
    void add_tree_options(CLI::App& command);
    void add_host_options(CLI::App& command);
    /// An option with a number; `field` is a member of BuildOptions.
    template <typename Field>
    CLI::Option* add_number(CLI::App& command, const std::string& name, Field field, const std::string& help);

    std::vector<Checked> checked_;
};

}  // namespace clbvh::tool
