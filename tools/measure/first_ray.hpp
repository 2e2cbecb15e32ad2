#pragma once

#include <clbvh/core/build_stats.hpp>
#include <clbvh/core/ray.hpp>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "measure/contestant.hpp"
#include "measure/sample.hpp"

namespace clbvh::tool {

/// The time from a caller's arrays to the answer to a ray, and that of the next rays.
struct FirstRayResult {
    std::string scene;
    std::uint64_t triangles = 0;
    std::string builder;  ///< Id of a builder, a preset or a peer.
    bool is_peer = false;
    double cold_ms = 0.0;            ///< The first time, with all that has to be made once.
    Sample first_ray_ms;             ///< Milliseconds, of the times behind it.
    std::vector<StageStats> stages;  ///< Of the last time; a peer has none.
    /// A ray on one thread, asked in a span of them: primary, diffuse, diffuse for any hit. A peer's are asked one by
    /// one.
    std::optional<double> primary_ns, closest_ns, any_ns;
    /// The same, each ray by a call of its own; a peer has none.
    std::optional<double> primary_single_ns, closest_single_ns, any_single_ns;
    std::optional<double> bytes_per_triangle;  ///< Of what is traced; where it is known.
};

/// Builds what rays are traced through, anew each time, and answers a ray.
class FirstRayContestant : public Contestant {
public:
    explicit FirstRayContestant(std::string_view name) : name_(name) {}

    [[nodiscard]] std::string_view name() const final { return name_; }
    /// The first run is the cold one.
    void run(bool counted) final;

    /// On one thread, through what the last run has built.
    virtual void closest(std::span<const Ray> rays, std::span<Hit> hits) = 0;
    virtual void any(std::span<const Ray> rays, std::span<std::uint8_t> is_hit) = 0;

    /// The same, each ray by a call of its own.
    virtual void closest_singly(std::span<const Ray> rays, std::span<Hit> hits) = 0;
    virtual void any_singly(std::span<const Ray> rays, std::span<std::uint8_t> is_hit) = 0;
    /// Whether those of above are of another kind.
    [[nodiscard]] virtual bool has_span_calls() const noexcept = 0;

    /// Who it is, and what its runs took.
    [[nodiscard]] FirstRayResult result() const;

protected:
    /// From the arrays to the answer.
    virtual void build_and_trace() = 0;
    /// Adds what else is known.
    virtual void describe(FirstRayResult& result) const = 0;

private:
    std::string name_;
    std::optional<double> cold_ms_;
    std::vector<double> times_;
};

using FirstRayEntrants = std::vector<std::unique_ptr<FirstRayContestant>>;

/// Times rays through what each entrant has built last, the entrants in turn, `runs` times after one that warms up, and
/// sets the nanoseconds of results[i] from entrants[i].
void trace_entrants(const FirstRayEntrants& entrants, std::span<const Ray> primary, std::span<const Ray> diffuse,
                    std::size_t runs, std::span<FirstRayResult> results);

}  // namespace clbvh::tool
