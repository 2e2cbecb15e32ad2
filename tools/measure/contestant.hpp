#pragma once

#include <clbvh/core/build_stats.hpp>
#include <clbvh/core/bvh.hpp>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "measure/build_result.hpp"

namespace clbvh::tool {

/// Something that a benchmark times again and again on one mesh.
class Contestant {
public:
    Contestant() = default;
    Contestant(const Contestant&) = delete;
    Contestant& operator=(const Contestant&) = delete;
    virtual ~Contestant() = default;

    [[nodiscard]] virtual std::string_view name() const = 0;
    /// Does its work once. The time is kept where the run is `counted`.
    virtual void run(bool counted) = 0;
};

/// A contestant that builds trees.
class TreeContestant : public Contestant {
public:
    void run(bool counted) final {
        BuildStats stats = build();
        if (counted) runs_.push_back(std::move(stats));
    }
    /// Who it is and what its counted runs cost, of which there is at least one; nothing of the tree.
    [[nodiscard]] virtual BuildResult result() const = 0;
    /// The tree of the last run; nothing where it cannot be read.
    [[nodiscard]] virtual std::optional<Bvh> tree() const = 0;

protected:
    virtual BuildStats build() = 0;
    [[nodiscard]] std::span<const BuildStats> runs() const { return runs_; }

private:
    std::vector<BuildStats> runs_;
};

}  // namespace clbvh::tool
