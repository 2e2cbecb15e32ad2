#include "cli/interrupt.hpp"

#include <signal.h>

#include <atomic>
#include <clbvh/core/error.hpp>

namespace clbvh::tool {
namespace {

std::atomic<bool> interrupt_flag{false};
static_assert(std::atomic<bool>::is_always_lock_free, "the signal handler may touch nothing else");

void set_interrupt_flag(int) {
    interrupt_flag.store(true, std::memory_order_relaxed);
}

}  // namespace

void catch_interrupts() {
    struct sigaction action {};
    action.sa_handler = set_interrupt_flag;
    action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
    sigaction(SIGINT, &action, nullptr);
}

bool interrupted() noexcept {
    return interrupt_flag.load(std::memory_order_relaxed);
}

void throw_if_interrupted() {
    if (interrupted()) throw Error(ErrorCode::cancelled, "interrupted");
}

}  // namespace clbvh::tool
