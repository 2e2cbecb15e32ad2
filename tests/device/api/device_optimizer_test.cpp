// What every optimiser keeps on devices: a valid tree over the same leaves, no dearer than before, the same bytes in
// both shapes and on every run, whatever the tree; nothing allocated and nothing waited for.
#include "clbvh/device/device_optimizer.hpp"

#include <catch2/catch.hpp>

#include "clbvh/catalog.hpp"
#include "clbvh/core/validate.hpp"
#include "clbvh/device/batch_builder.hpp"
#include "clbvh/io/scene.hpp"
#include "clbvh/metrics/sah.hpp"
#include "device/opencl/session.hpp"
#include "support/box_sets.hpp"
#include "support/builders.hpp"
#include "support/device_tree.hpp"
#include "support/expect_error.hpp"
#include "support/hard_trees.hpp"
#include "support/meshes.hpp"
#include "support/opencl_calls.hpp"
#include "support/tree_on_device.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

std::vector<std::string> device_optimizers() {
    std::vector<std::string> ids;
    for (const OptimizerInfo& info : optimizers()) {
        if (info.on_device) ids.emplace_back(info.id);
    }
    return ids;
}

DeviceOptimizer make_optimizer(std::string_view ids, Shape shape) {
    DeviceOptimizerOptions options;
    options.shape = shape;
    return {ids, shared_context(), options};
}

/// Calls `check` with each optimiser in each shape.
template <typename Check>
void for_each_optimizer(Check check) {
    for (const std::string& id : device_optimizers()) {
        for (const Shape shape : {Shape::group, Shape::lane}) {
            INFO(id << ", " << to_string(shape));
            DeviceOptimizer optimizer = make_optimizer(id, shape);
            check(optimizer);
        }
    }
}

/// One of each optimiser in each shape, kept over many trees.
struct BothShapes {
    explicit BothShapes(const std::string& chosen_id)
        : id(chosen_id), group(make_optimizer(id, Shape::group)), lane(make_optimizer(id, Shape::lane)) {}
    std::string id;
    DeviceOptimizer group, lane;
};

std::vector<BothShapes> make_both_shapes() {
    std::vector<BothShapes> both;
    for (const std::string& id : device_optimizers())
        both.emplace_back(id);
    return both;
}

bool is_no_dearer(double cost, double than) {
    return cost <= than * (1.0 + 1e-12);
}

/// False after the first failed check.
bool expect_improved(BothShapes& optimizers, const Bvh& tree, const Mesh& mesh, const std::string& where) {
    INFO(optimizers.id << " on " << where);
    const Bvh better = optimizers.lane.optimize(tree);
    const bool is_valid = validate(better, mesh).error.empty();
    const bool is_cheap = is_no_dearer(sah_cost(better), sah_cost(tree));
    const bool same_leaves = leaves_of(better) == leaves_of(tree);
    const bool same_shapes = same_bytes(better, optimizers.group.optimize(tree));
    const bool same_again = same_bytes(better, optimizers.lane.optimize(tree));
    CHECK(is_valid);
    CHECK(is_cheap);
    CHECK(same_leaves);
    CHECK(same_shapes);
    CHECK(same_again);
    return is_valid && is_cheap && same_leaves && same_shapes && same_again;
}

}  // namespace

TEST_CASE("device optimizers: every one improves the tree of every builder, on every generated scene") {
    std::vector<BothShapes> all = make_both_shapes();
    REQUIRE_FALSE(all.empty());
    for (const SceneGeneratorInfo& scene : scene_generators()) {
        const Mesh mesh = generate_scene(scene.name, 1500);
        for (const BuilderInfo& builder : builders()) {
            const Bvh tree = make_builder(builder.id).build(mesh);
            for (BothShapes& optimizer : all) {
                const std::string where = std::string(builder.id) + ", " + std::string(scene.name);
                if (!expect_improved(optimizer, tree, mesh, where)) return;
            }
        }
    }
}

TEST_CASE("device optimizers: trees of a Morton order become much better") {
    const Mesh mesh = generate_scene("clustered", 20000);
    const Bvh tree = make_builder("lbvh").build(mesh);
    for_each_optimizer(
        [&](DeviceOptimizer& optimizer) { CHECK(sah_cost(optimizer.optimize(tree)) < 0.9 * sah_cost(tree)); });
}

TEST_CASE("device optimizers: small trees, inactive triangles, none at all") {
    std::vector<BothShapes> all = make_both_shapes();
    for (const std::uint32_t count : {0u, 1u, 2u, 3u, 4u, 5u, 7u, 8u, 9u, 30u}) {
        Mesh mesh = random_triangles(count);
        if (count > 4) deactivate_triangles(mesh, 1, 3);
        for (const char* const builder : {"lbvh", "sweep-sah"}) {
            for (BothShapes& optimizer : all)
                expect_improved(optimizer, make_builder(builder).build(mesh), mesh, std::to_string(count));
        }
    }
}

TEST_CASE("device optimizers: equal boxes, boxes without area, hard sets of boxes and chains end") {
    std::vector<std::pair<std::string, Mesh>> meshes{{"equal", coincident_triangles(3000)},
                                                     {"line", line_of_points(3000)}};
    for (const BoxSet& set : hard_box_sets(500))
        meshes.emplace_back(set.name, mesh_of_boxes(set.boxes));
    meshes.emplace_back("large numbers", scaled(random_triangles(500), largest_scale(random_triangles(500))));
    meshes.emplace_back("small numbers", scaled(random_triangles(500), 0x1p-70f));
    std::vector<BothShapes> all = make_both_shapes();
    for (const auto& [name, mesh] : meshes) {
        for (BothShapes& optimizer : all)
            expect_improved(optimizer, make_builder("plocpp").build(mesh), mesh, name);
    }
    const Mesh mesh = random_triangles(1501);
    const Bvh chain = chain_tree(mesh);
    REQUIRE(validate(chain, mesh).depth == 1500);
    for (BothShapes& optimizer : all) {
        expect_improved(optimizer, chain, mesh, "a chain");
        CHECK(sah_cost(optimizer.lane.optimize(chain)) < 0.8 * sah_cost(chain));
    }
    const Mesh long_mesh = coincident_triangles(50000);
    const Bvh long_chain = chain_tree(long_mesh);
    for (BothShapes& optimizer : all)
        CHECK(validate(optimizer.lane.optimize(long_chain), long_mesh).error == "");
}

