#include "tools/tool_process.hpp"

#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdint>
#include <fstream>
#include <stdexcept>
#include <system_error>
#include <thread>

namespace clbvh::test {
namespace {

std::vector<char*> pointers(std::vector<std::string>& strings) {
    std::vector<char*> result;
    for (std::string& string : strings)
        result.push_back(string.data());
    result.push_back(nullptr);
    return result;
}

/// Later entries of the same name would lose, so the caller's come first.
std::vector<std::string> with_own_environment(std::vector<std::string> entries) {
    for (char** entry = environ; *entry != nullptr; ++entry)
        entries.emplace_back(*entry);
    return entries;
}

std::string read_all(std::FILE* file) {
    std::string text;
    std::rewind(file);
    for (int c = std::fgetc(file); c != EOF; c = std::fgetc(file))
        text += static_cast<char>(c);
    return text;
}

/// True where the process has a handler of its own for `signal`, as the kernel reports it.
bool handles(pid_t pid, int signal) {
    std::ifstream status("/proc/" + std::to_string(pid) + "/status");
    const std::string label = "SigCgt:";
    for (std::string line; std::getline(status, line);) {
        if (!line.starts_with(label)) continue;
        return (std::stoull(line.substr(label.size()), nullptr, 16) >> (signal - 1)) % 2 == 1;
    }
    return false;
}

}  // namespace

ToolProcess::ToolProcess(const std::vector<std::string>& arguments, const std::vector<std::string>& environment,
                         int stderr_fd, int stdout_fd)
    : out_(std::tmpfile()), err_(std::tmpfile()) {
    if (!out_ || !err_) throw std::system_error(errno, std::generic_category(), "tmpfile");
    std::vector<std::string> words{"clbvh"};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<std::string> variables = with_own_environment(environment);

    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, stdout_fd >= 0 ? stdout_fd : fileno(out_.get()), STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&actions, stderr_fd >= 0 ? stderr_fd : fileno(err_.get()), STDERR_FILENO);
    const int error =
        posix_spawn(&pid_, CLBVH_TOOL, &actions, nullptr, pointers(words).data(), pointers(variables).data());
    posix_spawn_file_actions_destroy(&actions);
    if (error != 0) throw std::system_error(error, std::generic_category(), CLBVH_TOOL);
}

ToolProcess::~ToolProcess() {
    if (pid_ < 0) return;
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
}

void ToolProcess::interrupt(int signal) const {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(30);
    while (!handles(pid_, signal)) {
        if (std::chrono::steady_clock::now() > deadline) throw std::runtime_error("the tool never handled the signal");
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    kill(pid_, signal);
}

Outcome ToolProcess::wait() {
    int status = 0;
    waitpid(pid_, &status, 0);
    pid_ = -1;
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status), read_all(out_.get()), read_all(err_.get())};
}

Outcome run_tool(const std::vector<std::string>& arguments, const std::vector<std::string>& environment) {
    return ToolProcess(arguments, environment).wait();
}

}  // namespace clbvh::test
