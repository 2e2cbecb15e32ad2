// The stages of device builders one by one, so that a change to one kernel is judged in isolation: device time from
// events, elements and bytes per second. docs/benchmark.md says how to run it.
#include <array>
#include <string>

#include "catalog/builder_rows.hpp"
#include "clbvh/core/error.hpp"
#include "device/build/bounds.hpp"
#include "device/build/device_algorithm.hpp"
#include "device/build/leaves.hpp"
#include "device/build/morton.hpp"
#include "device/build/radix_sort.hpp"
#include "stage_runner.hpp"

namespace clbvh::bench {
namespace {

using device::Launcher;

void launch_nothing(StageRunner&, Launcher&) {}

void bounds(StageRunner& on, Launcher& launcher) {
    device::launch_bounds(launcher, on.settings(), on.buffers(), on.mesh());
}

void codes(StageRunner& on, Launcher& launcher) {
    device::launch_morton(launcher, on.settings(), on.buffers(), on.size());
}

void count(StageRunner& on, Launcher& launcher) {
    device::launch_count_keys(launcher, on.settings(), on.buffers(), on.size());
}

void sort(StageRunner& on, Launcher& launcher) {
    device::launch_radix_sort(launcher, on.settings(), on.buffers(), on.size());
}

void leaves(StageRunner& on, Launcher& launcher) {
    device::launch_leaves(launcher, on.settings(), on.buffers(), on.size());
}

void before_sort(StageRunner& on, Launcher& launcher) {
    bounds(on, launcher);
    codes(on, launcher);
}

void before_leaves(StageRunner& on, Launcher& launcher) {
    before_sort(on, launcher);
    sort(on, launcher);
}

void before_clustering(StageRunner& on, Launcher& launcher) {
    before_leaves(on, launcher);
    leaves(on, launcher);
    device::launch_number_leaves(launcher, on.settings(), on.buffers(), on.size());
}

/// Kernel `name` of plocpp.cl, and how many groups its first iteration has.
device::Kernel& plocpp_kernel(StageRunner& on, std::string_view name) {
    return on.session().kernel(find_builder_row("plocpp").device_algorithm->program(on.settings()), name);
}

std::uint32_t plocpp_groups(StageRunner& on) {
    const std::uint32_t chunk = on.settings().chunk_size(2 * on.settings().configs.ploc.search_radius);
    return device::cut_into_pieces(on.size(), on.settings().groups_to_fill, chunk).count;
}

constexpr std::uint32_t kFirstIteration = 0;
constexpr std::uint32_t kNoThreshold = 1;

/// Neighbour search and merges of PLOC++'s first iteration.
void search_merge(StageRunner& on, Launcher& launcher) {
    const device::BuildBuffers& b = on.buffers();
    launcher.launch(plocpp_kernel(on, "search_merge"), plocpp_groups(on), b.references_a, b.cluster_counts,
                    kFirstIteration, kNoThreshold, b.leaves, b.inner, b.nodes, b.leaf_count, b.references_b, b.counts);
    // About a third of the clusters end, which is not known here.
    launcher.count_bytes(device::round_bytes(on.size(), on.size() / 3, 4));
}

void compact(StageRunner& on, Launcher& launcher) {
    const device::BuildBuffers& b = on.buffers();
    launcher.launch(plocpp_kernel(on, "compact"), plocpp_groups(on), b.references_b, b.cluster_counts, kFirstIteration,
                    kNoThreshold, b.leaf_count, b.counts, b.references_a);
    launcher.count_bytes((4 + 4 * 2 / 3) * std::uint64_t{on.size()});
}

void before_compact(StageRunner& on, Launcher& launcher) {
    before_clustering(on, launcher);
    search_merge(on, launcher);
}

struct Stage {
    const char* name;
    void (*prepare)(StageRunner&, Launcher&);
    void (*measured)(StageRunner&, Launcher&);
};

void add(const Stage& stage, const std::string& variant, const BuildOptions& options) {
    constexpr std::array kSizes{100'000, 1'000'000, 10'000'000};
    auto* benchmark = ::benchmark::RegisterBenchmark(
        (std::string(stage.name) + "/" + variant).c_str(), [stage, options](::benchmark::State& state) {
            StageRunner runner(options, static_cast<std::uint32_t>(state.range(0)));
            runner.run(state, stage.prepare, stage.measured);
        });
    for (const int size : kSizes)
        benchmark->Arg(size);
    benchmark->UseManualTime()->Unit(::benchmark::kMillisecond);
}

void add_sorts(const Stage& stage, const std::string& variant, BuildOptions options) {
    for (const std::uint32_t code_bits : {33u, 44u, 63u}) {
        options.device.code_bits = code_bits;
        add(stage, variant + "/code_bits:" + std::to_string(code_bits), options);
    }
}

void add_all(Shape shape) {
    BuildOptions options;
    options.device.shape = shape;
    options.device.sort_shape = shape;
    const std::string variant(to_string(shape));
    add({"bounds", launch_nothing, bounds}, variant, options);
    add_sorts({"morton", bounds, codes}, variant, options);
    options.device.morton_code = MortonCode::extended;
    add({"morton", bounds, codes}, variant + "/extended", options);
    options.device.morton_code = MortonCode::xyz;
    add({"count", before_sort, count}, variant, options);
    add_sorts({"sort", before_sort, sort}, variant, options);
    add({"leaves", before_leaves, leaves}, variant, options);
    add({"search_merge", before_clustering, search_merge}, variant, options);
    add({"compact", before_compact, compact}, variant, options);
}

}  // namespace
}  // namespace clbvh::bench

int main(int argc, char** argv) {
    for (const clbvh::Shape shape : {clbvh::Shape::lane, clbvh::Shape::group})
        clbvh::bench::add_all(shape);
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
    benchmark::RunSpecifiedBenchmarks();
    benchmark::Shutdown();
    return 0;
}