TEST_CASE("device optimizers: slots that no node uses may hold anything on the host, and stay") {
    const Mesh mesh = random_triangles(1000);
    const Bvh tight = make_builder("lbvh").build(mesh);
    const Bvh sparse = with_strays(tight);
    for_each_optimizer([&](DeviceOptimizer& optimizer) {
        const Bvh better = optimizer.optimize(sparse);
        CHECK(validate(better, mesh).error == "");
        CHECK(sah_cost(better) == Approx(sah_cost(optimizer.optimize(tight))).epsilon(0.02));
        for (std::size_t i = 2; i < sparse.nodes.size(); i += 4) {
            REQUIRE(better.nodes[i] == sparse.nodes[i]);
            REQUIRE(better.nodes[i + 1] == sparse.nodes[i + 1]);
        }
    });
}

TEST_CASE("device optimizers: nodes that form no tree are named") {
    DeviceOptimizer optimizer = make_optimizer("treelet", Shape::automatic);
    const Bvh sound = make_builder("lbvh").build(random_triangles(20));
    const auto expect_refused = [&](std::initializer_list<std::string> words, std::uint32_t first) {
        Bvh tree = sound;
        tree.nodes[0].first = first;
        expect_error(ErrorCode::invalid_input, words, [&] { static_cast<void>(optimizer.optimize(tree)); });
    };
    expect_refused({"node 0", "children 3 and 4", "odd"}, 3);
    expect_refused({"node 0", "children 40 and 41", "there are 40 nodes"}, 40);
    expect_refused({"node 0", "children 0 and 1", "another parent, or are the root"}, 0);
}

TEST_CASE("device optimizers: a tree on the device becomes what the host's copy becomes, and nothing is waited for") {
    const Bvh tree = make_builder("lbvh").build(generate_scene("city", 20000));
    for_each_optimizer([&](DeviceOptimizer& optimizer) {
        const Bvh expected = optimizer.optimize(tree);
        CHECK(!same_bytes(expected, tree));
        const TreeOnDevice on_device(tree, optimizer);
        const OpenClCalls calls = opencl_calls_of(
            [&] { optimizer.enqueue(TreeOnDevice::queue()(), on_device.target(), {on_device.scratch()}); });
        CHECK(calls.launches > 0);
        CHECK(calls.buffers == 0);
        CHECK(calls.programs == 0);
        CHECK(calls.waits == 0);
        CHECK(on_device.read() == expected.nodes);
    });
}

TEST_CASE("device optimizers: an event is waited for and one is given, also out of order") {
    const Bvh tree = make_builder("lbvh").build(generate_scene("city", 5000));
    for (const cl::CommandQueue& queue : {TreeOnDevice::queue(), out_of_order_queue()}) {
        if (queue() == nullptr) {
            WARN("SKIPPED: the device has no queues out of order");
            continue;
        }
        for_each_optimizer([&](DeviceOptimizer& optimizer) {
            const TreeOnDevice on_device(tree, optimizer);
            const cl::CommandQueue writer = own_queue();
            writer.enqueueFillBuffer(on_device.nodes, 0, 0, tree.nodes.size() * sizeof(Node));
            writer.finish();
            cl::UserEvent written(TreeOnDevice::context());
            const std::vector<cl_event> wait_list{written()};
            cl_event end = nullptr;
            optimizer.enqueue(queue(), on_device.target(), {on_device.scratch()}, wait_list, &end);
            const cl::Event done(end);
            queue.flush();
            CHECK(done.getInfo<CL_EVENT_COMMAND_EXECUTION_STATUS>() > CL_COMPLETE);
            writer.enqueueWriteBuffer(on_device.nodes, CL_TRUE, 0, tree.nodes.size() * sizeof(Node), tree.nodes.data());
            written.setStatus(CL_COMPLETE);
            done.wait();
            CHECK(on_device.read() == optimizer.optimize(tree).nodes);
        });
    }
}

TEST_CASE("device optimizers: several run one after the other, and host-only and unknown ones are named") {
    const Bvh tree = make_builder("lbvh").build(generate_scene("city", 3000));
    DeviceOptimizer once = make_optimizer("treelet", Shape::automatic);
    DeviceOptimizer twice = make_optimizer("treelet,treelet", Shape::automatic);
    CHECK(same_bytes(twice.optimize(tree), once.optimize(once.optimize(tree))));
    CHECK(same_bytes(make_optimizer("", Shape::lane).optimize(tree), tree));
    expect_error(ErrorCode::unsupported, {"anneal", "host"}, [] { make_optimizer("treelet,anneal", Shape::lane); });
    expect_error(ErrorCode::invalid_input, {"unknown optimizer", "none"}, [] { make_optimizer("none", Shape::lane); });
    DeviceOptimizerOptions options;
    options.passes = 1001;
    expect_error(ErrorCode::invalid_input, {"passes"}, [&] { DeviceOptimizer("treelet", shared_context(), options); });
    CHECK(once.shape() != Shape::automatic);
    CHECK(once.alignment() > 0);
    CHECK(once.context().opencl_queue() == shared_context().opencl_queue());
}
