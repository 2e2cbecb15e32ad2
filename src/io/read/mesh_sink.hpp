#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "clbvh/core/mesh.hpp"
#include "clbvh/io/scene.hpp"

namespace clbvh::io {

/// What a reader of files fills: a mesh, and what else there is to say of the file. Readers call tick() now and then,
/// so that loading can be cancelled.
class MeshSink {
public:
    /// `name` is that of the file, for errors. `size` is the file's, in bytes, by which progress is estimated.
    MeshSink(std::string name, std::size_t size, ProgressCallback progress);

    /// What was read.
    struct Content {
        Mesh mesh;
        LoadReport report;
    };
    Mesh mesh;
    LoadReport report;
    std::uint64_t max_bytes;  ///< Of the mesh; half of the machine's memory unless said otherwise.

    /// Throws Error(out_of_memory) where so much more would be more than `max_bytes`.
    void require_room(std::uint64_t vertices, std::uint64_t triangles) const;

    /// Hands it over, and begins anew.
    [[nodiscard]] Content take_content();
    void put_content(Content&& content);

    [[nodiscard]] const std::string& name() const noexcept { return name_; }

    /// Appends a vertex, and returns its index. Throws Error(unsupported) where there are too many.
    std::uint32_t add_vertex(const Vec3& vertex);
    /// Appends a face of any number of corners, whose indices are in range. Fewer than three are skipped and counted.
    void add_face(std::span<const std::uint32_t> corners);
    /// The same for a face of less than three corners whose corners nobody knows.
    void skip_face();
    /// Appends a triangle.
    void add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c);
    /// Appends the triangles of a strip, every other one turned so that all face the same side. Triangles with a corner
    /// twice, which join strips, are left out.
    void add_strip(std::span<const std::uint32_t> corners);

    /// Says that so many bytes of the file have been read. Throws Error(cancelled) where progress says so.
    void tick(std::size_t bytes);
    /// The same where nothing is read: called for each of many items.
    void tick_item() {
        if (++items_ % kItemsPerTick == 0) tick_now();
    }
    /// The same where each call stands for much work.
    void tick_now();

    /// Throws Error(io) with the file's name.
    [[noreturn]] void fail(const std::string& what) const;

private:
    static constexpr std::size_t kItemsPerTick = 4096;

    std::string name_;
    std::size_t size_, bytes_ = 0, next_ = 0, items_ = 0;
    double fraction_ = 0.0;
    ProgressCallback progress_;
};

}  // namespace clbvh::io
