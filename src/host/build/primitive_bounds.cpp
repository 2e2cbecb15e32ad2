#include "host/build/primitive_bounds.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cstddef>
#include <string>

#include "clbvh/core/error.hpp"
#include "core/prefix_sum.hpp"

namespace clbvh::host {
namespace {

constexpr std::size_t kChunk = 8192;

/// Calls `work(chunk, begin, end, bounds)` for each kChunk primitives of `count`, in parallel, and returns the union of
/// the bounds that it was given to add to.
template <typename Work>
Bounds for_each_chunk(std::size_t count, const Work& work) {
    return tbb::parallel_reduce(
        tbb::blocked_range<std::size_t>(0, (count + kChunk - 1) / kChunk), Bounds{},
        [&](const auto& chunks, Bounds bounds) {
            for (std::size_t chunk = chunks.begin(); chunk < chunks.end(); ++chunk)
                work(chunk, chunk * kChunk, std::min(count, (chunk + 1) * kChunk), bounds);
            return bounds;
        },
        [](Bounds a, const Bounds& b) {
            a.add(b);
            return a;
        });
}

void write(Reference& target, const Aabb& box, std::size_t primitive, Bounds& bounds) {
    target = make_reference(box, static_cast<std::uint32_t>(primitive));
    bounds.add(target);
}

/// References of the active triangles among begin .. end, written from `target` on.
void bound_active(const Mesh& mesh, std::size_t begin, std::size_t end, Reference* target, Bounds& bounds) {
    for (std::size_t i = begin; i < end; ++i) {
        if (!is_inactive(mesh, i)) write(*target++, triangle_bounds(mesh, i), i, bounds);
    }
}

bool in_range(float lower, float upper) {
    return lower >= -kMaxCoordinate && lower <= upper && upper <= kMaxCoordinate;
}

bool is_legal(const Aabb& box) {
    return in_range(box.lower.x, box.upper.x) && in_range(box.lower.y, box.upper.y) &&
           in_range(box.lower.z, box.upper.z);
}

}  // namespace

Bounds bound_primitives(const Mesh& mesh, std::span<Reference> references, Scratch& scratch) {
    const std::size_t count = mesh.triangles.size();
    if (references.size() == count) {
        return for_each_chunk(count, [&](std::size_t, std::size_t begin, std::size_t end, Bounds& bounds) {
            for (std::size_t i = begin; i < end; ++i)
                write(references[i], triangle_bounds(mesh, i), i, bounds);
        });
    }
    const std::span<std::size_t> first_of_chunk = scratch.take<std::size_t>((count + kChunk - 1) / kChunk);
    for_each_chunk(count, [&](std::size_t chunk, std::size_t begin, std::size_t end, Bounds&) {
        std::size_t active = 0;
        for (std::size_t i = begin; i < end; ++i)
            active += is_inactive(mesh, i) ? 0 : 1;
        first_of_chunk[chunk] = active;
    });
    sum_before(first_of_chunk);
    return for_each_chunk(count, [&](std::size_t chunk, std::size_t begin, std::size_t end, Bounds& bounds) {
        bound_active(mesh, begin, end, references.data() + first_of_chunk[chunk], bounds);
    });
}

Bounds copy_boxes(std::span<const Aabb> boxes, std::span<Reference> references) {
    return for_each_chunk(boxes.size(), [&](std::size_t, std::size_t begin, std::size_t end, Bounds& bounds) {
        for (std::size_t i = begin; i < end; ++i)
            write(references[i], boxes[i], i, bounds);
    });
}

void check_boxes(std::span<const Aabb> bounds) {
    const auto offender = std::ranges::find_if_not(bounds, is_legal);
    if (offender == bounds.end()) return;
    throw Error(ErrorCode::invalid_input,
                "box " + std::to_string(offender - bounds.begin()) +
                    " has a NaN, a lower corner above its upper one, or a coordinate that is infinite or beyond the "
                    "limit; leave it out or repair it");
}

}  // namespace clbvh::host
