#include "support/builders.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>

#include "clbvh/core/validate.hpp"
#include "clbvh/device/context.hpp"
#include "clbvh/host/collapse.hpp"
#include "support/compare_trees.hpp"
#include "support/oracle/tree_oracle.hpp"

namespace clbvh::test {
namespace {

#if defined(CLBVH_NO_OPENCL)
constexpr bool kHasOpenCl = false;
#else
constexpr bool kHasOpenCl = true;
#endif

std::vector<std::string_view> builders_of(BuilderKind kind) {
    std::vector<std::string_view> ids;
    for (const BuilderInfo& info : builders()) {
        if (info.kind == kind && can_run(info.id)) ids.push_back(info.id);
    }
    return ids;
}

}  // namespace

const Context& shared_context() {
    static const Context context = Context::open();
    return context;
}

bool can_run(std::string_view id) {
    return kHasOpenCl || find_builder(id).kind == BuilderKind::host;
}

std::vector<std::string_view> device_builders() {
    return builders_of(BuilderKind::device);
}

std::vector<std::string_view> enqueued_builders() {
    std::vector<std::string_view> ids = device_builders();
    std::erase(ids, "hlbvh");
    return ids;
}

std::vector<std::string_view> host_builders() {
    return builders_of(BuilderKind::host);
}

Builder make_builder(std::string_view id, const BuildOptions& options) {
    return kHasOpenCl ? Builder(id, shared_context(), options) : Builder(id, options);
}

Bvh built_tree(std::string_view id, const Mesh& mesh, const BuildOptions& options) {
    if (can_run(id)) return make_builder(id, options).build(mesh);
    BuildOptions resolved = options;
    if (resolved.ploc.range_count == 0) resolved.ploc.range_count = 8;
    const Bvh tree = oracle_tree(id, morton_order(mesh, resolved), resolved).bvh;
    return options.max_leaf_size > 0 ? collapse(tree, {options.max_leaf_size}) : tree;
}

BuildOptions options_of(Shape shape, std::uint32_t radius) {
    BuildOptions options;
    options.device.shape = shape;
    options.ploc.search_radius = radius;
    options.ploc.range_count = 8;
    return options;
}

bool expect_oracle_tree(const Builder& builder, const Bvh& bvh, const Mesh& mesh, const std::string& where) {
    const BuildOptions& options = builder.options();
    INFO(builder.info().id << ", " << to_string(options.device.shape) << ", radius " << options.ploc.search_radius
                           << ", code_bits " << options.device.code_bits << ", " << where);
    const MortonOrder order = morton_order(mesh, options);
    const Bvh expected = oracle_tree(builder.info().id, order, options).bvh;
    const std::string difference = compare_trees(expected, bvh);
    const std::string fault = validate(bvh, mesh).error;
    const bool same_numbering = same_bytes(expected, bvh);
    CHECK(difference == "");
    CHECK(fault == "");
    CHECK(same_numbering);
    return difference.empty() && fault.empty() && same_numbering;
}

bool same_bytes(const Bvh& a, const Bvh& b) {
    if (a.primitive_count != b.primitive_count || a.primitive_ids != b.primitive_ids) return false;
    if (a.nodes.size() != b.nodes.size()) return false;
    return a.nodes.empty() || std::memcmp(a.nodes.data(), b.nodes.data(), a.nodes.size() * sizeof(Node)) == 0;
}

const StageStats& stage(const BuildStats& stats, std::string_view name) {
    const auto found = std::find_if(stats.stages.begin(), stats.stages.end(),
                                    [&](const StageStats& candidate) { return candidate.name == name; });
    if (found == stats.stages.end()) FAIL("there is no stage " << name);
    return *found;
}

}  // namespace clbvh::test
