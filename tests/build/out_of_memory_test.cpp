// Memory that runs out: every allocation of a host build or a refit fails once, and each time an Error(out_of_memory)
// comes out, and the builder or the refitter still works.
#include <tbb/task_arena.h>

#include <catch2/catch.hpp>
#include <new>

#include "clbvh/core/error.hpp"
#include "clbvh/io/scene.hpp"
#include "clbvh/optimize/refit.hpp"
#include "support/allocations.hpp"
#include "support/builders.hpp"
#include "support/fitted_by_definition.hpp"
#include "support/meshes.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

/// Does `work`, and lets the allocation behind the first `allowed` ones fail. Returns false where that was told as it
/// should be, true where there were fewer.
template <typename Work>
bool try_with(long allowed, const Work& work) {
    try {
        allow_allocations(allowed);
        work();
        allow_allocations(-1);
        return true;
    } catch (const Error& error) {
        allow_allocations(-1);
        REQUIRE(error.code() == ErrorCode::out_of_memory);
        return false;
    } catch (const std::bad_alloc&) {
        allow_allocations(-1);
        FAIL("std::bad_alloc came out");
    }
    return false;
}

bool try_build(Builder& builder, const Mesh& mesh, long allowed) {
    return try_with(allowed, [&] {
        builder.upload(mesh);
        builder.run();
    });
}

/// On one thread.
bool try_refit(Refitter& refitter, Bvh& tree, const Mesh& mesh, long allowed) {
    return tbb::task_arena(1).execute([&] { return try_with(allowed, [&] { refitter.refit(tree, mesh); }); });
}

}  // namespace

TEST_CASE("an allocation that fails anywhere in a host build is an Error, and the builder still works") {
    const Mesh mesh = generate_scene("hair", 3000);
    for (const std::uint32_t presplit : {0u, 8u}) {
        for (const std::string_view id : host_builders()) {
            INFO(id << ", presplit " << presplit);
            BuildOptions options;
            options.thread_count = 1;
            options.presplit_level = presplit;
            options.max_leaf_size = 8;
            const Bvh expected = Builder(id, options).build(mesh);
            long failures = 0;
            for (long allowed = 0; allowed < 10000; allowed += 1 + allowed / 10) {
                Builder builder(id, options);
                if (try_build(builder, mesh, allowed)) break;
                ++failures;
                REQUIRE(same_bytes(builder.build(mesh), expected));
            }
            CHECK(failures > 0);
        }
    }
}

TEST_CASE("an allocation that fails anywhere in a refit is an Error, and the next refit puts all boxes right") {
    const Mesh mesh = generate_scene("city", 20000);
    const Mesh moved = scaled(mesh, 2.0f);
    const Bvh tree = built_tree("plocpp", mesh);
    const Bvh expected = fitted_by_definition(tree, moved);
    bool were_boxes_written = false;
    long allowed = 0;
    for (;; ++allowed) {
        INFO("allocation " << allowed);
        Bvh given = tree;
        Refitter refitter(tree);
        if (try_refit(refitter, given, moved, allowed)) break;
        were_boxes_written = were_boxes_written || !same_bytes(given, tree);
        refitter.refit(given, moved);
        REQUIRE(same_bytes(given, expected));
    }
    CHECK(allowed > 0);
    CHECK(were_boxes_written);
}
