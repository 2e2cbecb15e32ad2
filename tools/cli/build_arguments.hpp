#pragma once

#include <clbvh/options.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cli/cli_fwd.hpp"

namespace clbvh::tool {

/// The arguments of every command that builds: where, and how.
class BuildArguments {
public:
    std::string device;  ///< A selector as pick_device() takes it.
    BuildOptions options;

    /// Adds the table of options to a command, with what `options` holds as defaults; parsing fills this object.
    void add_options(CLI::App& command);
    /// Throws what check_options and set_option throw, with the name of the command line's option in front.
    void check() const;
    /// Tells standard error of each option that was given and that none of these builders reads.
    void note_unread(std::span<const std::string> builders) const;

private:
    /// Options with one flag, which sets all of them.
    using Rows = std::vector<const OptionInfo*>;

    void add_rows(CLI::App& command, const Rows& rows);
    void set(const Rows& rows, const std::string& value);

    std::vector<Rows> given_;
    std::string refusal_;  ///< Of the first value that is out of its range; empty where none is.
};

}  // namespace clbvh::tool
