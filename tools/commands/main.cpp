#include <fmt/core.h>

#include <clbvh/version.h>
#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "cli/complain.hpp"
#include "cli/exit_code.hpp"
#include "cli/interrupt.hpp"
#include "commands/command.hpp"

namespace clbvh::tool {
namespace {

int run(const Command& command) {
    try {
        return command.run();
    } catch (const std::exception& error) {
        // A Ctrl-C also reaches the compiler that a driver may have started, whose failure then looks like any other.
        if (interrupted()) {
            complain("cancelled");
            return kExitOnSignal + interrupting_signal();
        }
        complain(fmt::format("error: {}", error.what()));
        return kExitFailure;
    }
}

int usage_error(std::string_view message) {
    complain(fmt::format("error: {}\nRun clbvh --help, or --help after a command.", message));
    return kExitUsage;
}

std::vector<Command> add_commands(CLI::App& app) {
    std::vector<Command> commands{add_devices_command(app), add_builders_command(app), add_options_command(app),
                                  add_scenes_command(app),  add_info_command(app),     add_build_command(app),
                                  add_bench_command(app)};
#if !defined(CLBVH_NO_OPENCL)
    commands.push_back(add_tune_command(app));  // which is about devices alone
#endif
    for (const auto add :
         {add_trace_command, add_render_command, add_metrics_command, add_table_command, add_dump_command})
        commands.push_back(add(app));
    return commands;
}

int parse_and_run(int argc, char** argv) {
    CLI::App app{"Builds bounding volume hierarchies for ray tracing with OpenCL, on GPUs and CPUs.", "clbvh"};
    app.set_version_flag("--version", std::string("clbvh ") + clbvh_version_string());
    app.require_subcommand(0, 1);
    const std::vector<Command> commands = add_commands(app);
    try {
        app.parse(argc, argv);
    } catch (const CLI::Success& help_or_version) {
        return app.exit(help_or_version);
    } catch (const CLI::ParseError& error) {
        return usage_error(error.what());
    }
    for (const Command& command : commands) {
        if (command.arguments->parsed()) return run(command);
    }
    return usage_error("a command is missing");
}

/// Output may still be in a buffer, so that a full disk is seen only now.
int finish_standard_output(int code) {
    const bool flushed = std::fflush(stdout) == 0;
    const int reason = errno;
    // Where the command failed, it has said why.
    if ((flushed && std::ferror(stdout) == 0) || code == kExitFailure) return code;
    complain(fmt::format("error: cannot write standard output{}{}", flushed ? "" : ": ",
                         flushed ? "" : std::generic_category().message(reason)));
    return code == kExitSuccess ? kExitFailure : code;
}

}  // namespace
}  // namespace clbvh::tool

int main(int argc, char** argv) {
    // PoCL pins its threads only where this is set before the first OpenCL call; else short kernels often share a core.
    setenv("POCL_AFFINITY", "1", 0);
    clbvh::tool::catch_interrupts();
    return clbvh::tool::finish_standard_output(clbvh::tool::parse_and_run(argc, argv));
}
