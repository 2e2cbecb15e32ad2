// Layouts made on the device in one shape, beside the host's: what Oclgrind watches.
//   oclgrind_lay_out_tree (group | lane)

#include <clbvh/clbvh.hpp>
#include <clbvh/device/device_tracer.hpp>
#include <clbvh/io/scene.hpp>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <iostream>
#include <span>
#include <string>
#include <vector>

#include "device_buffer.hpp"
#include "run_main.hpp"

namespace {

struct Input {
    clbvh::Context context;
    clbvh::DeviceTracer& tracer;
    clbvh::DeviceScene scene;
};

template <typename Elements>
bool are_at(const std::vector<std::byte>& memory, const clbvh::DeviceSpan& place, const Elements& expected) {
    return std::memcmp(memory.data() + place.offset, expected.data(), expected.size() * sizeof(expected[0])) == 0;
}

template <typename Layout, typename Elements>
bool is_made(Input input, clbvh::LayoutKind kind, const Layout& expected, const Elements& elements) {
    const std::uint64_t bytes = input.tracer.sizes(input.scene.bvh, kind).layout;
    const DeviceBuffer buffer(input.context, bytes);
    input.scene.layout = buffer.span();
    input.scene.layout_kind = kind;
    input.tracer.enqueue_layout(input.context.opencl_queue(), input.scene);
    std::vector<std::byte> memory(bytes);
    buffer.read(input.context, std::span(memory));
    const clbvh::DeviceLayout parts = clbvh::DeviceTracer::layout_of(input.scene);
    const std::vector<std::uint32_t> header{static_cast<std::uint32_t>(expected.nodes.size()),
                                            static_cast<std::uint32_t>(elements.size()), expected.depth};
    return are_at(memory, parts.header, header) && are_at(memory, parts.nodes, expected.nodes) &&
           are_at(memory, parts.elements, elements);
}

int run(const std::string& shape) {
    const clbvh::Mesh mesh = clbvh::generate_scene("soup", 300);
    const clbvh::Bvh bvh = clbvh::build(mesh, "locally-ordered");
    const clbvh::Context context = clbvh::Context::open();
    clbvh::DeviceTracerOptions options;
    options.shape = shape == "group" ? clbvh::Shape::group : clbvh::Shape::lane;
    clbvh::DeviceTracer tracer(context, options);
    const DeviceBuffer nodes(context, bvh.nodes), ids(context, bvh.primitive_ids), vertices(context, mesh.vertices),
        indices(context, mesh.triangles);
    const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
    Input input{context, tracer, {}};
    input.scene.bvh = {nodes.span(), static_cast<std::uint32_t>(bvh.nodes.size()), ids.span(), count, {}};
    input.scene.triangles.count = count;
    input.scene.triangles.vertices = vertices.span();
    input.scene.triangles.indices = indices.span();
    const auto wide4 = clbvh::make_layout<clbvh::Wide4>(bvh, mesh);
    const auto compressed8 = clbvh::make_layout<clbvh::Compressed8>(bvh, mesh);
    const auto skip = clbvh::make_layout<clbvh::SkipLayout>(bvh);
    const auto pair = clbvh::make_layout<clbvh::PairLayout>(bvh);
    const bool are_made = is_made(input, clbvh::LayoutKind::wide4, wide4, wide4.blocks) &&
                          is_made(input, clbvh::LayoutKind::compressed8, compressed8, compressed8.triangles) &&
                          is_made(input, clbvh::LayoutKind::skip, skip, skip.primitive_ids) &&
                          is_made(input, clbvh::LayoutKind::pair, pair, pair.primitive_ids);
    if (!are_made) std::cerr << "the device's layouts are not the host's\n";
    return are_made ? EXIT_SUCCESS : EXIT_FAILURE;
}

}  // namespace

int main(int argument_count, char** arguments) {
    return run_main([&] { return argument_count == 2 ? run(arguments[1]) : EXIT_FAILURE; });
}
