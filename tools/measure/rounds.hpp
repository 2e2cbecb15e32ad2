#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "cli/progress_bar.hpp"
#include "measure/contestant.hpp"

namespace clbvh::tool {

/// How far all rounds together are, shown in a bar.
class RoundsProgress {
public:
    /// `title` says what is measured; it and `bar` outlive this object.
    RoundsProgress(std::string_view title, ProgressBar& bar) : title_(title), bar_(bar) {}

    /// One contestant's turn begins; `begin` to `end` is its part of all the rounds.
    void begin_turn(double begin, double end, std::size_t round, std::string_view name);
    /// `part` of the turn is done.
    void show(double part) { bar_.show(begin_ + part * (end_ - begin_), label_); }

private:
    std::string_view title_;
    ProgressBar& bar_;
    double begin_ = 0.0;
    double end_ = 0.0;
    std::string label_;
};

/// Runs each contestant once a round, and begins each round with another one, so that all meet the same noise and every
/// neighbour. The first round warms up and is not counted; `runs` rounds follow. Throws Error(cancelled) after a
/// Ctrl-C.
void run_rounds(std::span<Contestant* const> contestants, std::size_t runs, RoundsProgress& progress);

}  // namespace clbvh::tool
