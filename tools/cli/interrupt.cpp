#include "cli/interrupt.hpp"

#include <signal.h>

#include <atomic>
#include <clbvh/core/error.hpp>

namespace clbvh::tool {
namespace {

std::atomic<int> first_signal{0};
static_assert(std::atomic<int>::is_always_lock_free, "the signal handler may touch nothing else");

void note_signal(int number) {
    first_signal.store(number, std::memory_order_relaxed);
}

}  // namespace

void catch_interrupts() {
    struct sigaction action {};
    action.sa_handler = note_signal;
    action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
    for (const int number : {SIGINT, SIGTERM})
        sigaction(number, &action, nullptr);
}

bool interrupted() noexcept {
    return interrupting_signal() != 0;
}

int interrupting_signal() noexcept {
    return first_signal.load(std::memory_order_relaxed);
}

void throw_if_interrupted() {
    if (interrupted()) throw Error(ErrorCode::cancelled, "interrupted");
}

}  // namespace clbvh::tool
