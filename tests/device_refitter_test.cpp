// Trees refitted in device memory: refit()'s boxes, bit for bit, and its costs, in both shapes, with nothing allocated
// and nothing waited for.
#include "clbvh/device/device_refitter.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <string>

#include "clbvh/io/scene.hpp"
#include "clbvh/optimize/refit.hpp"
#include "device/stage_bench.hpp"
#include "support/builders.hpp"
#include "support/compare_trees.hpp"
#include "support/device_tree.hpp"
#include "support/expect_error.hpp"
#include "support/meshes.hpp"
#include "support/opencl_calls.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

const device::Session& session() {
    return shared_context().session();
}

cl_command_queue shared_queue() {
    return shared_context().opencl_queue();
}

/// A buffer of at least `bytes`, filled with a byte that is no box.
cl::Buffer filled_buffer(std::uint64_t bytes) {
    cl::Buffer buffer(session().context(), CL_MEM_READ_WRITE, bytes + 64);
    fill_bytes(buffer, 0x5a);
    return buffer;
}

template <typename T>
cl::Buffer uploaded(const std::vector<T>& values) {
    const cl::Buffer buffer = filled_buffer(values.size() * sizeof(T));
    if (!values.empty()) write(buffer, values);
    return buffer;
}

/// A tree of the host's and its mesh in device memory, with what refitting it takes.
class RefitMemory {
public:
    RefitMemory(const DeviceRefitter& refitter, const Bvh& tree, const Mesh& mesh)
        : tree_(tree),
          sizes_(refitter.sizes(static_cast<std::uint32_t>(tree.nodes.size()),
                                static_cast<std::uint32_t>(mesh.triangles.size()))),
          nodes_(uploaded(tree.nodes)),
          ids_(uploaded(tree.primitive_ids)),
          vertices_(uploaded(mesh.vertices)),
          indices_(uploaded(mesh.triangles)),
          order_(filled_buffer(sizes_.order)),
          scratch_(filled_buffer(std::max(sizes_.scratch, sizes_.quality_scratch))),
          sah_(filled_buffer(16)) {
        triangles_.count = static_cast<std::uint32_t>(mesh.triangles.size());
        triangles_.vertices = {vertices_()};
        triangles_.indices = {indices_()};
    }

    [[nodiscard]] DeviceNodes nodes() const { return {{nodes_()}, static_cast<std::uint32_t>(tree_.nodes.size()), {}}; }
    [[nodiscard]] DeviceSpan order() const { return {order_()}; }
    [[nodiscard]] DeviceSpan scratch() const { return {scratch_()}; }
    [[nodiscard]] DeviceSpan sah() const { return {sah_(), 4}; }
    [[nodiscard]] DeviceRefit refit() const {
        return {triangles_, {ids_()},  static_cast<std::uint32_t>(tree_.primitive_ids.size()),
                order(),    scratch(), sah()};
    }

    [[nodiscard]] Bvh read_tree() const {
        Bvh tree = tree_;
        tree.nodes = read<Node>(nodes_, tree_.nodes.size());
        return tree;
    }
    /// Cost before and after, or the cost and what was there.
    [[nodiscard]] std::vector<float> read_sah() const {
        std::vector<float> values = read<float>(sah_, 3);
        return {values[1], values[2]};
    }
    void move(const Mesh& moved) const { write(vertices_, moved.vertices); }

private:
    Bvh tree_;
    DeviceRefitSizes sizes_;
    cl::Buffer nodes_, ids_, vertices_, indices_, order_, scratch_, sah_;
    DeviceTriangles triangles_;
};

DeviceRefitter make_refitter(Shape shape, const SahCosts& costs = {}) {
    DeviceRefitterOptions options;
    options.shape = shape;
    options.costs = costs;
    return DeviceRefitter(shared_context(), options);
}

Mesh twisted(Mesh mesh, float by) {
    for (Vec3& vertex : mesh.vertices)
        vertex = {vertex.x + by * std::sin(5.0f * vertex.y), vertex.y, -vertex.z};
    return mesh;
}

void expect_costs(const std::vector<float>& sah, double before, double after) {
    CHECK(sah[0] == Approx(before).epsilon(1e-6));
    CHECK(sah[1] == Approx(after).epsilon(1e-6));
}

