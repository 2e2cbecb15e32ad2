#include "embree/embree_peer.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <clbvh/core/error.hpp>
#include <clbvh/layout/layout_array.hpp>
#include <cstring>
#include <optional>
#include <string>

#include "cli/interrupt.hpp"
#include "cli/stopwatch.hpp"
#include "embree/embree_commit.hpp"
#include "embree/embree_device.hpp"
#include "embree/embree_tree.hpp"
#include "embree/split_triangle.hpp"

namespace clbvh::tool {
namespace {

constexpr std::uint32_t kDefaultMaxLeafSize = 8;
constexpr unsigned kMaxDepth = 1024;  // Deep enough for any real scene; beyond it Embree halves ranges.

struct Variant {
    std::string_view id;
    RTCBuildQuality quality;
};
constexpr std::array kVariants{
    Variant{"embree-morton", RTC_BUILD_QUALITY_LOW},
    Variant{"embree-binned", RTC_BUILD_QUALITY_MEDIUM},
    Variant{"embree-sbvh", RTC_BUILD_QUALITY_HIGH},
};

std::vector<std::uint32_t> list_active(const Mesh& mesh) {
    std::vector<std::uint32_t> active;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        if (!is_inactive(mesh, i)) active.push_back(static_cast<std::uint32_t>(i));
    }
    return active;
}

static_assert(sizeof(RTCBuildPrimitive) == sizeof(LaneBox) && sizeof(RTCBounds) == sizeof(LaneBox),
              "of each, the corners begin at bytes 0 and 16");

void split_primitive(const RTCBuildPrimitive* primitive, unsigned axis, float position, RTCBounds* left,
                     RTCBounds* right, void* mesh_pointer) {
    const auto& mesh = *static_cast<const Mesh*>(mesh_pointer);
    const Triangle& t = mesh.triangles[primitive->primID];
    LaneBox box;
    std::memcpy(&box, primitive, sizeof(box));
    const SplitBounds split =
        split_triangle(mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]], box, axis, position);
    std::memcpy(left, &split.left, sizeof(split.left));
    std::memcpy(right, &split.right, sizeof(split.right));
}

/// On huge pages, as the library's builders have theirs.
LayoutArray<RTCBuildPrimitive> room_for_primitives(std::size_t count) {
    LayoutArray<RTCBuildPrimitive> primitives;
    primitives.resize_for_overwrite(count);
    return primitives;
}

class EmbreePeer final : public TreeContestant {
public:
    EmbreePeer(const Variant& variant, const BuildOptions& options, const Mesh& mesh)
        : variant_(variant),
          options_(options),
          mesh_(mesh),
          inactive_count_(check_mesh(mesh)),
          active_(inactive_count_ == 0 ? std::vector<std::uint32_t>{} : list_active(mesh)),
          count_(mesh.triangles.size() - inactive_count_),
          arena_(static_cast<int>(host_threads(options))),
          primitives_(room_for_primitives(capacity())),
          device_(variant.id),
          bvh_(rtcNewBVH(device_.get())) {
        device_.require(bvh_ != nullptr);
    }

    [[nodiscard]] std::string_view name() const override { return variant_.id; }

    [[nodiscard]] BuildResult result() const override {
        BuildResult result;
        summarize_runs(result, runs());
        result.builder = variant_.id;
        result.kind = BuilderKind::host;
        result.is_peer = true;
        result.threads = host_threads(options_);
        return result;
    }

    [[nodiscard]] std::optional<Bvh> tree() const override {
        Bvh bvh;
        if (count_ > 0) bvh = read_tree(root_, root_bounds());
        bvh.primitive_count = mesh_.triangles.size();
        bvh.split_references = splits();
        return bvh;
    }

protected:
    BuildStats build() override {
        BuildStats stats;
        const Stopwatch whole;
        arena_.execute([&] { fill_primitives(); });
        const double bounds_ms = whole.milliseconds();
        if (count_ > 0) arena_.execute([&] { root_ = build_tree(); });
        stats.build_ms = whole.milliseconds();
        stats.stages = {{"bounds", 0.0, bounds_ms, 0}, {"build", 0.0, stats.build_ms - bounds_ms, 0}};
        stats.peak_host_bytes = capacity() * sizeof(RTCBuildPrimitive) + device_.peak_bytes();
        stats.inactive_primitives = inactive_count_;
        return stats;
    }

private:
    [[nodiscard]] bool splits() const { return variant_.quality == RTC_BUILD_QUALITY_HIGH; }

