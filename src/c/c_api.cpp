#include <algorithm>
#include <cstddef>
#include <cstring>
#include <new>
#include <optional>
#include <string>
#include <utility>

#include "clbvh/clbvh.h"
#include "clbvh/clbvh.hpp"

static_assert(sizeof(clbvh_node) == sizeof(clbvh::Node));

struct clbvh_builder {
    clbvh::Builder builder;
    clbvh::Bvh bvh;
    bool has_tree = false;                    // which may be empty
    clbvh::Mesh moved;                        // what clbvh_refit was given last; its memory is used again
    std::optional<clbvh::Refitter> refitter;  // for `bvh`, once it was refitted
};

namespace {

thread_local std::string last_error;

// Runs `body`; what it throws becomes a code, and its message clbvh_last_error.
template <class Body>
clbvh_error guarded(Body&& body) noexcept {
    try {
        body();
        return CLBVH_OK;
    } catch (const clbvh::Error& error) {
        last_error = error.what();
        return static_cast<clbvh_error>(error.code());
    } catch (const std::bad_alloc&) {
        last_error = "the host has no memory left";
        return CLBVH_OUT_OF_MEMORY;
    } catch (const std::exception& error) {
        last_error = error.what();
        return CLBVH_DEVICE_FAILURE;
    }
}

// The first structures that there were: no caller knows fewer fields.
constexpr std::size_t kSmallestOptions = offsetof(clbvh_options, inner_cost);
constexpr std::size_t kSmallestBudget = offsetof(clbvh_budget, progress_user) + sizeof(void*);
constexpr std::size_t kSmallestStats = offsetof(clbvh_optimize_stats, is_cancelled) + sizeof(std::uint32_t);

void require(bool condition, const char* message) {
    if (!condition) {
        throw clbvh::Error(clbvh::ErrorCode::invalid_input, message);
    }
}

void require_tree(const clbvh_builder* builder) {
    require(builder != nullptr, "builder is null");
    require(builder->has_tree, "there is no tree; call clbvh_build first");
}

clbvh_options default_options() {
    const clbvh::BuildOptions defaults;
    return {sizeof(clbvh_options),
            defaults.search_radius,
            0,
            0,
            0,
            defaults.single_group_threshold,
            nullptr,
            nullptr,
            defaults.inner_cost,
            defaults.primitive_cost,
            defaults.max_leaf_size,
            defaults.presplit_level,
            defaults.thread_count,
            defaults.bin_count,
            defaults.split_alpha,
            defaults.reference_budget,
            static_cast<std::uint32_t>(defaults.hploc_quality),
            defaults.code_bits,
            nullptr,
            defaults.split_quota,
            defaults.optimize_passes};
}

/// False where the callback says stop.
bool report(clbvh_progress callback, void* user, const clbvh::Progress& progress) {
    return callback(user, std::string(progress.stage).c_str(), progress.fraction) != 0;
}

clbvh::BuildOptions to_build_options(const clbvh_options* given) {
    clbvh_options options = default_options();
    if (given != nullptr) {
        require(given->size >= kSmallestOptions, "clbvh_options.size is not set; use clbvh_default_options");
        std::memcpy(&options, given, std::min<std::size_t>(given->size, sizeof(options)));
    }
    require(options.shape <= 2, "clbvh_options.shape is not 0, 1 or 2");
    require(options.extended_morton_code <= 1, "clbvh_options.extended_morton_code is not 0 or 1");
    require(options.exact_distances <= 1, "clbvh_options.exact_distances is not 0 or 1");
    require(options.hploc_quality <= 1, "clbvh_options.hploc_quality is not 0 or 1");
    clbvh::BuildOptions result;
    result.search_radius = options.search_radius;
    result.shape = static_cast<clbvh::Shape>(options.shape);
    result.morton_code = static_cast<clbvh::MortonCode>(options.extended_morton_code);
    if (options.exact_distances != 0) {
        result.neighbour_encoding = clbvh::NeighbourEncoding::bits64;
    }
    result.single_group_threshold = options.single_group_threshold;
    result.inner_cost = options.inner_cost;
    result.primitive_cost = options.primitive_cost;
    result.max_leaf_size = options.max_leaf_size;
    result.presplit_level = options.presplit_level;
    result.thread_count = options.thread_count;
    result.bin_count = options.bin_count;
    result.split_alpha = options.split_alpha;
    result.reference_budget = options.reference_budget;
    result.hploc_quality = static_cast<clbvh::HplocQuality>(options.hploc_quality);
    result.code_bits = options.code_bits;
    if (options.optimizers != nullptr) result.optimizers = options.optimizers;
    result.split_quota = options.split_quota;
    result.optimize_passes = options.optimize_passes;
    if (options.progress != nullptr) {
        result.progress = [options](const clbvh::Progress& progress) {
            return report(options.progress, options.progress_user, progress);
        };
    }
    return result;
}

clbvh::OptimizeBudget to_budget(const clbvh_budget* given) {
    clbvh::OptimizeBudget result;
    if (given == nullptr) return result;
    require(given->size >= kSmallestBudget, "clbvh_budget.size is not set to sizeof(clbvh_budget)");
    require(given->milliseconds >= 0.0, "clbvh_budget.milliseconds is negative or not a number");
    result.passes = given->passes;
    result.milliseconds = given->milliseconds;
    if (given->progress != nullptr) {
        result.progress = [callback = given->progress, user = given->progress_user](const clbvh::Progress& progress) {
            return report(callback, user, progress);
        };
    }
    return result;
}

void copy_mesh(const float* vertices, std::uint64_t vertex_count, const std::uint32_t* triangles,
               std::uint64_t triangle_count, clbvh::Mesh& mesh) {
    require(vertices != nullptr || vertex_count == 0, "vertices is null");
    require(triangles != nullptr || triangle_count == 0, "triangles is null");
    static_assert(sizeof(clbvh::Vec3) == 3 * sizeof(float) && sizeof(clbvh::Triangle) == 3 * sizeof(std::uint32_t));
    mesh.vertices.resize(vertex_count);
    if (vertex_count > 0) {
        std::memcpy(static_cast<void*>(mesh.vertices.data()), vertices, vertex_count * sizeof(clbvh::Vec3));
    }
    mesh.triangles.resize(triangle_count);
    if (triangle_count > 0) {
        std::memcpy(mesh.triangles.data(), triangles, triangle_count * sizeof(clbvh::Triangle));
    }
}

clbvh::Builder make_builder(const char* id, const char* device, const clbvh::BuildOptions& options) {
    if (clbvh::find_builder(id).kind == clbvh::BuilderKind::host) return clbvh::Builder(id, options);
    clbvh::check_options(options);  // before a device is opened
    clbvh::check_optimizers(options.optimizers);
    return {id, clbvh::Context::open(device != nullptr ? device : ""), options};
}

}  // namespace

