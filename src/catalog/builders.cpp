#include <algorithm>
#include <array>
#include <string>

#include "catalog/builder_rows.hpp"
#include "clbvh/core/error.hpp"
#include "host/agglomerative/aac.hpp"
#include "host/agglomerative/locally_ordered.hpp"
#include "host/top_down/binned_sah.hpp"
#include "host/top_down/median.hpp"
#include "host/top_down/sbvh.hpp"
#include "host/top_down/sweep_sah.hpp"

#if defined(CLBVH_NO_OPENCL)
#define ON_DEVICE(algorithm) nullptr
#else
#define ON_DEVICE(algorithm) (&device::algorithm)
#endif

namespace clbvh {

// Each is a file of src/device/build.
namespace device {
extern const DeviceAlgorithm kPloc, kPlocpp, kPlocppTwoLevel, kHploc, kHlbvh, kLbvh;
}

namespace {

/// The costs and the leaf size of a build in a builder's Config. A zero BuildOptions::max_leaf_size leaves the choice
/// to the builder.
template <typename Config>
Config within(const BuildOptions& options, Config config) {
    if constexpr (requires { config.inner_cost; }) {
        config.inner_cost = options.inner_cost;
        config.primitive_cost = options.primitive_cost;
    }
    if (options.max_leaf_size > 0) config.max_leaf_size = options.max_leaf_size;
    return config;
}

void run_binned_sah(host::HostBuild& build, const BuildOptions& options) {
    host::build_binned_sah(build, within(options, options.binned_sah));
}

void run_sbvh(host::HostBuild& build, const BuildOptions& options) {
    host::build_sbvh(build, within(options, options.sbvh));
}

void run_sweep_sah(host::HostBuild& build, const BuildOptions& options) {
    host::build_sweep_sah(build, within(options, SweepSahConfig{}));
}

void run_aac_hq(host::HostBuild& build, const BuildOptions& options) {
    host::build_aac(build, within(options, AacConfig::hq()));
}

void run_aac_fast(host::HostBuild& build, const BuildOptions& options) {
    host::build_aac(build, within(options, AacConfig::fast()));
}

void run_locally_ordered(host::HostBuild& build, const BuildOptions&) {
    host::build_locally_ordered(build);
}

void run_median(host::HostBuild& build, const BuildOptions& options) {
    host::build_median(build, within(options, MedianConfig{}));
}

// The table of builders. A new builder is one row here.
const BuilderRow kRows[] = {
    {.info = {.id = "ploc",
              .title = "PLOC: nearest neighbours in Morton order, five kernels an iteration",
              .paper = "Meister, Bittner 2018",
              .kind = BuilderKind::device},
     .device_algorithm = ON_DEVICE(kPloc)},
    {.info = {.id = "plocpp",
              .title = "PLOC++: fused search and merge, two kernels an iteration, one work group for the top",
              .paper = "Benthin, Drabinski, Tessari, Dittebrandt 2022",
              .kind = BuilderKind::device},
     .device_algorithm = ON_DEVICE(kPlocpp)},
    {.info = {.id = "plocpp-two-level",
              .title = "PLOC++ Two-Level: independent Morton ranges, one work group each, then the top",
              .paper = "Benthin, Drabinski, Tessari, Dittebrandt 2022, section 4.5",
              .kind = BuilderKind::device},
     .device_algorithm = ON_DEVICE(kPlocppTwoLevel)},
    {.info = {.id = "hploc",
              .title = "H-PLOC: the Morton tree bottom-up, the clusters of each node reduced among themselves",
              .paper = "Benthin, Meister, Barczak, Mehalwal, Tsakok, Kensler 2024",
              .kind = BuilderKind::device},
     .device_algorithm = ON_DEVICE(kHploc)},
    {.info = {.id = "hlbvh",
              .title = "HLBVH: the top of an LBVH, its largest nodes, built anew by binned SAH",
              .paper = "Pantaleoni, Luebke 2010",
              .kind = BuilderKind::device},
     .device_algorithm = ON_DEVICE(kHlbvh)},
    {.info = {.id = "lbvh",
              .title = "LBVH: the tree that sorted Morton codes imply, bottom-up in one pass",
              .paper = "Lauterbach et al. 2009, Karras 2012, Apetrei 2014",
              .kind = BuilderKind::device},
     .device_algorithm = ON_DEVICE(kLbvh)},
    {.info = {.id = "binned-sah",
              .title = "Binned SAH: top-down, the surface area heuristic between 16 bins an axis",
              .paper = "Wald 2007",
              .kind = BuilderKind::host},
     .host_algorithm = run_binned_sah},
    {.info = {.id = "sbvh",
              .title = "SBVH: top-down binned SAH that may cut primitives in two where their boxes overlap",
              .paper = "Stich, Friedrich, Dietrich 2009",
              .kind = BuilderKind::host},
     .host_algorithm = run_sbvh,
     .clips_triangles = true},
    {.info = {.id = "sweep-sah",
              .title = "Sweep SAH: top-down, the surface area heuristic between any two primitives in centroid order",
              .paper = "MacDonald, Booth 1990",
              .kind = BuilderKind::host},
     .host_algorithm = run_sweep_sah},
    {.info = {.id = "aac-hq",
              .title = "AAC-HQ: approximate agglomerative clustering, delta 20, epsilon 0.1",
              .paper = "Gu, He, Fatahalian, Blelloch 2013",
              .kind = BuilderKind::host},
     .host_algorithm = run_aac_hq},
    {.info = {.id = "aac-fast",
              .title = "AAC-Fast: approximate agglomerative clustering, delta 4, epsilon 0.2",
              .paper = "Gu, He, Fatahalian, Blelloch 2013",
              .kind = BuilderKind::host},
     .host_algorithm = run_aac_fast},
    {.info = {.id = "locally-ordered",
              .title = "Locally-ordered clustering: the exact greedy tree, bottom-up, with a kd-tree over the clusters",
              .paper = "Walter, Bala, Kulkarni, Pingali 2008",
              .kind = BuilderKind::host},
     .host_algorithm = run_locally_ordered},
    {.info = {.id = "median",
              .title = "Object median on the longest axis: the floor that everything must beat",
              .paper = "folklore",
              .kind = BuilderKind::host},
     .host_algorithm = run_median},
};

}  // namespace

std::span<const BuilderInfo> builders() noexcept {
    static const auto infos = [] {
        std::array<BuilderInfo, std::size(kRows)> list;
        std::ranges::transform(kRows, list.begin(), &BuilderRow::info);
        return list;
    }();
    return infos;
}

const BuilderRow& find_builder_row(std::string_view id) {
    const PresetInfo* const preset = find_preset(id);
    const std::string_view builder = preset == nullptr ? id : preset->builder;
    const auto row = std::ranges::find(kRows, builder, [](const BuilderRow& r) { return r.info.id; });
    if (row == std::end(kRows)) {
        std::string known;
        for (const BuilderRow& r : kRows) {
            known += (known.empty() ? "" : ", ") + std::string(r.info.id);
        }
        for (const PresetInfo& p : presets()) {
            known += ", " + std::string(p.id);
        }
        throw Error(ErrorCode::invalid_input, "unknown builder '" + std::string(id) + "'; known are: " + known);
    }
    return *row;
}

const BuilderInfo& find_builder(std::string_view id) {
    return find_builder_row(id).info;
}

}  // namespace clbvh
