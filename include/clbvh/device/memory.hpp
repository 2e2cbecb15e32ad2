#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <ranges>
#include <span>
#include <variant>

#include "clbvh/core/primitives.hpp"
#include "clbvh/device/opencl_handles.hpp"

namespace clbvh {

/// A C++ object of OpenCL's own headers, as cl::Buffer or cl::Event: called, it gives the handle that it holds.
template <typename Object, typename Handle>
concept OpenClObject = requires(const Object& object) {
    { object() } -> std::convertible_to<Handle>;
};

/// The caller's memory: a buffer from `offset` bytes on. The buffer may be a sub-buffer; nobody here keeps it alive.
struct DeviceSpan {
    cl_mem buffer = nullptr;
    std::uint64_t offset = 0;

    constexpr DeviceSpan() = default;
    // NOLINTBEGIN(google-explicit-constructor): a span is what the buffer is
    constexpr DeviceSpan(cl_mem memory, std::uint64_t first = 0) : buffer(memory), offset(first) {}
    template <OpenClObject<cl_mem> Buffer>
    DeviceSpan(const Buffer& memory, std::uint64_t first = 0) : buffer(memory()), offset(first) {}
    // NOLINTEND(google-explicit-constructor)
};

/// Events to wait for, of the caller's: any contiguous range of cl_event, or of objects that hold one and nothing else,
/// as std::vector<cl::Event>.
class EventList {
public:
    constexpr EventList() = default;
    constexpr EventList(const cl_event* first, std::size_t count) : events_(first, count) {}
    // NOLINTBEGIN(google-explicit-constructor): a list is what the range is
    template <std::ranges::contiguous_range Events>
    requires std::same_as<std::ranges::range_value_t<Events>, cl_event> EventList(const Events& events)
        : events_(std::ranges::data(events), std::ranges::size(events)) {}
    template <std::ranges::contiguous_range Events>
    requires(OpenClObject<std::ranges::range_value_t<Events>, cl_event> &&
             sizeof(std::ranges::range_value_t<Events>) == sizeof(cl_event)) EventList(const Events& events)
        : events_(reinterpret_cast<const cl_event*>(std::ranges::data(events)), std::ranges::size(events)) {}
    // NOLINTEND(google-explicit-constructor)

    [[nodiscard]] constexpr std::span<const cl_event> events() const noexcept { return events_; }

private:
    std::span<const cl_event> events_;
};

/// Triangles in device memory. Strides are in bytes.
struct DeviceTriangles {
    std::uint32_t count = 0;           ///< Triangles, at most kMaxPrimitives.
    DeviceSpan vertices;               ///< Three floats each; offset, a multiple of 4.
    std::uint32_t vertex_stride = 12;  ///< Bytes from one vertex to the next: 12 or more, a multiple of 4.
    DeviceSpan indices;                ///< Three for each triangle; offset, a multiple of the size of one. Without a
                                       ///< buffer vertices are taken three by three.
    IndexType index_type = IndexType::uint32;
    std::uint32_t index_stride = 0;  ///< Bytes from one triangle's first index to the next one's: those of three
                                     ///< indices or more, a multiple of those of one; 0: of three.
};

/// Boxes in device memory, for primitives that are not triangles.
struct DeviceBoxes {
    std::uint32_t count = 0;    ///< Boxes, at most kMaxPrimitives.
    DeviceSpan boxes;           ///< Six floats each, lower x y z and upper x y z; offset, a multiple of 4.
    std::uint32_t stride = 24;  ///< From one box to the next, in bytes: 24 or more, a multiple of 4.
};

/// Primitives in device memory to build a tree over.
using DeviceInput = std::variant<DeviceTriangles, DeviceBoxes>;

/// Where a build puts its tree.
struct DeviceResult {
    DeviceSpan nodes;          ///< Node [2 * active primitives], see Bvh::nodes; DeviceBuildSizes::nodes bytes.
    DeviceSpan primitive_ids;  ///< uint [active primitives], see Bvh::primitive_ids; DeviceBuildSizes::primitive_ids.
    DeviceSpan active_count;   ///< Becomes the number of active primitives, one uint; may be left out.
};

/// Bytes that a build needs. Nothing is read or written beyond them.
struct DeviceBuildSizes {
    std::uint64_t nodes = 0;          ///< 64 for each primitive.
    std::uint64_t primitive_ids = 0;  ///< 4 for each primitive.
    std::uint64_t scratch = 0;        ///< Free again when the build is done; the same for every input of this size.
};

/// A tree in device memory. Each class that takes one says in which fields it looks, and how they must be aligned.
struct DeviceBvh {
    DeviceSpan nodes;                   ///< Node [node_count], see Bvh::nodes.
    std::uint32_t node_count = 0;       ///< Or more, where the number of nodes in use is only known on the device.
    DeviceSpan primitive_ids = {};      ///< uint [reference_count], see Bvh::primitive_ids.
    std::uint32_t reference_count = 0;  ///< Or more; those beyond the tree's own are not used.
    /// One uint, offset a multiple of 4: leaves of the tree, at most node_count / 2; where all nodes are passed over,
    /// only the first 2 * leaves of them are. Without it all of them are, and slots that no node uses must be zero.
    DeviceSpan active_count = {};

    /// The tree that DeviceBuilder::enqueue builds over `primitive_count` primitives. Where some of them may be
    /// inactive, and the tree is to be optimised or refitted, `result` must have its active count.
    [[nodiscard]] static DeviceBvh of(const DeviceResult& result, std::uint32_t primitive_count) {
        return {result.nodes, 2 * primitive_count, result.primitive_ids, primitive_count, result.active_count};
    }
};

}  // namespace clbvh
