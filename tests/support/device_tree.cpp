#include "support/device_tree.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>

#include "device/opencl/session.hpp"
#include "support/builders.hpp"

namespace clbvh::test {
namespace {

constexpr std::uint64_t kGuard = 4096;
constexpr std::uint8_t kGuardByte = 0xa5;

const cl::CommandQueue& queue() {
    return shared_context().session().queue();
}

const cl::Context& context() {
    return shared_context().session().context();
}

cl::Device device() {
    return queue().getInfo<CL_QUEUE_DEVICE>();
}

template <typename T>
void put(std::vector<std::uint8_t>& bytes, std::size_t at, const T& value) {
    if (bytes.size() < at + sizeof(T)) bytes.resize(at + sizeof(T), kGuardByte);
    std::memcpy(bytes.data() + at, &value, sizeof(T));
}

std::vector<std::uint8_t> bytes_of(const cl::Buffer& buffer, std::uint64_t begin, std::uint64_t size) {
    std::vector<std::uint8_t> bytes(size);
    if (size > 0) queue().enqueueReadBuffer(buffer, CL_TRUE, begin, size, bytes.data());
    return bytes;
}

template <typename T>
std::vector<T> values_of(const cl::Buffer& buffer, std::uint64_t begin, std::size_t count) {
    std::vector<T> values(count);
    if (count > 0) queue().enqueueReadBuffer(buffer, CL_TRUE, begin, count * sizeof(T), values.data());
    return values;
}

/// The box of triangle i; NaNs where one of its coordinates is.
Aabb box_of(const Mesh& mesh, std::size_t i) {
    Aabb box = triangle_bounds(mesh, i);
    if (is_inactive(mesh, i)) box.upper.y = std::numeric_limits<float>::quiet_NaN();
    return box;
}

std::uint64_t round_up(std::uint64_t value, std::uint64_t step) {
    return (value + step - 1) / step * step;
}

}  // namespace

const std::vector<InputLayout>& input_layouts() {
    using Kind = InputLayout::Kind;
    static const std::vector<InputLayout> layouts{
        {"32-bit indices", Kind::indexed_32, 0, 12, 0, 0},
        {"16-bit indices", Kind::indexed_16, 0, 12, 0, 0},
        {"no indices", Kind::triangles, 0, 12, 0, 0},
        {"boxes", Kind::boxes, 0, 24, 0, 0},
        {"32-bit indices with gaps", Kind::indexed_32, 20, 32, 8, 16},
        {"16-bit indices with gaps", Kind::indexed_16, 4, 16, 6, 10},
        {"no indices, with gaps", Kind::triangles, 8, 20, 0, 0},
        {"boxes with gaps", Kind::boxes, 12, 36, 0, 0},
    };
    return layouts;
}

cl::CommandQueue out_of_order_queue() {
    const auto supported = device().getInfo<CL_DEVICE_QUEUE_PROPERTIES>();
    if ((supported & CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE) == 0) return {};
    return {context(), device(), CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE | CL_QUEUE_PROFILING_ENABLE};
}

cl::CommandQueue own_queue() {
    return {context(), device()};
}

DeviceTree::DeviceTree(DeviceBuilder& builder, const InputLayout& layout, const Mesh& mesh, Placement placement)
    : builder_(builder), primitive_count_(mesh.triangles.size()) {
    make_input(layout, mesh);
    const DeviceBuildSizes sizes = builder.sizes(primitive_count_);
    place({{&nodes_, sizes.nodes}, {&ids_, sizes.primitive_ids}, {&scratch_, sizes.scratch}, {&count_, 4}}, placement);
}

void DeviceTree::make_input(const InputLayout& layout, const Mesh& mesh) {
    using Kind = InputLayout::Kind;
    const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
    const std::uint32_t index_size = layout.kind == Kind::indexed_16 ? 2 : 4;
    const std::uint32_t index_stride = layout.index_stride != 0 ? layout.index_stride : 3 * index_size;
    for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t vertex = mesh.triangles[i][k];
            const std::size_t index_at = layout.index_offset + i * index_stride + k * index_size;
            if (layout.kind == Kind::triangles) {
                put(vertex_bytes_, layout.vertex_offset + (3 * i + k) * layout.vertex_stride, mesh.vertices[vertex]);
            } else if (layout.kind == Kind::indexed_16) {
                put(index_bytes_, index_at, static_cast<std::uint16_t>(vertex));
            } else if (layout.kind == Kind::indexed_32) {
                put(index_bytes_, index_at, vertex);
            }
        }
        if (layout.kind == Kind::boxes) {
            put(vertex_bytes_, layout.vertex_offset + i * layout.vertex_stride, box_of(mesh, i));
        }
    }
    if (layout.kind == Kind::indexed_16 || layout.kind == Kind::indexed_32) {
        for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
            put(vertex_bytes_, layout.vertex_offset + i * layout.vertex_stride, mesh.vertices[i]);
    }
    vertices_ = cl::Buffer(context(), CL_MEM_READ_ONLY, vertex_bytes_.size());
    if (!index_bytes_.empty()) indices_ = cl::Buffer(context(), CL_MEM_READ_ONLY, index_bytes_.size());
    write_input(queue());
    if (layout.kind == Kind::boxes) {
        input_ = DeviceBoxes{count, {vertices_(), layout.vertex_offset}, layout.vertex_stride};
        return;
    }
    DeviceTriangles triangles;
    triangles.count = count;
    triangles.vertices = {vertices_(), layout.vertex_offset};
    triangles.vertex_stride = layout.vertex_stride;
    triangles.indices = {indices_(), layout.index_offset};
    triangles.index_type = layout.kind == Kind::indexed_16 ? IndexType::uint16 : IndexType::uint32;
    triangles.index_stride = layout.index_stride;
    input_ = triangles;
}