/// Refits `tree`, over `mesh`, to two frames in a row, in both shapes, beside the host.
void expect_refit(const Bvh& tree, const Mesh& mesh, const SahCosts& costs = {}) {
    const Mesh frames[] = {twisted(mesh, 0.3f), twisted(mesh, -2.0f)};
    for (const Shape shape : kBothShapes) {
        INFO(to_string(shape) << ", " << mesh.triangles.size() << " triangles");
        DeviceRefitter refitter = make_refitter(shape, costs);
        const RefitMemory memory(refitter, tree, mesh);
        refitter.enqueue_order(shared_queue(), memory.nodes(), memory.order());
        refitter.enqueue_quality(shared_queue(), memory.nodes(), memory.scratch(), memory.sah());
        const double quality = sah_cost(tree, costs);
        CHECK(memory.read_sah()[0] == Approx(quality).epsilon(1e-6));
        Bvh expected = tree;
        for (const Mesh& frame : frames) {
            const RefitStats stats = clbvh::refit(expected, frame, costs);
            memory.move(frame);
            refitter.enqueue(shared_queue(), memory.nodes(), memory.refit());
            CHECK(same_bytes(memory.read_tree(), expected));
            expect_costs(memory.read_sah(), stats.sah_before, stats.sah_after);
        }
    }
}

/// A tree in which every right child is a leaf: as deep as it has triangles.
Bvh chain_of(const Mesh& mesh) {
    const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
    Bvh tree;
    tree.primitive_count = count;
    tree.nodes.resize(2 * std::size_t{count});
    for (std::uint32_t i = 0; i < count; ++i)
        tree.primitive_ids.push_back(i);
    for (std::uint32_t level = 0; level + 1 < count; ++level) {
        Node& parent = tree.nodes[level == 0 ? 0 : 2 * level];
        parent.first = 2 * level + 2;
        tree.nodes[2 * level + 3] = {{}, level, {}, 1};
    }
    tree.nodes[count > 1 ? 2 * count - 2 : 0] = {{}, count - 1, {}, 1};
    clbvh::refit(tree, mesh);
    return tree;
}

}  // namespace

TEST_CASE("device refitter: trees of every builder, with leaves of one and of several primitives") {
    for (const char* const scene : {"city", "hair"}) {
        const Mesh mesh = generate_scene(scene, 3000);
        for (const BuilderInfo& builder : builders()) {
            for (const std::uint32_t leaf_size : {0u, 8u}) {
                INFO(scene << ", " << builder.id << ", leaves of " << leaf_size);
                BuildOptions options;
                options.max_leaf_size = leaf_size;
                expect_refit(make_builder(builder.id, options).build(mesh), mesh);
            }
        }
    }
}

TEST_CASE("device refitter: costs are those that were asked for") {
    const Mesh mesh = generate_scene("clustered", 2000);
    expect_refit(make_builder("plocpp").build(mesh), mesh, {2.0, 0.5});
    expect_refit(make_builder("plocpp").build(mesh), mesh, {0.0, 3.0});
}

TEST_CASE("device refitter: larger trees, chains, slots without a node, and hardly any primitives") {
    const Mesh large = generate_scene("terrain", 60000);
    expect_refit(make_builder("lbvh").build(large), large);
    const Mesh mesh = random_triangles(5000);
    expect_refit(chain_of(mesh), mesh);
    Bvh sparse = make_builder("binned-sah").build(mesh);
    sparse.nodes.resize(sparse.nodes.size() + 1001);
    expect_refit(sparse, mesh);
    for (const std::uint32_t count : {1u, 2u, 3u, 4u, 5u}) {
        const Mesh few = random_triangles(count);
        expect_refit(make_builder("plocpp").build(few), few);
    }
    const Mesh points = scaled(mesh, 0.0f);
    expect_refit(make_builder("plocpp").build(mesh), points);
}