void clbvh_default_options(clbvh_options* options, uint32_t size) {
    if (options != nullptr) {
        clbvh_options defaults = default_options();
        defaults.size = size;
        std::memcpy(options, &defaults, std::min<std::size_t>(size, sizeof(defaults)));
    }
}

clbvh_error clbvh_create_builder(const char* id, const char* device, const clbvh_options* options,
                                 clbvh_builder** builder) {
    return guarded([&] {
        require(builder != nullptr, "builder is null");
        *builder = nullptr;
        require(id != nullptr, "id is null");
        const clbvh::BuildOptions build_options = to_build_options(options);
        *builder = new clbvh_builder{make_builder(id, device, build_options), {}, false, {}, {}};
    });
}

void clbvh_destroy_builder(clbvh_builder* builder) {
    delete builder;
}

clbvh_error clbvh_build(clbvh_builder* builder, const float* vertices, uint64_t vertex_count, const uint32_t* triangles,
                        uint64_t triangle_count) {
    return guarded([&] {
        require(builder != nullptr, "builder is null");
        builder->refitter.reset();
        builder->bvh = {};
        builder->has_tree = false;
        clbvh::Mesh mesh;
        copy_mesh(vertices, vertex_count, triangles, triangle_count, mesh);
        builder->bvh = builder->builder.build(mesh);
        builder->has_tree = true;
    });
}

clbvh_error clbvh_optimize(clbvh_builder* builder, const char* ids, const clbvh_budget* budget,
                           clbvh_optimize_stats* stats) {
    return guarded([&] {
        require_tree(builder);
        require(ids != nullptr, "ids is null");
        require(stats == nullptr || stats->size >= kSmallestStats,
                "clbvh_optimize_stats.size is not set to sizeof(clbvh_optimize_stats)");
        clbvh::OptimizeStats done;
        clbvh::Bvh better = clbvh::optimize(builder->bvh, ids, to_budget(budget), &done);
        if (stats != nullptr) {
            const clbvh_optimize_stats known{stats->size,
                                             done.passes,
                                             done.changes,
                                             done.milliseconds,
                                             clbvh::sah_cost(builder->bvh),
                                             clbvh::sah_cost(better),
                                             done.is_cancelled ? 1u : 0u,
                                             0};
            std::memcpy(stats, &known, std::min<std::size_t>(stats->size, sizeof(known)));
        }
        builder->refitter.reset();
        builder->bvh = std::move(better);
    });
}

clbvh_error clbvh_refit(clbvh_builder* builder, const float* vertices, uint64_t vertex_count, const uint32_t* triangles,
                        uint64_t triangle_count, double* sah_before, double* sah_after) {
    return guarded([&] {
        require_tree(builder);
        copy_mesh(vertices, vertex_count, triangles, triangle_count, builder->moved);
        if (!builder->refitter) builder->refitter.emplace(builder->bvh);
        const clbvh::RefitStats stats = builder->refitter->refit(builder->bvh, builder->moved);
        if (sah_before != nullptr) *sah_before = stats.sah_before;
        if (sah_after != nullptr) *sah_after = stats.sah_after;
    });
}

const clbvh_node* clbvh_nodes(const clbvh_builder* builder, uint64_t* count) {
    const bool empty = builder == nullptr || builder->bvh.nodes.empty();
    if (count != nullptr) {
        *count = empty ? 0 : builder->bvh.nodes.size();
    }
    return empty ? nullptr : reinterpret_cast<const clbvh_node*>(builder->bvh.nodes.data());
}

const uint32_t* clbvh_primitive_ids(const clbvh_builder* builder, uint64_t* count) {
    const bool empty = builder == nullptr || builder->bvh.primitive_ids.empty();
    if (count != nullptr) {
        *count = empty ? 0 : builder->bvh.primitive_ids.size();
    }
    return empty ? nullptr : builder->bvh.primitive_ids.data();
}

int clbvh_has_split_references(const clbvh_builder* builder) {
    return builder != nullptr && builder->bvh.split_references ? 1 : 0;
}

const char* clbvh_last_error(void) {
    return last_error.c_str();
}
