#pragma once

#include <string>
#include <vector>

#include "clbvh/core/bvh.hpp"
#include "clbvh/core/mesh.hpp"
#include "clbvh/device/device_builder.hpp"
#include "device/opencl/opencl.hpp"

namespace clbvh::test {

/// A way to lay primitives out in device memory.
struct InputLayout {
    enum class Kind { indexed_32, indexed_16, triangles, boxes };
    std::string name;
    Kind kind;
    std::uint32_t vertex_offset, vertex_stride;  ///< of the boxes for Kind::boxes
    std::uint32_t index_offset, index_stride;    ///< a stride of 0 leaves it to the builder
};

/// One of each kind without gaps, the first with 32-bit indices, and one of each with some.
[[nodiscard]] const std::vector<InputLayout>& input_layouts();

/// Where the buffers of a DeviceTree are.
enum class Placement {
    own_buffers,          ///< One buffer each.
    parts_of_one_buffer,  ///< All results in one buffer at different offsets.
    sub_buffers,          ///< Sub-buffers of one buffer, with offsets into them.
};

/// A queue of the shared context that is out of order; null where the device has none.
[[nodiscard]] cl::CommandQueue out_of_order_queue();
/// A second in-order queue of the shared context.
[[nodiscard]] cl::CommandQueue own_queue();

/// Device memory of one build with a DeviceBuilder on the shared context, with guard bytes around it.
class DeviceTree {
public:
    DeviceTree(DeviceBuilder& builder, const InputLayout& layout, const Mesh& mesh,
               Placement placement = Placement::own_buffers);

    /// Enqueues a build on the shared queue.
    void enqueue_only();
    /// The same, and waits for its end.
    void enqueue();
    /// The same on any queue and behind any events; does not wait.
    cl::Event enqueue(const cl::CommandQueue& on, const std::vector<cl_event>& wait_list = {});

    /// The tree, as Builder would return it.
    [[nodiscard]] Bvh read() const;
    [[nodiscard]] Node root() const;
    /// True where the bytes around the results and the scratch are as they were.
    [[nodiscard]] bool guards_are_whole() const;

    void clear_input();
    /// Writes the input again, through the queue `on`, and waits for that.
    void write_input(const cl::CommandQueue& on);

    [[nodiscard]] const DeviceInput& input() const { return input_; }
    [[nodiscard]] DeviceSpan scratch() const { return scratch_.span; }
    [[nodiscard]] DeviceResult result() const { return {nodes_.span, ids_.span, count_.span}; }

private:
    /// A piece of memory with guard bytes before and behind it.
    struct Guarded {
        cl::Buffer buffer;      // what holds it and the guards
        cl::Buffer sub_buffer;  // where the builder is given one
        std::uint64_t begin = 0, bytes = 0;
        DeviceSpan span;
    };

    void place(const std::vector<std::pair<Guarded*, std::uint64_t>>& pieces, Placement placement);
    void make_input(const InputLayout& layout, const Mesh& mesh);

    DeviceBuilder& builder_;
    std::uint64_t primitive_count_;
    std::vector<std::uint8_t> vertex_bytes_, index_bytes_;
    cl::Buffer vertices_, indices_;
    DeviceInput input_;
    Guarded nodes_, ids_, scratch_, count_;
};

}  // namespace clbvh::test