TEST_CASE("device refitter: primitives with a NaN count for nothing, and leaves with none but such are empty") {
    const Mesh mesh = random_triangles(300);
    BuildOptions options;
    options.max_leaf_size = 4;
    const Bvh tree = make_builder("plocpp", options).build(mesh);
    Mesh partly = mesh;
    deactivate_triangles(partly, 0, 2);
    Mesh without = mesh;
    deactivate_triangles(without);
    for (const Shape shape : kBothShapes) {
        DeviceRefitter refitter = make_refitter(shape);
        const RefitMemory memory(refitter, tree, mesh);
        refitter.enqueue_order(shared_queue(), memory.nodes(), memory.order());
        memory.move(partly);
        refitter.enqueue(shared_queue(), memory.nodes(), memory.refit());
        const Bvh fitted = memory.read_tree();
        Aabb all;
        for (std::size_t i = 1; i < mesh.triangles.size(); i += 2)
            all = merge(all, triangle_bounds(mesh, i));
        CHECK(fitted.nodes[0].bounds() == all);
        CHECK(same_topology(fitted, tree));
        for (const Node& node : fitted.nodes) {
            if (!node.is_leaf()) continue;
            Aabb box;
            for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
                if (fitted.primitive_ids[i] % 2 == 1) box = merge(box, triangle_bounds(mesh, fitted.primitive_ids[i]));
            }
            CHECK(node.bounds() == box);
        }
        memory.move(without);
        refitter.enqueue(shared_queue(), memory.nodes(), memory.refit());
        CHECK(memory.read_tree().nodes[0].bounds() == Aabb{});
        CHECK(memory.read_sah()[1] == 0.0f);
        memory.move(mesh);
        refitter.enqueue(shared_queue(), memory.nodes(), memory.refit());
        CHECK(same_bytes(memory.read_tree(), tree));
    }
}

TEST_CASE("device refitter: a build, an order and refits follow each other on any queue, and nobody waits") {
    Mesh mesh = random_triangles(2000);
    deactivate_triangles(mesh, 5, 9);  // how many nodes there are is known on the device alone
    DeviceBuilder builder("hploc", shared_context());
    for (const InputLayout& layout : input_layouts()) {
        for (const cl::CommandQueue& queue : {session().queue(), out_of_order_queue()}) {
            if (queue() == nullptr) {
                WARN("SKIPPED: the device has no queues out of order");
                continue;
            }
            INFO(layout.name);
            DeviceTree tree(builder, layout, mesh);
            DeviceRefitter refitter(shared_context());
            const DeviceNodes nodes = DeviceNodes::of(tree.result(), 2000);
            const DeviceRefitSizes sizes = refitter.sizes(nodes.node_count, 2000);
            const cl::Buffer order = filled_buffer(sizes.order), scratch = filled_buffer(sizes.scratch);
            const cl::Buffer sah = filled_buffer(8);
            cl::UserEvent begin(session().context());
            cl_event built = nullptr, ordered = nullptr, refitted = nullptr;
            const OpenClCalls calls = opencl_calls_of([&] {
                const cl::Event end = tree.enqueue(queue, {begin()});
                clRetainEvent(end());
                built = end();
                refitter.enqueue_order(queue(), nodes, {order()}, {&built, 1}, &ordered);
                refitter.enqueue(queue(), nodes,
                                 {tree.input(), tree.result().primitive_ids, 2000, {order()}, {scratch()}, {sah()}},
                                 {&ordered, 1}, &refitted);
            });
            CHECK(calls.buffers == 0);
            CHECK(calls.programs == 0);
            CHECK(calls.waits == 0);
            queue.flush();
            const cl::Event owned[] = {cl::Event(built), cl::Event(ordered), cl::Event(refitted)};
            CHECK(owned[2].getInfo<CL_EVENT_COMMAND_EXECUTION_STATUS>() > CL_COMPLETE);
            begin.setStatus(CL_COMPLETE);
            owned[2].wait();
            const Bvh fitted = tree.read();
            CHECK(same_bytes(fitted, make_builder("hploc").build(mesh)));
            const double cost = sah_cost(fitted);
            expect_costs(read<float>(sah, 2), cost, cost);
            CHECK(tree.guards_are_whole());
        }
    }
}

TEST_CASE("device refitter: trees without nodes cost nothing") {
    const Mesh mesh;
    DeviceRefitter refitter(shared_context());
    const RefitMemory memory(refitter, Bvh{}, mesh);
    refitter.enqueue_order(shared_queue(), memory.nodes(), memory.order());
    refitter.enqueue(shared_queue(), memory.nodes(), memory.refit());
    CHECK(memory.read_sah() == std::vector{0.0f, 0.0f});
    fill_bytes(cl::Buffer(memory.sah().buffer, true), 0x5a);
    refitter.enqueue_quality(shared_queue(), memory.nodes(), memory.scratch(), memory.sah());
    CHECK(memory.read_sah()[0] == 0.0f);
    Mesh inactive = random_triangles(20);
    deactivate_triangles(inactive);
    DeviceBuilder builder("hploc", shared_context());
    DeviceTree tree(builder, input_layouts().front(), inactive);
    tree.enqueue();
    for (const Shape shape : kBothShapes) {
        DeviceRefitter shaped = make_refitter(shape);
        const DeviceNodes nodes = DeviceNodes::of(tree.result(), 20);
        const DeviceRefitSizes sizes = shaped.sizes(40, 20);
        const cl::Buffer order = filled_buffer(sizes.order), scratch = filled_buffer(sizes.scratch);
        const Node root = tree.root();
        shaped.enqueue_order(shared_queue(), nodes, {order()});
        shaped.enqueue(shared_queue(), nodes,
                       {tree.input(), tree.result().primitive_ids, 20, {order()}, {scratch()}, memory.sah()});
        CHECK(memory.read_sah() == std::vector{0.0f, 0.0f});
        CHECK(tree.root() == root);
    }
}