void DeviceTree::place(const std::vector<std::pair<Guarded*, std::uint64_t>>& pieces, Placement placement) {
    const std::uint64_t step = std::max(kGuard, builder_.alignment());
    std::uint64_t end = 0;
    cl::Buffer shared;
    if (placement != Placement::own_buffers) {
        std::uint64_t sum = 0;
        for (const auto& [piece, bytes] : pieces)
            sum += round_up(bytes, step) + 2 * step;
        shared = cl::Buffer(context(), CL_MEM_READ_WRITE, sum);
    }
    for (const auto& [piece, bytes] : pieces) {
        piece->bytes = bytes;
        const std::uint64_t whole = round_up(bytes, step) + 2 * step;
        piece->buffer = placement == Placement::own_buffers ? cl::Buffer(context(), CL_MEM_READ_WRITE, whole) : shared;
        piece->begin = end + step;
        queue().enqueueFillBuffer(piece->buffer, kGuardByte, end, whole);
        piece->span = {piece->buffer(), piece->begin};
        if (placement == Placement::sub_buffers) {
            const cl_buffer_region region{end, whole};
            piece->sub_buffer = piece->buffer.createSubBuffer(CL_MEM_READ_WRITE, CL_BUFFER_CREATE_TYPE_REGION, &region);
            piece->span = {piece->sub_buffer(), step};
        }
        if (placement != Placement::own_buffers) end += whole;
    }
    queue().finish();
}

void DeviceTree::enqueue_only() {
    builder_.enqueue(queue()(), input_, scratch(), result());
}

void DeviceTree::enqueue() {
    enqueue(queue()).wait();
}

cl::Event DeviceTree::enqueue(const cl::CommandQueue& on, const std::vector<cl_event>& wait_list) {
    cl_event event = nullptr;
    builder_.enqueue(on(), input_, scratch(), result(), wait_list, &event);
    return cl::Event(event);
}

Bvh DeviceTree::read() const {
    const std::uint32_t active = values_of<std::uint32_t>(count_.buffer, count_.begin, 1)[0];
    Bvh bvh;
    bvh.primitive_count = primitive_count_;
    if (active > primitive_count_) return bvh;
    bvh.nodes = values_of<Node>(nodes_.buffer, nodes_.begin, 2 * std::size_t{active});
    bvh.primitive_ids = values_of<std::uint32_t>(ids_.buffer, ids_.begin, active);
    return bvh;
}

Node DeviceTree::root() const {
    return values_of<Node>(nodes_.buffer, nodes_.begin, 1)[0];
}

bool DeviceTree::guards_are_whole() const {
    return std::ranges::all_of(std::array{&nodes_, &ids_, &scratch_, &count_}, [](const Guarded* piece) {
        const auto is_whole = [&](std::uint64_t begin) {
            const std::vector<std::uint8_t> bytes = bytes_of(piece->buffer, begin, kGuard);
            return std::ranges::count(bytes, kGuardByte) == static_cast<std::ptrdiff_t>(kGuard);
        };
        return is_whole(piece->begin - kGuard) && is_whole(piece->begin + piece->bytes);
    });
}

void DeviceTree::clear_input() {
    for (const cl::Buffer& buffer : {vertices_, indices_}) {
        if (buffer() == nullptr) continue;
        queue().enqueueFillBuffer(buffer, cl_uint{0}, 0, buffer.getInfo<CL_MEM_SIZE>() / 4 * 4);
    }
    queue().finish();
}

void DeviceTree::write_input(const cl::CommandQueue& on) {
    on.enqueueWriteBuffer(vertices_, CL_TRUE, 0, vertex_bytes_.size(), vertex_bytes_.data());
    if (indices_() != nullptr) on.enqueueWriteBuffer(indices_, CL_TRUE, 0, index_bytes_.size(), index_bytes_.data());
}

}  // namespace clbvh::test
