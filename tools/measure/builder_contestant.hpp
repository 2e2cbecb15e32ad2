#pragma once

#include <clbvh/builder.hpp>

#include "measure/contestant.hpp"

namespace clbvh::tool {

/// A builder of the library over a mesh that it has taken a copy of.
class BuilderContestant final : public TreeContestant {
public:
    BuilderContestant(Builder builder, const Mesh& mesh) : builder_(std::move(builder)) { builder_.upload(mesh); }

    [[nodiscard]] std::string_view name() const override { return builder_.id(); }
    [[nodiscard]] BuildResult result() const override {
        BuildResult result;
        describe_builder(result, builder_);
        summarize_runs(result, runs());
        return result;
    }
    [[nodiscard]] std::optional<Bvh> tree() const override { return builder_.download(); }

protected:
    BuildStats build() override { return builder_.run(); }

private:
    Builder builder_;
};

}  // namespace clbvh::tool
