#include "cli/build_arguments.hpp"

#include <CLI/CLI.hpp>
#include <clbvh/core/error.hpp>
#include <clbvh/optimizers.hpp>
#include <initializer_list>
#include <optional>
#include <string_view>
#include <type_traits>

namespace clbvh::tool {
namespace {

constexpr const char* kTree = "Trees of all builders";
constexpr const char* kHost = "Host builders";
constexpr const char* kDevice = "Device builders";
constexpr const char* kTuning = "Tuning of device builders";
constexpr const char* kHploc = "H-PLOC";
constexpr const char* kPaperPresplitLevel = "14";
constexpr const char* kPaperSplitQuota = "0.3";
constexpr const char* kForBuilding = ", for building; reported SAH is always at 1.2 and 1.0";

/// CLI11 takes an empty word for 0.
std::string refuse_empty(const std::string& value) {
    return value.empty() ? "needs a number" : "";
}

/// An option whose value is one of the names of `values`; the first of them is the default.
template <typename Enum>
CLI::Option* add_choice(CLI::App& command, const std::string& name, Enum& target, std::initializer_list<Enum> values,
                        std::optional<Enum> (*from)(std::string_view) noexcept, const std::string& help) {
    std::vector<std::string> names;
    for (const Enum value : values)
        names.emplace_back(to_string(value));
    return command
        .add_option_function<std::string>(
            name, [&target, from](const std::string& value) { target = from(value).value(); }, help)
        ->check(CLI::IsMember(names))
        ->type_name("NAME")
        ->default_str(std::string(to_string(target)));
}

}  // namespace

template <typename Field>
CLI::Option* BuildArguments::add_number(CLI::App& command, const std::string& name, Field field,
                                        const std::string& help) {
    checked_.push_back({name, [field](const BuildOptions& from, BuildOptions& to) { to.*field = from.*field; }});
    const bool whole = std::is_integral_v<std::remove_reference_t<decltype(options.*field)>>;
    return command.add_option(name, options.*field, help)
        ->check(refuse_empty)
        ->type_name(whole ? "N" : "X")
        ->capture_default_str();
}

void BuildArguments::add_options(CLI::App& command) {
    add_tree_options(command);
    add_host_options(command);
    add_device_options(command);
    add_device_tuning(command);
    add_hploc_options(command);
}

void BuildArguments::check() const {
    for (const Checked& option : checked_) {
        BuildOptions alone;
        option.copy(options, alone);
        try {
            check_options(alone);
        } catch (const Error& error) {
            throw Error(error.code(), option.name + ": " + error.what());
        }
    }
    check_options(options);
    try {
        check_optimizers(options.optimizers);
    } catch (const Error& error) {
        throw Error(error.code(), std::string("--optimize: ") + error.what());
    }
}

void BuildArguments::add_tree_options(CLI::App& command) {
    command
        .add_option("--optimize", options.optimizers,
                    "Improve finished trees: optimizers with commas between them, run in this order, before leaves are "
                    "merged; see clbvh builders")
        ->group(kTree)
        ->type_name("A,B,C");
    add_number(command, "--optimize-passes", &BuildOptions::optimize_passes,
               "Most passes of each optimizer; 0: as many as it finds worth while")
        ->group(kTree);
    add_choice(command, "--optimize-on", options.optimize_on, {OptimizeOn::host, OptimizeOn::device}, optimize_on_from,
               "Where they run; those that clbvh builders lists for devices run on the one that built the tree")
        ->group(kTree);
    add_number(
        command, "--max-leaf", &BuildOptions::max_leaf_size,
        "Largest leaf, 1 to 64: the builder's own where it makes leaves itself (binned-sah, sweep-sah, sbvh, aac, "
        "median); then leaves are merged up to it as far as that lowers the SAH cost. 0: as the builder leaves "
        "them")
        ->group(kTree);
    add_number(command, "--presplit", &BuildOptions::presplit_level,
               "Split triangles with an edge whose box exceeds the scene's volume / 2^LEVEL, 1 to 40; off unless given")
        ->group(kTree)
        ->type_name("[LEVEL]")
        ->expected(0, 1)
        ->default_str(kPaperPresplitLevel);
    add_number(command, "--split-quota", &BuildOptions::split_quota,
               "Split the triangles whose boxes have most surface to lose, so many times a triangle in all, above 0 to "
               "4; off unless given")
        ->group(kTree)
        ->type_name("[QUOTA]")
        ->expected(0, 1)
        ->default_str(kPaperSplitQuota);
    add_number(command, "--inner-cost", &BuildOptions::inner_cost,
               std::string("SAH cost of visiting an inner node") + kForBuilding)
        ->group(kTree);
    add_number(command, "--primitive-cost", &BuildOptions::primitive_cost,
               std::string("SAH cost of testing a primitive") + kForBuilding)
        ->group(kTree);
}

void BuildArguments::add_host_options(CLI::App& command) {
    add_number(command, "--threads", &BuildOptions::thread_count, "Threads of the host's work, 1 to 1024; 0: all")
        ->group(kHost);
    add_number(command, "--bins", &BuildOptions::bin_count, "Bins an axis of builders that bin, 2 to 64")->group(kHost);
    command
        .add_flag("--longest-axis", options.bin_longest_axis_only,
                  "Bin along the longest axis of the centroids' bounds only")
        ->group(kHost);
    add_number(command, "--alpha", &BuildOptions::split_alpha,
               "Least overlap, relative to the scene's area, that spatial splits are tried for, 0 to 1")
        ->group(kHost);
    add_number(command, "--budget", &BuildOptions::reference_budget,
               "Most references of spatial splits, as a multiple of the primitives, 1 to 8")
        ->group(kHost);
}

void BuildArguments::add_device_options(CLI::App& command) {
    command.add_option("--device", device, "Index, type (gpu, cpu, accelerator) or part of a name; see clbvh devices")
        ->group(kDevice)
        ->type_name("D");
    add_number(
        command, "--radius", &BuildOptions::search_radius,
        "Neighbours searched to each side by PLOC and PLOC++, 1 to 32; by hploc with --hploc-search window, 31 at most")
        ->group(kDevice)
        ->type_name("R");
    add_choice(command, "--shape", options.shape, {Shape::automatic, Shape::group, Shape::lane}, shape_from,
               "How kernels lay their work out")
        ->group(kDevice);
}

void BuildArguments::add_device_tuning(CLI::App& command) {
    add_choice(command, "--sort-shape", options.sort_shape, {Shape::automatic, Shape::group, Shape::lane}, shape_from,
               "How the sort's kernels lay their work out")
        ->group(kTuning);
    add_choice(command, "--morton", options.morton_code, {MortonCode::xyz, MortonCode::extended}, morton_code_from,
               "Spatial code that orders the primitives")
        ->group(kTuning);
    add_number(
        command, "--code-bits", &BuildOptions::code_bits,
        "Leading bits of the spatial code that are sorted: 33, 44 or 63; 0: 44, or 33 for hploc with --quality fast")
        ->group(kTuning);
    add_choice(command, "--encoding", options.neighbour_encoding,
               {NeighbourEncoding::automatic, NeighbourEncoding::bits32, NeighbourEncoding::bits64},
               neighbour_encoding_from, "How PLOC++ packs a distance and its neighbour")
        ->group(kTuning);
    add_choice(command, "--search", options.neighbour_search,
               {NeighbourSearch::automatic, NeighbourSearch::symmetric, NeighbourSearch::scan}, neighbour_search_from,
               "How the group shape finds neighbours")
        ->group(kTuning);
    add_number(command, "--threshold", &BuildOptions::single_group_threshold,
               "plocpp: clusters below which one work group finishes the tree, 2 to 1048576; 0: chosen for the "
               "device")
        ->group(kTuning);
    add_number(command, "--chunk", &BuildOptions::chunk_size,
               "Clusters per chunk of the lane shape, 64 to 4096 in steps of 64; 0: chosen for the device")
        ->group(kTuning);
    add_number(command, "--work-group", &BuildOptions::work_group_size,
               "Work items per group of the group shape, a power of two, 32 to 1024; 0: chosen for the device")
        ->group(kTuning);
    add_number(command, "--ranges", &BuildOptions::range_count,
               "plocpp-two-level: least number of Morton ranges, 1 to 512; 0: chosen for the device")
        ->group(kTuning);
}

void BuildArguments::add_hploc_options(CLI::App& command) {
    add_choice(command, "--quality", options.hploc_quality, {HplocQuality::balanced, HplocQuality::fast},
               hploc_quality_from,
               "hploc: what the options below become where they are left to it; fast also means --code-bits 33")
        ->group(kHploc);
    add_choice(command, "--hploc-search", options.hploc_search,
               {HplocSearch::automatic, HplocSearch::all_pairs, HplocSearch::window}, hploc_search_from,
               "Clusters of a node that are compared: each with all, or with --radius to each side")
        ->group(kHploc);
    add_number(command, "--cluster-limit", &BuildOptions::cluster_limit,
               "Clusters that a node of the Morton tree keeps, 8 or 16; 0: by --quality")
        ->group(kHploc);
    add_number(command, "--small-range", &BuildOptions::small_range,
               "Nodes of up to so many primitives keep --small-limit instead, 1 (none) to 2^30; 0: by --quality")
        ->group(kHploc);
    add_number(command, "--small-limit", &BuildOptions::small_limit, "Clusters that a small node keeps, 1 to 8; 0: 8")
        ->group(kHploc);
    add_choice(command, "--merge-pairs", options.merge_pairs,
               {PairMerging::automatic, PairMerging::on, PairMerging::off}, pair_merging_from,
               "Whether two primitives that share a node merge at once")
        ->group(kHploc);
}

}  // namespace clbvh::tool
