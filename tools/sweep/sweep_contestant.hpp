#pragma once

#include <clbvh/builder.hpp>
#include <clbvh/core/mesh.hpp>
#include <clbvh/device/context.hpp>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "measure/build_result.hpp"
#include "measure/contestant.hpp"

namespace clbvh::tool {

/// One point of a sweep: a builder with its own options on one mesh.
///
/// Only one point has a builder at a time, else many points over a large mesh would not fit into memory. So each turn
/// makes the builder anew, uploads the mesh, and builds once to warm up; a turn that counts then builds again, which is
/// timed. Kernels stay in the context.
class SweepContestant final : public Contestant {
public:
    struct Point {
        std::string builder;
        std::string scene;
        const Mesh* mesh;
        SweptValue swept;
        BuildOptions options;
    };

    SweepContestant(Point point, std::optional<Context> context, bool validated);

    [[nodiscard]] std::string_view name() const override { return name_; }
    [[nodiscard]] const Mesh& mesh() const { return *point_.mesh; }
    /// The turn that does not count describes the tree.
    void run(bool counted) override;
    /// After a turn that did not count and one that did.
    [[nodiscard]] BuildResult result() const;

private:
    void describe(const Builder& builder);

    Point point_;
    std::optional<Context> context_;
    bool validated_;
    std::string name_;
    BuildResult description_;
    std::vector<BuildStats> runs_;
};

}  // namespace clbvh::tool
