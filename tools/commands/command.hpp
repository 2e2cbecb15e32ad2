#pragma once

#include <functional>

#include "cli/cli_fwd.hpp"

namespace clbvh::tool {

/// One subcommand: its arguments, and what it does once they are parsed. run() returns the exit code.
struct Command {
    CLI::App* arguments;
    std::function<int()> run;
};

Command add_devices_command(CLI::App& app);
Command add_builders_command(CLI::App& app);
Command add_options_command(CLI::App& app);
Command add_scenes_command(CLI::App& app);
Command add_info_command(CLI::App& app);
Command add_build_command(CLI::App& app);
Command add_dump_command(CLI::App& app);
Command add_bench_command(CLI::App& app);
Command add_tune_command(CLI::App& app);
Command add_trace_command(CLI::App& app);
Command add_render_command(CLI::App& app);
Command add_metrics_command(CLI::App& app);
Command add_table_command(CLI::App& app);

}  // namespace clbvh::tool
