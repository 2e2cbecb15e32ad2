#include <catch2/catch.hpp>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "clbvh/clbvh.hpp"
#include "clbvh/io/scene.hpp"
#include "support/builders.hpp"

// The trees of every builder and preset over every generated scene, byte for byte as they are recorded.
// CLBVH_PRINT_TREE_HASHES=1 prints the table anew.
namespace clbvh::test {
namespace {

constexpr std::uint64_t kTriangles = 5000;

struct TreeHash {
    std::string_view builder;
    std::string_view scene;
    std::uint64_t hash;
};

constexpr TreeHash kTreeHashes[] = {
    {"", "", 0},
#include "build/tree_hashes.inc"
};

std::uint64_t fnv1a(std::uint64_t hash, std::span<const std::byte> bytes) {
    for (const std::byte byte : bytes)
        hash = (hash ^ static_cast<std::uint64_t>(byte)) * 0x100000001b3u;
    return hash;
}

std::uint64_t hash_of(const Bvh& tree) {
    const std::uint64_t nodes = fnv1a(0xcbf29ce484222325u, std::as_bytes(std::span(tree.nodes)));
    return fnv1a(nodes, std::as_bytes(std::span(tree.primitive_ids)));
}

std::uint64_t expected(std::string_view builder, std::string_view scene) {
    for (const TreeHash& row : kTreeHashes)
        if (row.builder == builder && row.scene == scene) return row.hash;
    return 0;
}

std::vector<std::string> builders_and_presets() {
    std::vector<std::string> ids;
    for (const BuilderInfo& builder : builders())
        if (can_run(builder.id)) ids.emplace_back(builder.id);
    for (const PresetInfo& preset : presets())
        if (can_run(preset.id)) ids.emplace_back(preset.id);
    return ids;
}

}  // namespace

TEST_CASE("trees are the bytes that they were", "[tree_hashes]") {
    const bool prints = std::getenv("CLBVH_PRINT_TREE_HASHES") != nullptr;
    for (const std::string& id : builders_and_presets()) {
        Builder builder = make_builder(id);
        for (const SceneGeneratorInfo& scene : scene_generators()) {
            const std::uint64_t hash = hash_of(builder.build(generate_scene(scene.name, kTriangles)));
            if (prints) {
                std::printf("    {\"%s\", \"%s\", 0x%016llxu},\n", id.c_str(), std::string(scene.name).c_str(),
                            static_cast<unsigned long long>(hash));
                continue;
            }
            INFO(id << " over gen:" << scene.name);
            CHECK(hash == expected(id, scene.name));
        }
    }
}

}  // namespace clbvh::test
