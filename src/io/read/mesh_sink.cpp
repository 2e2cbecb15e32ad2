#include "io/read/mesh_sink.hpp"

#include <unistd.h>

#include <algorithm>
#include <utility>

#include "clbvh/core/error.hpp"
#include "io/read/polygon.hpp"

namespace clbvh::io {
namespace {

constexpr std::size_t kBytesPerTick = std::size_t{1} << 18U;

std::uint64_t half_of_memory() {
    const long pages = sysconf(_SC_PHYS_PAGES), page_bytes = sysconf(_SC_PAGE_SIZE);
    if (pages <= 0 || page_bytes <= 0) return std::uint64_t{1} << 32U;
    return static_cast<std::uint64_t>(pages) / 2 * static_cast<std::uint64_t>(page_bytes);
}

}  // namespace

MeshSink::MeshSink(std::string name, std::size_t size, ProgressCallback progress)
    : max_bytes(half_of_memory()), name_(std::move(name)), size_(size), progress_(std::move(progress)) {}

void MeshSink::require_room(std::uint64_t vertices, std::uint64_t triangles) const {
    const std::uint64_t bytes =
        (mesh.vertices.size() + vertices) * sizeof(Vec3) + (mesh.triangles.size() + triangles) * sizeof(Triangle);
    if (bytes <= max_bytes) return;
    throw Error(ErrorCode::out_of_memory, name_ + ": the mesh needs more than " + std::to_string(max_bytes) +
                                              " bytes with all its instances; LoadOptions::max_bytes is the limit");
}

MeshSink::Content MeshSink::take_content() {
    bytes_ = next_ = 0;
    return {std::exchange(mesh, {}), std::exchange(report, {})};
}

void MeshSink::put_content(Content&& content) {
    mesh = std::move(content.mesh);
    report = content.report;
}

std::uint32_t MeshSink::add_vertex(const Vec3& vertex) {
    if (mesh.vertices.size() >= 0xFFFFFFFFU)
        throw Error(ErrorCode::unsupported, name_ + ": more than 2^32 vertices; split the scene");
    mesh.vertices.push_back(vertex);
    return static_cast<std::uint32_t>(mesh.vertices.size() - 1);
}

void MeshSink::add_face(std::span<const std::uint32_t> corners) {
    if (corners.size() < 3) return skip_face();
    ++report.faces;
    if (append_polygon(corners, mesh, [this] { tick_now(); }) == PolygonCut::fan) ++report.overlapping_fans;
}

void MeshSink::skip_face() {
    ++report.faces;
    ++report.skipped_faces;
}

void MeshSink::add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    ++report.faces;
    mesh.triangles.push_back({a, b, c});
}

void MeshSink::add_strip(std::span<const std::uint32_t> corners) {
    for (std::size_t i = 2; i < corners.size(); ++i) {
        const std::uint32_t a = corners[i - 2], b = corners[i - 1], c = corners[i];
        if (a == b || b == c || a == c) continue;
        i % 2 == 0 ? add_triangle(a, b, c) : add_triangle(b, a, c);
    }
}

void MeshSink::tick(std::size_t bytes) {
    bytes_ = bytes;
    if (bytes < next_) return;
    next_ = bytes + kBytesPerTick;
    tick_now();
}

void MeshSink::tick_now() {
    if (!progress_) return;
    const double fraction = static_cast<double>(bytes_) / static_cast<double>(std::max<std::size_t>(size_, 1));
    fraction_ = std::clamp(fraction, fraction_, 1.0);  // it never falls
    if (!progress_({"load", fraction_})) throw Error(ErrorCode::cancelled, name_ + ": loading was cancelled");
}

void MeshSink::fail(const std::string& what) const {
    throw Error(ErrorCode::io, name_ + ": " + what);
}

}  // namespace clbvh::io
