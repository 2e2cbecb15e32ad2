#include "cli/progress_bar.hpp"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <cstdio>

namespace clbvh::tool {
namespace {

constexpr std::size_t kWidth = 40;
constexpr std::chrono::milliseconds kDrawInterval{50};

}  // namespace

ProgressBar::ProgressBar() : terminal_(isatty(STDERR_FILENO) == 1) {}

ProgressBar::~ProgressBar() {
    erase();
}

void ProgressBar::show(double fraction, std::string_view label) {
    if (terminal_ && std::chrono::steady_clock::now() >= next_draw_) show_now(fraction, label);
}

void ProgressBar::show_now(double fraction, std::string_view label) {
    if (!terminal_) return;
    next_draw_ = std::chrono::steady_clock::now() + kDrawInterval;
    const double part = std::clamp(fraction, 0.0, 1.0);
    const auto filled = static_cast<std::size_t>(part * static_cast<double>(kWidth));
    const std::string line =
        fmt::format("\r[{:#>{}}{:.>{}}] {:3.0f}% {}\x1b[K", "", filled, "", kWidth - filled, part * 100.0, label);
    std::fputs(line.c_str(), stderr);  // a terminal may be gone
    std::fflush(stderr);
    visible_ = true;
}

void ProgressBar::erase() {
    if (!visible_) return;
    std::fputs("\r\x1b[K", stderr);
    std::fflush(stderr);
    visible_ = false;
}

}  // namespace clbvh::tool
