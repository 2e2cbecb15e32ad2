#include "host/build/primitive_bounds.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cstddef>

#include "core/prefix_sum.hpp"
#include "core/primitive_access.hpp"

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

/// Where each chunk's active primitives begin among all of them.
template <typename Boxes>
void place_active(const Boxes& boxes, std::span<std::size_t> first_of_chunk) {
    for_each_chunk(boxes.count(), [&](std::size_t chunk, std::size_t begin, std::size_t end, Bounds&) {
        std::size_t active = 0;
        for (std::size_t i = begin; i < end; ++i)
            active += boxes.is_inactive(i) ? 0 : 1;
        first_of_chunk[chunk] = active;
    });
    sum_before(first_of_chunk);
}

template <typename Boxes>
Bounds bound_all(const Boxes& boxes, std::span<Reference> references) {
    return for_each_chunk(boxes.count(), [&](std::size_t, std::size_t begin, std::size_t end, Bounds& bounds) {
        for (std::size_t i = begin; i < end; ++i)
            write(references[i], boxes.box(i), i, bounds);
    });
}

template <typename Boxes>
Bounds bound_active(const Boxes& boxes, std::span<Reference> references, Scratch& scratch) {
    const std::span<std::size_t> first_of_chunk = scratch.take<std::size_t>((boxes.count() + kChunk - 1) / kChunk);
    place_active(boxes, first_of_chunk);
    return for_each_chunk(boxes.count(), [&](std::size_t chunk, std::size_t begin, std::size_t end, Bounds& bounds) {
        Reference* target = references.data() + first_of_chunk[chunk];
        for (std::size_t i = begin; i < end; ++i) {
            if (!boxes.is_inactive(i)) write(*target++, boxes.box(i), i, bounds);
        }
    });
}

}  // namespace

Bounds bound_primitives(const Primitives& primitives, std::span<Reference> references, Scratch& scratch) {
    return with_boxes(primitives, [&](const auto& boxes) {
        return references.size() == boxes.count() ? bound_all(boxes, references)
                                                  : bound_active(boxes, references, scratch);
    });
}

}  // namespace clbvh::host
