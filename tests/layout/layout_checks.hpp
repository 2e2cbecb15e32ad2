#pragma once

#include <catch2/catch.hpp>
#include <cstring>
#include <functional>
#include <string>
#include <vector>

#include "clbvh/builder.hpp"
#include "clbvh/io/scene.hpp"
#include "clbvh/trace/tracer.hpp"
#include "core/random.hpp"
#include "support/expect_error.hpp"
#include "support/hard_trees.hpp"
#include "support/layout_rays.hpp"
#include "support/layout_trees.hpp"
#include "support/meshes.hpp"
#include "support/oracle/ray_oracle.hpp"

// What the tests of every layout do, with make_layout, validate and closest_in of its own.
namespace clbvh::test {

/// How many of the rays get another hit in the layout than in the tree.
template <typename Layout>
std::size_t count_other_hits(const MeshTree& tree, const Layout& layout, std::size_t rays_of_each_kind) {
    if (tree.bvh.empty()) return layout.empty() ? 0 : 1;
    const Tracer tracer(tree.bvh, tree.mesh);
    std::size_t differences = 0;
    for (const Ray& ray : difficult_rays(tree.mesh, rays_of_each_kind)) {
        const Hit expected = tracer.closest(ray);
        differences += same_bits(closest_in(layout, tree.mesh, ray), expected) ? 0 : 1;
    }
    return differences;
}

/// Makes the layout of the tree, proves it, and compares its hits with the tree's.
template <typename Make>
void check_layout(const MeshTree& tree, std::size_t rays_of_each_kind, const Make& make) {
    INFO(tree.name);
    const auto layout = make(tree, LayoutOptions{});
    CHECK_NOTHROW(validate(layout, tree.mesh));
    CHECK(count_other_hits(tree, layout, rays_of_each_kind) == 0);
    for (const Ray& ray : untraceable_rays())
        CHECK_FALSE(closest_in(layout, tree.mesh, ray));
}

template <typename Make>
void check_layouts_of_all_scenes(const Make& make) {
    for (const SceneGeneratorInfo& scene : scene_generators()) {
        const Mesh mesh = generate_scene(scene.name, 300);
        for (const MeshTree& tree : trees_of_host_builders(mesh, std::string(scene.name)))
            check_layout(tree, 20, make);
    }
}

template <typename Make>
void check_layouts_of_odd_trees(const Make& make) {
    for (const MeshTree& tree : odd_trees())
        check_layout(tree, 20, make);
}

/// A chain of 100,000 levels. Its triangles are points, which no ray hits: the proof is what counts.
template <typename Make>
void check_layout_of_deep_tree(const Make& make) {
    const Mesh line = line_of_points(100'000);
    const MeshTree tree{"a deep chain", line, chain_tree(line)};
    CHECK_NOTHROW(validate(make(tree, LayoutOptions{}), line));
}

template <typename T>
bool same_elements(const LayoutArray<T>& a, const LayoutArray<T>& b) {
    return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

/// One fault of a layout, and what the error must say.
template <typename Layout>
struct Fault {
    std::function<void(Layout&)> put_in;
    std::vector<std::string> words;
};

template <typename Layout>
void check_faults_are_named(const Layout& valid, const Mesh& mesh, const std::vector<Fault<Layout>>& faults) {
    REQUIRE_NOTHROW(validate(valid, mesh));
    for (const Fault<Layout>& fault : faults) {
        Layout broken = valid;
        fault.put_in(broken);
        std::string message;
        try {
            validate(broken, mesh);
        } catch (const Error& error) {
            message = error.what();
        }
        for (const std::string& word : fault.words) {
            INFO("\"" << message << "\" should say \"" << word << "\"");
            CHECK(message.find(word) != std::string::npos);
        }
    }
}

/// Whatever bytes the nodes of a layout hold, validate comes to an end, and what it lets pass can be traced.
template <typename Layout>
void check_any_bytes(const Layout& valid, const Mesh& mesh) {
    Random random(5);
    const std::vector<Ray> rays = difficult_rays(mesh, 1);
    std::size_t refused = 0;
    for (int round = 0; round < 2000; ++round) {
        Layout broken = valid;
        auto* const bytes = reinterpret_cast<unsigned char*>(broken.nodes.data());
        const auto size = static_cast<std::uint32_t>(broken.nodes.size() * sizeof(broken.nodes[0]));
        for (std::uint32_t change = random.below(3); change < 3; ++change)
            bytes[random.below(size)] = static_cast<unsigned char>(random.below(256));
        try {
            validate(broken, mesh);
            for (const Ray& ray : rays)
                (void)closest_in(broken, mesh, ray);
        } catch (const Error& error) {
            refused += error.code() == ErrorCode::invalid_input ? 1 : 0;
        }
    }
    CHECK(refused > 1000);
}

/// Trees that are none are refused, by name, and leave nothing behind.
template <typename Make>
void check_trees_are_refused(const Make& make) {
    const Mesh mesh = generate_scene("soup", 200);
    const Bvh valid = build(mesh, "sweep-sah");
    const auto first_leaf = [](Bvh& bvh) -> Node& {
        for (std::size_t i = 2;; ++i)
            if (bvh.nodes[i].is_leaf()) return bvh.nodes[i];
    };
    const std::vector<Fault<Bvh>> faults = {
        {[](Bvh& bvh) { bvh.nodes[0].first = 3; }, {"node 0", "odd"}},
        {[](Bvh& bvh) { bvh.nodes[0].first = 0; }, {"node 0", "another parent"}},
        {[](Bvh& bvh) { bvh.nodes[0].first = 1u << 30; }, {"node 0", "out of range"}},
        {[&](Bvh& bvh) {
             first_leaf(bvh) = {{}, bvh.nodes[0].first, {}, 0};
         },
         {"have another parent"}},
        {[&](Bvh& bvh) { first_leaf(bvh).first = 200; }, {"range ends at", "200 primitive ids"}},
        {[&](Bvh& bvh) { first_leaf(bvh).count = 0xFFFFFFFF; }, {"range ends at"}},
        {[&](Bvh& bvh) {
             first_leaf(bvh).count = 190;
             first_leaf(bvh).first = 0;
         },
         {"belongs to other leaves"}},
        {[](Bvh& bvh) { bvh.primitive_ids[7] = 200; }, {"primitive 200 is out of range"}},
    };
    for (const Fault<Bvh>& fault : faults) {
        MeshTree broken{"", mesh, valid};
        fault.put_in(broken.bvh);
        std::string message;
        try {
            make(broken, LayoutOptions{});
        } catch (const Error& error) {
            CHECK(error.code() == ErrorCode::invalid_input);
            message = error.what();
        }
        for (const std::string& word : fault.words) {
            INFO("\"" << message << "\" should say \"" << word << "\"");
            CHECK(message.find(word) != std::string::npos);
        }
    }
    expect_error(ErrorCode::invalid_input, {"thread_count", "1025"}, [&] {
        make(MeshTree{"", mesh, valid}, LayoutOptions{.thread_count = 1025});
    });
}

/// Layouts in depth-first order: the same bytes come with any number of threads, in new memory and in old.
template <typename Make>
void check_threads_and_memory(const Make& make) {
    for (const char* const builder : {"binned-sah", "sbvh"}) {
        const Mesh mesh = generate_scene("city", 60'000);
        const MeshTree tree{"", mesh, build(mesh, builder)};
        const auto expected = make(tree, LayoutOptions{.thread_count = 1});
        CHECK_NOTHROW(validate(expected, mesh));
        CHECK(count_other_hits(tree, expected, 10) == 0);
        auto layout = make(MeshTree{"", random_triangles(7), build(random_triangles(7), "median")}, LayoutOptions{});
        for (const std::uint32_t threads : {0u, 2u, 7u}) {
            make_layout(tree.bvh, layout, {.thread_count = threads});
            CHECK(same_elements(layout.nodes, expected.nodes));
            CHECK(same_elements(layout.primitive_ids, expected.primitive_ids));
            CHECK(layout.depth == expected.depth);
        }
    }
}

/// The same layouts are made of trees over boxes.
template <typename Layout>
void check_trees_over_boxes() {
    const Mesh mesh = generate_scene("hair", 500);
    std::vector<Aabb> boxes;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
        boxes.push_back(triangle_bounds(mesh, i));
    for (const char* const builder : {"sweep-sah", "sbvh"}) {
        const auto layout = make_layout<Layout>(build(BoxView(boxes), builder));
        CHECK_NOTHROW(validate(layout, BoxView(boxes)));
    }
}

}  // namespace clbvh::test
