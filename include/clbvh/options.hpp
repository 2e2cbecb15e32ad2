#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "clbvh/core/build_stats.hpp"
#include "clbvh/device/device_builder_configs.hpp"
#include "clbvh/export.h"
#include "clbvh/host/binned_sah.hpp"
#include "clbvh/host/sbvh.hpp"
#include "clbvh/layout/node_opening.hpp"

namespace clbvh {

/// Where the optimisers of a build run. On a device they can be cancelled only before they begin.
enum class OptimizeOn : std::uint8_t {
    host,    ///< All optimisers, on the tree of any builder.
    device,  ///< On the device that built the tree, before it is downloaded; those with OptimizerInfo::on_device.
};

/// "host", "device"; empty for what is no enumerator.
[[nodiscard]] constexpr std::string_view to_string(OptimizeOn where) noexcept {
    switch (where) {
        case OptimizeOn::host: return "host";
        case OptimizeOn::device: return "device";
    }
    return {};
}

/// Options of all builds, and one Config for each builder or family of builders that has options of its own; those of
/// device builders are DeviceBuilderConfigs' members. Each builder reads those that concern it; options() says which.
struct BuildOptions : DeviceBuilderConfigs {
    float inner_cost = 1.2f;           ///< Cost of visiting an inner node, above 0: SAH builders, merging of leaves.
    float primitive_cost = 1.0f;       ///< Cost of testing one primitive, above 0: the same.
    std::uint32_t max_leaf_size = 0;   ///< Most primitives of a leaf, 1 to 64. Where given, the finished tree's leaves
                                       ///< are merged as far as that lowers its SAH cost; 0: as the builder leaves it.
    std::uint32_t presplit_level = 0;  ///< Before any builder, split triangles that have an edge whose box is larger
                                       ///< than the scene's volume / 2^level, 1 to 40; the paper's is 14. 0: do not.
    float split_quota = 0.0f;  ///< Before any builder, split the triangles whose boxes have most to lose, so that
                               ///< there are at most so many splits a triangle, above 0 to 4; 0.3 is the paper's
                               ///< (see docs/presplit.md). 0: do not. Not with presplit_level.
    std::string optimizers;    ///< After any builder, before leaves are merged: ids of optimizers() with commas
                               ///< between them, "reinsert" say. Empty: none.
    std::uint32_t optimize_passes = 0;  ///< Most passes of each of them; on a device never more than 1000. 0: as many
                                        ///< as it finds worth while.
    OptimizeOn optimize_on = OptimizeOn::host;  ///< Where they run; see OptimizeOn.
    bool ray_cost = false;  ///< Fill BuildStats::ray_cost, where a Builder builds over triangles; tens of ms.
    NodeOpening opening = NodeOpening::largest_first;  ///< Of what Builder::build_layout and build_tracer make.
    std::uint32_t thread_count = 0;  ///< Threads of the host's work, 1 to 1024; 0: all. The tree is always the same.

    /// The costs and the largest leaf of these two are those above: here they must be left alone.
    BinnedSahConfig binned_sah;
    SbvhConfig sbvh;

    ProgressCallback progress;  ///< See ProgressCallback; may cancel.
};

/// Throws Error(invalid_input) naming the first option out of its range, the first unknown optimiser, or options that
/// contradict each other.
CLBVH_API void check_options(const BuildOptions& options);

/// The kind of values that an option has, and how a text says them.
enum class OptionType : std::uint8_t {
    whole,    ///< std::uint32_t: "16".
    real,     ///< float: "0.3", "1e-05".
    boolean,  ///< bool: "on" or "off".
    choice,   ///< An enumerator, by its name: "lane".
    text,     ///< std::string.
};

/// One row of the table of options.
struct OptionInfo {
    std::string_view name;     ///< Its member in BuildOptions: "max_leaf_size", "ploc.search_radius".
    std::string_view flag;     ///< That of the command line: "--radius". Options that share one are set together.
    std::string_view group;    ///< The heading that it stands under in lists.
    std::string_view help;     ///< Its effect, in one sentence.
    std::string_view readers;  ///< "all" builders, all "device" builders, or ids with ", " between them.
    OptionType type;
    std::string values;                     ///< Which values are allowed, for people: "1 to 32".
    std::string default_value;              ///< That of BuildOptions, as get_option says it.
    std::string_view implied;               ///< The value of the flag alone; empty: it needs a value.
    std::vector<std::string_view> choices;  ///< The names of OptionType::choice, in order.
};

/// Every option, in the order in which lists show them. Options of one group follow each other. The first call throws
/// Error(out_of_memory) where the host has no memory for the table.
[[nodiscard]] CLBVH_API std::span<const OptionInfo> options();

/// The row of `name`. Throws Error(invalid_input) that lists the known names.
[[nodiscard]] CLBVH_API const OptionInfo& find_option(std::string_view name);

/// Sets an option to what `value` says. Throws Error(invalid_input) where there is no such option, or the value is none
/// of those that it takes, naming the option and these; `options` are then as they were.
CLBVH_API void set_option(BuildOptions& options, std::string_view name, std::string_view value);

/// The value of an option as set_option takes it. Throws Error(invalid_input) where there is no such option.
[[nodiscard]] CLBVH_API std::string get_option(const BuildOptions& options, std::string_view name);

/// Whether the builder, or that of the preset, of id `builder` reads an option. Throws Error(invalid_input) for unknown
/// ids and names.
[[nodiscard]] CLBVH_API bool reads_option(std::string_view builder, std::string_view name);

}  // namespace clbvh
