#include <cstddef>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "c/guarded.hpp"
#include "c/known_fields.hpp"
#include "clbvh/clbvh.h"
#include "clbvh/clbvh.hpp"

static_assert(sizeof(clbvh_node) == sizeof(clbvh::Node));

struct clbvh_builder {
    std::string id;
    std::optional<clbvh::Context> context;  // absent for builders of the host
    clbvh::BuildOptions options;            // their progress calls this one:
    clbvh_progress progress = nullptr;
    void* progress_user = nullptr;
    std::optional<clbvh::Builder> builder;  // once it has built with these options
    std::string text;                       // what clbvh_get_option returned last
    clbvh::Bvh bvh;
    bool has_tree = false;                    // which may be empty
    std::optional<clbvh::Refitter> refitter;  // for `bvh`, once it was refitted
};

namespace {

using clbvh::c::guarded;

// The first structures that there were: no caller knows fewer fields. They stay when fields are appended.
constexpr std::size_t kSmallestMeshView = offsetof(clbvh_mesh_view, index_stride) + sizeof(std::uint32_t);
constexpr std::size_t kSmallestBoxView = offsetof(clbvh_box_view, count) + sizeof(std::uint64_t);
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

/// False where the callback says stop.
bool report(clbvh_progress callback, void* user, const clbvh::Progress& progress) {
    return callback(user, std::string(progress.stage).c_str(), progress.fraction) != 0;
}

/// A null callback becomes none.
clbvh::ProgressCallback to_callback(clbvh_progress callback, void* user) {
    if (callback == nullptr) return {};
    return [callback, user](const clbvh::Progress& progress) { return report(callback, user, progress); };
}

/// Calls whatever callback the handle has when it is called.
clbvh::ProgressCallback watch(const clbvh_builder& handle) {
    return
        [&handle](const clbvh::Progress& progress) { return report(handle.progress, handle.progress_user, progress); };
}

clbvh::OptimizeBudget to_budget(const clbvh_budget* given) {
    clbvh::OptimizeBudget result;
    if (given == nullptr) return result;
    const auto known = clbvh::c::known_fields(*given, kSmallestBudget, "clbvh_budget");
    result.passes = known.passes;
    result.milliseconds = known.milliseconds;
    result.progress = to_callback(known.progress, known.progress_user);
    return result;
}

clbvh::MeshView to_view(const float* vertices, std::uint64_t vertex_count, const std::uint32_t* triangles,
                        std::uint64_t triangle_count) {
    require(vertices != nullptr || vertex_count == 0, "vertices is null");
    require(triangles != nullptr || triangle_count == 0, "triangles is null");
    return {vertices, vertex_count, sizeof(clbvh::Vec3), triangles, triangle_count};
}

clbvh::MeshView to_view(const clbvh_mesh_view* given) {
    require(given != nullptr, "mesh is null");
    const auto known = clbvh::c::known_fields(*given, kSmallestMeshView, "clbvh_mesh_view");
    require(known.index_type <= CLBVH_INDEX_UINT16, "clbvh_mesh_view.index_type is not 0 or 1");
    clbvh::MeshView view{known.vertices, known.vertex_count};
    if (known.vertex_stride != 0) view.vertex_stride = known.vertex_stride;
    view.indices = known.indices;
    view.triangle_count = known.triangle_count;
    view.index_type = known.index_type == CLBVH_INDEX_UINT16 ? clbvh::IndexType::uint16 : clbvh::IndexType::uint32;
    view.index_stride = known.index_stride;
    return view;
}

clbvh::BoxView to_view(const clbvh_box_view* given) {
    require(given != nullptr, "boxes is null");
    const auto known = clbvh::c::known_fields(*given, kSmallestBoxView, "clbvh_box_view");
    clbvh::BoxView view{known.boxes, known.count};
    if (known.stride != 0) view.stride = known.stride;
    return view;
}

/// The builder with the options that were set last.
clbvh::Builder& builder_of(clbvh_builder& handle) {
    if (!handle.builder) {
        if (handle.context) {
            handle.builder.emplace(handle.id, *handle.context, handle.options);
        } else {
            handle.builder.emplace(handle.id, handle.options);
        }
    }
    return *handle.builder;
}

/// `make_primitives()` is called where its failure leaves no tree.
template <class MakePrimitives>
clbvh_error build_over(clbvh_builder* builder, const MakePrimitives& make_primitives) noexcept {
    return guarded([&] {
        require(builder != nullptr, "builder is null");
        builder->refitter.reset();
        builder->bvh = {};
        builder->has_tree = false;
        builder->bvh = builder_of(*builder).build(make_primitives());
        builder->has_tree = true;
    });
}

template <class MakePrimitives>
clbvh_error refit_to(clbvh_builder* builder, const MakePrimitives& make_primitives, double* sah_before,
                     double* sah_after) noexcept {
    return guarded([&] {
        require_tree(builder);
        const clbvh::Primitives primitives = make_primitives();
        if (!builder->refitter) builder->refitter.emplace(builder->bvh);
        const clbvh::RefitStats stats = builder->refitter->refit(builder->bvh, primitives);
        if (sah_before != nullptr) *sah_before = stats.sah_before;
        if (sah_after != nullptr) *sah_after = stats.sah_after;
    });
}

template <class MakePrimitives>
clbvh_error validate_over(const clbvh_builder* builder, const MakePrimitives& make_primitives) noexcept {
    return guarded([&] {
        require_tree(builder);
        const clbvh::ValidationReport report = clbvh::validate(builder->bvh, make_primitives());
        require(report.valid, report.error.c_str());
    });
}

/// A row of the table of options, whose texts end with a zero.
struct OptionTexts {
    explicit OptionTexts(const clbvh::OptionInfo& info)
        : name(info.name),
          values(info.values),
          default_value(info.default_value),
          help(info.help),
          readers(info.readers),
          row{name.c_str(),   static_cast<clbvh_option_type>(info.type),
              values.c_str(), default_value.c_str(),
              help.c_str(),   readers.c_str()} {}
    OptionTexts(const OptionTexts&) = delete;
    OptionTexts& operator=(const OptionTexts&) = delete;
    ~OptionTexts() = default;