    [[nodiscard]] std::size_t capacity() const {
        const double factor = splits() ? double{options_.sbvh.reference_budget} : 1.0;
        return static_cast<std::size_t>(factor * static_cast<double>(count_));
    }

    void fill_primitives() {
        tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count_, 8192), [&](const auto& range) {
            for (std::size_t i = range.begin(); i < range.end(); ++i) {
                const std::uint32_t id = inactive_count_ == 0 ? static_cast<std::uint32_t>(i) : active_[i];
                const Aabb b = triangle_bounds(mesh_, id);
                primitives_[i] = {b.lower.x, b.lower.y, b.lower.z, 0, b.upper.x, b.upper.y, b.upper.z, id};
            }
        });
    }

    [[nodiscard]] EmbreeChild build_tree() {
        RTCBuildArguments arguments = rtcDefaultBuildArguments();
        arguments.buildQuality = variant_.quality;
        arguments.buildFlags = RTC_BUILD_FLAG_DYNAMIC;  // keeps its memory for the next build
        arguments.maxBranchingFactor = 2;
        arguments.maxDepth = kMaxDepth;
        arguments.maxLeafSize = options_.max_leaf_size > 0 ? options_.max_leaf_size : kDefaultMaxLeafSize;
        if (variant_.quality == RTC_BUILD_QUALITY_LOW && options_.max_leaf_size > 0)
            arguments.minLeafSize = options_.max_leaf_size;
        arguments.traversalCost = options_.inner_cost;
        arguments.intersectionCost = options_.primitive_cost;
        arguments.bvh = bvh_.get();
        arguments.primitives = primitives_.data();
        arguments.primitiveCount = count_;
        arguments.primitiveArrayCapacity = capacity();
        arguments.buildProgress = [](void*, double) { return !interrupted(); };
        if (splits()) arguments.splitPrimitive = split_primitive;
        arguments.userPtr = const_cast<Mesh*>(&mesh_);  // which no callback writes to
        set_tree_callbacks(arguments);
        void* root = rtcBuildBVH(&arguments);
        device_.require(root != nullptr);
        return root;
    }

    [[nodiscard]] Aabb root_bounds() const {
        Aabb box;
        for (std::size_t i = 0; i < mesh_.triangles.size(); ++i) {
            if (!is_inactive(mesh_, i)) box = merge(box, triangle_bounds(mesh_, i));
        }
        return box;
    }

    const Variant& variant_;
    BuildOptions options_;
    const Mesh& mesh_;
    std::uint64_t inactive_count_;
    std::vector<std::uint32_t> active_;  // empty where all are
    std::size_t count_;
    tbb::task_arena arena_;
    LayoutArray<RTCBuildPrimitive> primitives_;
    EmbreeDevice device_;
    EmbreeHandle<RTCBVH, rtcReleaseBVH> bvh_;
    EmbreeChild root_ = nullptr;
};

}  // namespace

void check_embree_peers(const BuildOptions& options) {
    if (options.max_leaf_size <= RTC_BUILD_MAX_PRIMITIVES_PER_LEAF) return;
    throw Error(ErrorCode::unsupported, "Embree's leaves hold at most " +
                                            std::to_string(RTC_BUILD_MAX_PRIMITIVES_PER_LEAF) +
                                            " primitives; lower --max-leaf, or leave --peers out");
}

std::vector<std::unique_ptr<TreeContestant>> make_embree_peers(const BuildOptions& options, const Mesh& mesh) {
    check_embree_peers(options);
    std::vector<std::unique_ptr<TreeContestant>> peers;
    peers.reserve(kVariants.size() + 1);
    for (const Variant& variant : kVariants)
        peers.push_back(std::make_unique<EmbreePeer>(variant, options, mesh));
    peers.push_back(make_embree_commit(options, mesh));
    return peers;
}

}  // namespace clbvh::tool
