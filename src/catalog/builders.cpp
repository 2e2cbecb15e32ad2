#include "clbvh/registry.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include "catalog/builder_rows.hpp"
#include "clbvh/core/error.hpp"
#include "clbvh/presets.hpp"
#include "host/agglomerative/aac.hpp"
#include "host/agglomerative/locally_ordered.hpp"
#include "host/top_down/binned_sah.hpp"
#include "host/top_down/median.hpp"
#include "host/top_down/sbvh.hpp"
#include "host/top_down/sweep_sah.hpp"

#if defined(CLBVH_NO_OPENCL)
#define ON_DEVICE(algorithm) nullptr
#else
#include "device/build/device_algorithm.hpp"
#define ON_DEVICE(algorithm) (&device::algorithm)
#endif

namespace clbvh {
namespace {

/// A zero BuildOptions::max_leaf_size leaves the choice to the builder.
template <typename Config>
Config with_leaf_size(Config config, const BuildOptions& options) {
    if (options.max_leaf_size > 0) config.max_leaf_size = options.max_leaf_size;
    return config;
}

template <typename Config>
Config with_costs(Config config, const BuildOptions& options) {
    config.inner_cost = options.inner_cost;
    config.primitive_cost = options.primitive_cost;
    return with_leaf_size(config, options);
}

void run_binned_sah(host::HostBuild& build, const BuildOptions& options) {
    BinnedSahConfig config;
    config.bin_count = options.bin_count;
    config.longest_axis_only = options.bin_longest_axis_only;
    host::build_binned_sah(build, with_costs(config, options));
}

void run_median(host::HostBuild& build, const BuildOptions& options) {
    host::build_median(build, with_leaf_size(MedianConfig{}, options));
}

void run_sbvh(host::HostBuild& build, const BuildOptions& options) {
    SbvhConfig config;
    config.bin_count = options.bin_count;
    config.spatial_bin_count = options.bin_count;
    config.alpha = options.split_alpha;
    config.reference_budget = options.reference_budget;
    host::build_sbvh(build, with_costs(config, options));
}

void run_sweep_sah(host::HostBuild& build, const BuildOptions& options) {
    host::build_sweep_sah(build, with_costs(SweepSahConfig{}, options));
}

void run_locally_ordered(host::HostBuild& build, const BuildOptions&) {
    host::build_locally_ordered(build);
}

void run_aac_hq(host::HostBuild& build, const BuildOptions& options) {
    host::build_aac(build, with_costs(AacConfig::hq(), options));
}

void run_aac_fast(host::HostBuild& build, const BuildOptions& options) {
    host::build_aac(build, with_costs(AacConfig::fast(), options));
}

// The table of builders. A new builder is one row here.
const BuilderRow kRows[] = {
    {{"ploc", "PLOC: nearest neighbours in Morton order, five kernels an iteration", "Meister, Bittner 2018",
      BuilderKind::device, true, true},
     ON_DEVICE(kPloc),
     nullptr},
    {{"plocpp", "PLOC++: fused search and merge, two kernels an iteration, one work group for the top",
      "Benthin, Drabinski, Tessari, Dittebrandt 2022", BuilderKind::device, true, true, true},
     ON_DEVICE(kPlocpp),
     nullptr},
    {{"plocpp-two-level", "PLOC++ Two-Level: independent Morton ranges, one work group each, then the top",
      "Benthin, Drabinski, Tessari, Dittebrandt 2022, section 4.5", BuilderKind::device, true, true},
     ON_DEVICE(kPlocppTwoLevel),
     nullptr},
    {{"hploc", "H-PLOC: the Morton tree bottom-up, the clusters of each node reduced among themselves",
      "Benthin, Meister, Barczak, Mehalwal, Tsakok, Kensler 2024", BuilderKind::device, true, false, false, true},
     ON_DEVICE(kHploc),
     nullptr},
    {{"lbvh", "LBVH: the tree that sorted Morton codes imply, bottom-up in one pass",
      "Lauterbach et al. 2009, Karras 2012, Apetrei 2014", BuilderKind::device, false},
     ON_DEVICE(kLbvh),
     nullptr},
    {{"binned-sah", "Binned SAH: top-down, the surface area heuristic between 16 bins an axis", "Wald 2007",
      BuilderKind::host, false},
     nullptr,
     run_binned_sah},
    {{"sbvh", "SBVH: top-down binned SAH that may cut primitives in two where their boxes overlap",
      "Stich, Friedrich, Dietrich 2009", BuilderKind::host, false},
     nullptr,
     run_sbvh,
     true},
    {{"sweep-sah", "Sweep SAH: top-down, the surface area heuristic between any two primitives in centroid order",
      "MacDonald, Booth 1990", BuilderKind::host, false},
     nullptr,
     run_sweep_sah},
    {{"aac-hq", "AAC-HQ: approximate agglomerative clustering, delta 20, epsilon 0.1",
      "Gu, He, Fatahalian, Blelloch 2013", BuilderKind::host, false},
     nullptr,
     run_aac_hq},
    {{"aac-fast", "AAC-Fast: approximate agglomerative clustering, delta 4, epsilon 0.2",
      "Gu, He, Fatahalian, Blelloch 2013", BuilderKind::host, false},
     nullptr,
     run_aac_fast},
    {{"locally-ordered",
      "Locally-ordered clustering: the exact greedy tree, bottom-up, with a kd-tree over the clusters",
      "Walter, Bala, Kulkarni, Pingali 2008", BuilderKind::host, false},
     nullptr,
     run_locally_ordered},
    {{"median", "Object median on the longest axis: the floor that everything must beat", "folklore", BuilderKind::host,
      false},
     nullptr,
     run_median},
};

}  // namespace

std::span<const BuilderInfo> builders() noexcept {
    static const std::vector<BuilderInfo> infos = [] {
        std::vector<BuilderInfo> list;
        std::ranges::transform(kRows, std::back_inserter(list), &BuilderRow::info);
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