    std::string name, values, default_value, help, readers;
    clbvh_option row;
};

const std::deque<OptionTexts>& option_texts() {
    static const std::deque<OptionTexts> texts = [] {
        std::deque<OptionTexts> list;
        for (const clbvh::OptionInfo& info : clbvh::options())
            list.emplace_back(info);
        return list;
    }();
    return texts;
}

}  // namespace

clbvh_error clbvh_create_builder(const char* id, const char* device, clbvh_builder** builder) {
    return guarded([&] {
        require(builder != nullptr, "builder is null");
        *builder = nullptr;
        require(id != nullptr, "id is null");
        auto handle = std::make_unique<clbvh_builder>();
        handle->id = id;
        if (clbvh::find_builder(id).kind == clbvh::BuilderKind::device)
            handle->context = clbvh::Context::open(device != nullptr ? device : "");
        *builder = handle.release();
    });
}

clbvh_error clbvh_set_option(clbvh_builder* builder, const char* name, const char* value) {
    return guarded([&] {
        require(builder != nullptr, "builder is null");
        require(name != nullptr, "name is null");
        require(value != nullptr, "value is null");
        clbvh::BuildOptions changed = builder->options;
        clbvh::set_option(changed, name, value);
        if (clbvh::get_option(changed, name) == clbvh::get_option(builder->options, name)) return;
        builder->options = std::move(changed);
        builder->builder.reset();
    });
}

const char* clbvh_get_option(clbvh_builder* builder, const char* name) {
    const char* text = nullptr;
    guarded([&] {
        require(builder != nullptr, "builder is null");
        require(name != nullptr, "name is null");
        builder->text = clbvh::get_option(builder->options, name);
        text = builder->text.c_str();
    });
    return text;
}

