#include "device/build_buffers.hpp"

#include <algorithm>

#include "clbvh/core/error.hpp"
#include "device/device_memory.hpp"

namespace clbvh::device {
namespace {

constexpr std::uint64_t kNodeBytes = 64;  // a sibling pair a primitive
constexpr std::uint64_t kInnerBytes = 32;
constexpr std::uint64_t kLeafBytes = 24;
constexpr std::uint64_t kReferenceBytes = 4;

void check_allocation(const Session& session, std::uint64_t bytes, std::uint32_t primitives) {
    const std::uint64_t largest = session.info().max_allocation_bytes;
    if (bytes > largest) {
        throw Error(ErrorCode::unsupported,
                    std::to_string(primitives) + " primitives need a buffer of " + std::to_string(bytes >> 20) +
                        " MiB, but " + session.info().name + " allocates at most " + std::to_string(largest >> 20) +
                        " MiB at once, enough for " + std::to_string(largest / kNodeBytes) + " primitives");
    }
}

// The views of `small`, one after the other.
struct SmallLayout {
    std::uint64_t end = 0;
    std::uint64_t take(std::uint64_t bytes) {
        const std::uint64_t begin = end;
        end += align_for_views(bytes);
        return begin;
    }
};

constexpr std::uint64_t kBoundsBytes = 12 * 4;
constexpr std::uint64_t kPartialBytes = kBoundsBytes * BuildBuffers::kMostPieces;
constexpr std::uint64_t kTableBytes = 4 * 4 * 256 * 8;
constexpr std::uint64_t kParameterBytes = 16 * 4;

void cut_small(BuildBuffers& b, const Session& session, const BuildSettings& settings) {
    const std::uint64_t count_bytes =
        4 * std::uint64_t{std::max(256 * settings.most_sort_pieces, BuildBuffers::kMostPieces)};
    SmallLayout layout;
    const std::uint64_t bounds = layout.take(kBoundsBytes);
    const std::uint64_t partial = layout.take(kPartialBytes);
    const std::uint64_t counts = layout.take(count_bytes);
    const std::uint64_t tables = layout.take(kTableBytes);
    const std::uint64_t parameters = layout.take(kParameterBytes);
    const std::uint64_t root = layout.take(kReferenceBytes);
    const std::uint64_t remaining = layout.take(kReferenceBytes);
    b.small = allocate_buffer(session, layout.end);
    b.bounds = view_of(b.small, bounds, kBoundsBytes);
    b.partial_bounds = view_of(b.small, partial, kPartialBytes);
    b.counts = view_of(b.small, counts, count_bytes);
    b.morton_tables = view_of(b.small, tables, kTableBytes);
    b.morton_parameters = view_of(b.small, parameters, kParameterBytes);
    b.root_reference = view_of(b.small, root, kReferenceBytes);
    b.remaining = view_of(b.small, remaining, kReferenceBytes);
}

void allocate(BuildBuffers& b, const Session& session, std::uint64_t n) {
    const auto buffer = [&](std::uint64_t bytes) { return allocate_buffer(session, bytes); };
    const std::uint64_t quarter = align_for_views(4 * n);
    b.nodes = buffer(kNodeBytes * n);
    b.primitive_ids = buffer(kReferenceBytes * n);
    b.leaves = buffer(kLeafBytes * n + 2 * sizeof(float));  // two more words are read, see kernels/cluster.clh
    b.inner = buffer(std::max(kInnerBytes * n, 6 * quarter));
    b.references = buffer(2 * quarter);
    b.boxes = view_of(b.nodes, 0, 24 * n);
    b.pairs_a = view_of(b.inner, 0, 8 * n);
    b.pairs_b = view_of(b.inner, 2 * quarter, 8 * n);
    b.code_low = view_of(b.inner, 4 * quarter, 4 * n);
    b.code_high = view_of(b.inner, 5 * quarter, 4 * n);
    b.codes = view_of(b.references, 0, 8 * n);
    b.references_a = view_of(b.references, 0, 4 * n);
    b.references_b = view_of(b.references, quarter, 4 * n);
}

}  // namespace

cl::Buffer view_of(const cl::Buffer& parent, std::uint64_t offset, std::uint64_t bytes) {
    const cl_buffer_region region{offset, bytes};
    cl::Buffer buffer = parent;  // createSubBuffer is not const
    return buffer.createSubBuffer(CL_MEM_READ_WRITE, CL_BUFFER_CREATE_TYPE_REGION, &region);
}

void BuildBuffers::reserve(Session& session, const BuildSettings& settings, std::uint32_t primitives,
                           std::uint64_t extra_bytes) {
    check_allocation(session, std::max(kNodeBytes * primitives, extra_bytes), primitives);
    if (capacity_ < primitives || extra_capacity_ < extra_bytes) {
        // What is too small goes first, so that old and new are never alive together; after a failure nothing is held.
        const std::uint64_t n = std::max<std::uint64_t>(capacity_, primitives);
        const std::uint64_t extra_size = std::max(extra_capacity_, extra_bytes);
        *this = BuildBuffers{};
        BuildBuffers grown;
        with_opencl_errors("memory for " + std::to_string(primitives) + " primitives", [&] {
            cut_small(grown, session, settings);
            allocate(grown, session, n);
            if (extra_size > 0) {
                grown.extra = allocate_buffer(session, extra_size);
            }
        });
        *this = std::move(grown);
        capacity_ = n;
        extra_capacity_ = extra_size;
    }
    const std::uint64_t quarter = align_for_views(4 * std::uint64_t{primitives});
    bytes = (kNodeBytes + kReferenceBytes + kLeafBytes) * primitives + std::max(kInnerBytes * primitives, 6 * quarter) +
            2 * quarter + small.getInfo<CL_MEM_SIZE>() + extra_bytes;
}

}  // namespace clbvh::device
