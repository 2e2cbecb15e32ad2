#pragma once

#include <chrono>
#include <string_view>

namespace clbvh::tool {

/// A bar on standard error where that is a terminal; nothing elsewhere. Erases itself when destroyed.
class ProgressBar {
public:
    ProgressBar();
    ProgressBar(const ProgressBar&) = delete;
    ProgressBar& operator=(const ProgressBar&) = delete;
    ~ProgressBar();

    /// Shows `fraction`, 0 to 1, and what is at work. Redraws so seldom that it costs a build nothing.
    void show(double fraction, std::string_view label);
    /// The same without fail, for what may show nothing else for a long time.
    void show_now(double fraction, std::string_view label);
    /// Leaves a clean line for other output.
    void erase();

private:
    bool terminal_;
    bool visible_ = false;
    std::chrono::steady_clock::time_point next_draw_{};
};

}  // namespace clbvh::tool
