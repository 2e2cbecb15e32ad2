#include "optimize/pass_clock.hpp"

#include <algorithm>
#include <string>

#include "core/check_field.hpp"

namespace clbvh::optimizer {

void check_budget(const OptimizeBudget& budget) {
    // Infinity is a time like any other. A NaN is not 0 or more.
    if (budget.milliseconds >= 0.0) return;
    reject_field("budget.milliseconds", std::to_string(budget.milliseconds), "0 or more");
}

PassClock::PassClock(std::string_view name, const OptimizeBudget& budget, std::uint32_t own_limit)
    : name_(name), budget_(budget), most_passes_(budget.passes > 0 ? budget.passes : own_limit) {}

double PassClock::elapsed_ms() const {
    return std::chrono::duration<double, std::milli>(Clock::now() - begin_).count();
}

bool PassClock::may_begin_pass() {
    return stats_.passes < most_passes_ && may_go_on(0.0);
}

bool PassClock::may_go_on(double part) {
    const double elapsed = elapsed_ms();
    const bool has_limit = budget_.milliseconds > 0.0;
    if (budget_.progress && !stats_.is_cancelled) {
        const double by_passes = (stats_.passes + part) / std::max(1u, most_passes_);
        const double by_time = has_limit ? elapsed / budget_.milliseconds : 0.0;
        stats_.is_cancelled = !budget_.progress({name_, std::min(1.0, std::max(by_passes, by_time))});
    }
    return !stats_.is_cancelled && !(has_limit && elapsed >= budget_.milliseconds);
}

void PassClock::end_pass(std::uint64_t changes) {
    ++stats_.passes;
    stats_.changes += changes;
}

OptimizeStats PassClock::finish() {
    stats_.milliseconds = elapsed_ms();
    return stats_;
}

}  // namespace clbvh::optimizer