clbvh_error clbvh_set_progress(clbvh_builder* builder, clbvh_progress progress, void* user) {
    return guarded([&] {
        require(builder != nullptr, "builder is null");
        const bool is_watched = progress != nullptr;
        // The builder keeps a way to the handle: another callback needs no other builder, and so no new memory.
        if (is_watched != static_cast<bool>(builder->options.progress)) {
            builder->options.progress = nullptr;
            if (is_watched) builder->options.progress = watch(*builder);
            builder->builder.reset();
        }
        builder->progress = progress;
        builder->progress_user = user;
    });
}

uint32_t clbvh_option_count(void) {
    uint32_t count = 0;
    guarded([&] { count = static_cast<uint32_t>(clbvh::options().size()); });
    return count;
}

const clbvh_option* clbvh_option_info(uint32_t index) {
    const clbvh_option* row = nullptr;
    guarded([&] {
        require(index < option_texts().size(), "there is no option of that index");
        row = &option_texts()[index].row;
    });
    return row;
}

void clbvh_destroy_builder(clbvh_builder* builder) {
    delete builder;
}

clbvh_error clbvh_build(clbvh_builder* builder, const float* vertices, uint64_t vertex_count, const uint32_t* triangles,
                        uint64_t triangle_count) {
    return build_over(builder, [&] { return to_view(vertices, vertex_count, triangles, triangle_count); });
}

clbvh_error clbvh_build_mesh(clbvh_builder* builder, const clbvh_mesh_view* mesh) {
    return build_over(builder, [&] { return to_view(mesh); });
}

clbvh_error clbvh_build_boxes(clbvh_builder* builder, const clbvh_box_view* boxes) {
    return build_over(builder, [&] { return to_view(boxes); });
}

clbvh_error clbvh_optimize(clbvh_builder* builder, const char* ids, const clbvh_budget* budget,
                           clbvh_optimize_stats* stats) {
    return guarded([&] {
        require_tree(builder);
        require(ids != nullptr, "ids is null");
        if (stats != nullptr) clbvh::c::check_size(stats->size, kSmallestStats, "clbvh_optimize_stats");
        clbvh::OptimizeStats done;
        clbvh::Bvh better = clbvh::optimize(builder->bvh, ids, to_budget(budget), &done);
        if (stats != nullptr) {
            clbvh_optimize_stats known{};
            known.passes = done.passes;
            known.changes = done.changes;
            known.milliseconds = done.milliseconds;
            known.sah_before = clbvh::sah_cost(builder->bvh);
            known.sah_after = clbvh::sah_cost(better);
            known.is_cancelled = done.is_cancelled ? 1 : 0;
            clbvh::c::write_known_fields(known, *stats);
        }
        builder->refitter.reset();
        builder->bvh = std::move(better);
    });
}

clbvh_error clbvh_refit(clbvh_builder* builder, const float* vertices, uint64_t vertex_count, const uint32_t* triangles,
                        uint64_t triangle_count, double* sah_before, double* sah_after) {
    return refit_to(
        builder, [&] { return to_view(vertices, vertex_count, triangles, triangle_count); }, sah_before, sah_after);
}

clbvh_error clbvh_refit_mesh(clbvh_builder* builder, const clbvh_mesh_view* mesh, double* sah_before,
                             double* sah_after) {
    return refit_to(
        builder, [&] { return to_view(mesh); }, sah_before, sah_after);
}

clbvh_error clbvh_refit_boxes(clbvh_builder* builder, const clbvh_box_view* boxes, double* sah_before,
                              double* sah_after) {
    return refit_to(
        builder, [&] { return to_view(boxes); }, sah_before, sah_after);
}

clbvh_error clbvh_validate_mesh(const clbvh_builder* builder, const clbvh_mesh_view* mesh) {
    return validate_over(builder, [&] { return to_view(mesh); });
}

clbvh_error clbvh_validate_boxes(const clbvh_builder* builder, const clbvh_box_view* boxes) {
    return validate_over(builder, [&] { return to_view(boxes); });
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

const char* clbvh_embed_source(void) {
    return clbvh::embed_source().data();
}

const char* clbvh_last_error(void) {
    return clbvh::c::last_message();
}
