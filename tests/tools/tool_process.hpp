#pragma once

#include <signal.h>
#include <sys/types.h>

#include <cstdio>
#include <memory>
#include <string>
#include <vector>

namespace clbvh::test {

/// Result of a run of the command.
struct Outcome {
    int exit_code = 0;  ///< Minus the signal's number where one ended the process.
    std::string out;    ///< Standard output.
    std::string err;    ///< Standard error; empty where it was a terminal.
};

/// A running `clbvh`. Its output goes to unnamed files, so that a full pipe never stops it.
class ToolProcess {
public:
    /// `environment` holds NAME=VALUE entries added to this process's. `stderr_fd` and `stdout_fd` take
    /// standard error and output where >= 0.
    explicit ToolProcess(const std::vector<std::string>& arguments, const std::vector<std::string>& environment = {},
                         int stderr_fd = -1, int stdout_fd = -1);
    ToolProcess(const ToolProcess&) = delete;
    ToolProcess& operator=(const ToolProcess&) = delete;
    ~ToolProcess();

    /// Sends Ctrl-C's signal, or another that ends programs, as soon as the process handles it itself.
    void interrupt(int signal = SIGINT) const;
    [[nodiscard]] Outcome wait();

private:
    struct Close {
        void operator()(std::FILE* file) const { std::fclose(file); }
    };

    std::unique_ptr<std::FILE, Close> out_;
    std::unique_ptr<std::FILE, Close> err_;
    pid_t pid_ = -1;
};

/// Runs `clbvh` to its end.
[[nodiscard]] Outcome run_tool(const std::vector<std::string>& arguments,
                               const std::vector<std::string>& environment = {});

}  // namespace clbvh::test
