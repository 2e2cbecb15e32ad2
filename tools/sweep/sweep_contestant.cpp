#include "sweep/sweep_contestant.hpp"

#include <fmt/format.h>

#include <clbvh/core/error.hpp>
#include <utility>

#include "cli/open_builder.hpp"

namespace clbvh::tool {

SweepContestant::SweepContestant(Point point, std::optional<Context> context, bool validated)
    : point_(std::move(point)),
      context_(std::move(context)),
      validated_(validated),
      name_(fmt::format("{} at {} {}", point_.builder, point_.swept.what, point_.swept.value)) {}

void SweepContestant::describe(const Builder& builder) {
    if (point_.swept.what == "chunk" && builder.shape() != Shape::lane) {
        throw Error(ErrorCode::unsupported, "--sweep chunk: " + point_.builder + " runs in the " +
                                                std::string(to_string(builder.shape())) +
                                                " shape here, which does not read --chunk; add --shape lane");
    }
    describe_builder(description_, builder);
    describe_tree(description_, builder.download(), *point_.mesh, validated_);
}

void SweepContestant::run(bool counted) {
    Builder builder = open_builder(point_.builder, context_, point_.options);
    builder.upload(*point_.mesh);
    static_cast<void>(builder.run());
    if (counted) {
        runs_.push_back(builder.run());
    } else {
        describe(builder);
    }
}

BuildResult SweepContestant::result() const {
    BuildResult result = description_;
    result.scene = point_.scene;
    result.sweep = point_.swept;
    summarize_runs(result, runs_);
    return result;
}

}  // namespace clbvh::tool
