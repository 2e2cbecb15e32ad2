#include "measure/rounds.hpp"

#include <fmt/format.h>

#include "cli/interrupt.hpp"

namespace clbvh::tool {

void RoundsProgress::begin_turn(double begin, double end, std::size_t round, std::string_view name) {
    begin_ = begin;
    end_ = end;
    const std::string what = round == 0 ? "warm-up" : fmt::format("run {}", round);
    label_ = fmt::format("{}, {}, {}", title_, what, name);
    bar_.show_now(begin, label_);
}

void run_rounds(std::span<Contestant* const> contestants, std::size_t runs, RoundsProgress& progress) {
    const std::size_t count = contestants.size();
    const auto part = [turns = static_cast<double>((runs + 1) * count)](std::size_t turn) {
        return static_cast<double>(turn) / turns;
    };
    for (std::size_t round = 0; round <= runs; ++round) {
        for (std::size_t turn = 0; turn < count; ++turn) {
            Contestant& contestant = *contestants[(turn + round) % count];
            const std::size_t done = round * count + turn;
            progress.begin_turn(part(done), part(done + 1), round, contestant.name());
            throw_if_interrupted();
            contestant.run(round > 0);
        }
    }
}

}  // namespace clbvh::tool
