#include "build_arguments.hpp"

#include <initializer_list>
#include <optional>
#include <string_view>
#include <vector>

namespace clbvh::tool {
namespace {

constexpr const char* kTuning = "Tuning";

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

void add_size(CLI::App& command, const std::string& name, std::uint32_t& target, const std::string& help) {
    command.add_option(name, target, help)->group(kTuning)->type_name("N")->capture_default_str();
}

}  // namespace

void BuildArguments::add_options(CLI::App& command) {
    command.add_option("--device", device, "Index, type (gpu, cpu, accelerator) or part of a name; see clbvh devices")
        ->type_name("D");
    command
        .add_option("--radius", options.search_radius, "Neighbours searched to each side by PLOC and PLOC++, 1 to 32")
        ->type_name("R")
        ->capture_default_str();
    add_choice(command, "--shape", options.shape, {Shape::automatic, Shape::group, Shape::lane}, shape_from,
               "How kernels lay their work out");
    add_choice(command, "--sort-shape", options.sort_shape, {Shape::automatic, Shape::group, Shape::lane}, shape_from,
               "How the sort's kernels lay their work out")
        ->group(kTuning);
    add_choice(command, "--morton", options.morton_code, {MortonCode::xyz, MortonCode::extended}, morton_code_from,
               "Spatial code that orders the primitives")
        ->group(kTuning);
    add_choice(command, "--encoding", options.neighbour_encoding,
               {NeighbourEncoding::automatic, NeighbourEncoding::bits32, NeighbourEncoding::bits64},
               neighbour_encoding_from, "How PLOC++ packs a distance and its neighbour")
        ->group(kTuning);
    add_choice(command, "--search", options.neighbour_search,
               {NeighbourSearch::automatic, NeighbourSearch::symmetric, NeighbourSearch::scan}, neighbour_search_from,
               "How the group shape finds neighbours")
        ->group(kTuning);
    add_size(command, "--threshold", options.single_group_threshold,
             "plocpp: clusters below which one work group finishes the tree");
    add_size(command, "--chunk", options.chunk_size, "Clusters per chunk of the lane shape; 0: chosen for the device");
    add_size(command, "--work-group", options.work_group_size,
             "Work items per group of the group shape; 0: chosen for the device");
    add_size(command, "--ranges", options.range_count,
             "plocpp-two-level: least number of Morton ranges; 0: chosen for the device");
}

}  // namespace clbvh::tool
