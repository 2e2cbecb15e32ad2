#pragma once

#include <chrono>
#include <string_view>

#include "clbvh/optimize/budget.hpp"

namespace clbvh::optimizer {

/// Throws Error(invalid_input) where the budget's time is negative or not a number.
void check_budget(const OptimizeBudget& budget);

/// Keeps an optimiser within its budget, and the books of it.
class PassClock {
public:
    /// `own_limit` is the most passes where the budget sets none.
    PassClock(std::string_view name, const OptimizeBudget& budget, std::uint32_t own_limit);

    /// True where another pass may begin.
    [[nodiscard]] bool may_begin_pass();
    /// True where the pass may go on; `part` of it, 0 to 1, is done. On the calling thread only.
    [[nodiscard]] bool may_go_on(double part);
    /// Books a finished pass.
    void end_pass(std::uint64_t changes);
    /// Books what a pass did that the budget ended.
    void break_off_pass(std::uint64_t changes) { stats_.changes += changes; }
    [[nodiscard]] OptimizeStats finish();

private:
    using Clock = std::chrono::steady_clock;

    [[nodiscard]] double elapsed_ms() const;

    std::string_view name_;
    const OptimizeBudget& budget_;
    std::uint32_t most_passes_;
    Clock::time_point begin_ = Clock::now();
    OptimizeStats stats_;
};

}  // namespace clbvh::optimizer