TEST_CASE("device refitter: what is wrong with memory of the caller's is named, and nothing is enqueued") {
    const Mesh mesh = random_triangles(100);
    const Bvh tree = make_builder("plocpp").build(mesh);
    DeviceRefitter refitter(shared_context());
    const RefitMemory memory(refitter, tree, mesh);
    const cl::Buffer read_only(session().context(), CL_MEM_READ_ONLY, 1 << 20);
    const auto expect_refused = [&](std::initializer_list<std::string> words, auto&& change) {
        DeviceNodes nodes = memory.nodes();
        DeviceRefit refit = memory.refit();
        cl_command_queue queue = shared_queue();
        change(queue, nodes, refit);
        const OpenClCalls calls = opencl_calls_of(
            [&] { expect_error(ErrorCode::invalid_input, words, [&] { refitter.enqueue(queue, nodes, refit); }); });
        CHECK(calls.launches == 0);
    };
    using Nodes = DeviceNodes&;
    using Refit = DeviceRefit&;
    using Queue = cl_command_queue&;
    expect_refused({"queue is null"}, [](Queue queue, Nodes, Refit) { queue = nullptr; });
    expect_refused({"the nodes", "no buffer"}, [](Queue, Nodes nodes, Refit) { nodes.nodes = {}; });
    expect_refused({"the nodes", "needs 32000000 bytes"},
                   [](Queue, Nodes nodes, Refit) { nodes.node_count = 1000000; });
    expect_refused({"the nodes", "multiple of"}, [](Queue, Nodes nodes, Refit) { nodes.nodes.offset = 32; });
    expect_refused({"the active count's offset"}, [&](Queue, Nodes nodes, Refit) {
        nodes.active_count = {read_only(), 2};
    });
    expect_refused({"the active count", "the nodes"},
                   [](Queue, Nodes nodes, Refit) { nodes.active_count = nodes.nodes; });
    expect_refused({"the primitive ids", "no buffer"}, [](Queue, Nodes, Refit r) { r.primitive_ids = {}; });
    expect_refused({"the primitive ids", "CL_MEM_READ_WRITE"},
                   [&](Queue, Nodes, Refit r) { r.primitive_ids = {read_only()}; });
    expect_refused({"the order", "no buffer"}, [](Queue, Nodes, Refit r) { r.order = {}; });
    expect_refused({"the order", "needs"}, [](Queue, Nodes, Refit r) { r.order.offset = 4096; });
    expect_refused({"the scratch", "needs"}, [](Queue, Nodes, Refit r) { r.scratch.offset = 4096; });
    expect_refused({"the order and the scratch overlap"}, [](Queue, Nodes, Refit r) { r.order = r.scratch; });
    expect_refused({"the costs' offset"}, [](Queue, Nodes, Refit r) { r.sah.offset = 2; });
    expect_refused({"the costs", "CL_MEM_READ_WRITE"}, [&](Queue, Nodes, Refit r) { r.sah = {read_only()}; });
    expect_refused({"the vertices", "no buffer"},
                   [](Queue, Nodes, Refit r) { std::get<DeviceTriangles>(r.input).vertices = {}; });
    expect_error(ErrorCode::invalid_input, {"the order", "no buffer"},
                 [&] { refitter.enqueue_order(shared_queue(), memory.nodes(), {}); });
    expect_error(ErrorCode::invalid_input, {"the scratch", "no buffer"},
                 [&] { refitter.enqueue_quality(shared_queue(), memory.nodes(), {}, memory.sah()); });
    expect_error(ErrorCode::invalid_input, {"cost"}, [] { make_refitter(Shape::automatic, {-1.0, 1.0}); });
}
