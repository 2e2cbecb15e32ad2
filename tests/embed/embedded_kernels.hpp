#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "clbvh/core/bvh.hpp"
#include "clbvh/core/mesh.hpp"
#include "clbvh/core/ray.hpp"
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

/// A scene in device memory as clbvh_trace.clh takes it.
class EmbeddedScene {
public:
    explicit EmbeddedScene(const Wide8& layout);
    EmbeddedScene(const Bvh& bvh, const Mesh& mesh);
    EmbeddedScene(const PairLayout& layout, const Mesh& mesh);
    EmbeddedScene(const SkipLayout& layout, const Mesh& mesh);

    /// Traces through a program with these options, on the shared context; `solid` is what the program's filter takes.
    [[nodiscard]] Embedded trace(const std::string& options, std::span<const Ray> rays, std::uint32_t solid = 1) const;

private:
    template <typename Tree>
    EmbeddedScene(const char* layout, const Tree& tree, std::size_t count, const Mesh& mesh);

    std::string layout_;
    std::uint32_t count_ = 0;
    cl::Buffer nodes_, leaves_, vertices_, indices_;
};

/// Builds `source` behind clbvh::embed_source(), on the shared context. Fails the test with the log where that fails.
[[nodiscard]] cl::Program build_embedded(const std::string& source, const std::string& options);

/// False where the device does not round as the host does, so that bits may differ.
[[nodiscard]] bool device_is_exact();

}  // namespace clbvh::test
