#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "clbvh/core/bvh.hpp"
#include "clbvh/core/mesh.hpp"
#include "clbvh/core/ray.hpp"
#include "clbvh/layout/compressed8.hpp"
#include "clbvh/layout/pair.hpp"
#include "clbvh/layout/skip.hpp"
#include "clbvh/layout/wide.hpp"
#include "device/opencl/opencl.hpp"

namespace clbvh::test {

/// How many hits a ray has, and a number that depends on all of them and on their order.
struct AllHits {
    std::uint32_t count = 0;
    std::uint32_t digest = 0x811C9DC5;

    void add(const Hit& hit) noexcept;
    friend bool operator==(const AllHits&, const AllHits&) = default;
};

/// What kernels find that are not the library's own.
struct Embedded {
    std::vector<Hit> closest;
    std::vector<std::uint8_t> any;
    std::vector<AllHits> all;
};

/// What kernels hand through to the hooks.
using User = std::vector<std::array<float, 4>>;

/// A scene in device memory as clbvh_trace.clh takes it.
class EmbeddedScene {
public:
    explicit EmbeddedScene(const Wide8& layout);
    explicit EmbeddedScene(const Wide4& layout);
    explicit EmbeddedScene(const Compressed8& layout);
    EmbeddedScene(const Compressed8& layout, const Mesh& mesh);
    EmbeddedScene(const PairLayout& layout, const Mesh& mesh);
    EmbeddedScene(const SkipLayout& layout, const Mesh& mesh);
    EmbeddedScene(const Bvh& bvh, const Mesh& mesh);

    /// As CLBVH_LAYOUT has it.
    [[nodiscard]] const std::string& layout() const noexcept { return layout_; }
    /// Traces through a program with these options, on the shared context.
    [[nodiscard]] Embedded trace(const std::string& options, std::span<const Ray> rays, const User& user = {}) const;

private:
    template <typename Nodes, typename Leaves>
    EmbeddedScene(const char* layout, const Nodes& nodes, const Leaves& leaves, std::size_t count);
    void set_mesh(const Mesh& mesh);

    std::string layout_;
    std::uint32_t count_ = 0;
    cl::Buffer nodes_, leaves_, vertices_, indices_;
};

/// A tree in each layout: where there are triangles of their own in it, with the mesh beside them.
[[nodiscard]] std::vector<EmbeddedScene> embedded_scenes(const Bvh& bvh, const Mesh& mesh);

/// Builds `source` behind clbvh::embed_source(), on the shared context. Fails the test with the log where that fails.
[[nodiscard]] cl::Program build_embedded(const std::string& source, const std::string& options);

/// False where the device does not round as the host does, so that bits may differ.
[[nodiscard]] bool device_is_exact();

}  // namespace clbvh::test
