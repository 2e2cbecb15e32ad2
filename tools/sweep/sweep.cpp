#include "sweep/sweep.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <clbvh/core/error.hpp>
#include <clbvh/io/scene.hpp>
#include <cmath>
#include <iterator>

namespace clbvh::tool {
namespace {

constexpr std::uint32_t kSmallestSize = 10000;

const std::vector<Sweep>& sweeps() {
    static const std::vector<Sweep> list{
        {"radius", "ploc.search_radius", {1, 2, 4, 8, 12, 16, 24, 32}},
        {"size", "", {}},
        {"chunk", "ploc.chunk_size", {64, 128, 256, 512, 1024, 2048, 4096}},
        {"threshold", "ploc.single_group_threshold", {256, 512, 1024, 2048, 4096, 8192, 16384, 32768, 65536}},
    };
    return list;
}

bool is_read(const Sweep& sweep, std::string_view builder) {
    return sweep.option.empty() || reads_option(builder, sweep.option);
}

std::string readers_text(const Sweep& sweep) {
    std::vector<std::string_view> ids;
    for (const BuilderInfo& builder : builders()) {
        if (is_read(sweep, builder.id)) ids.push_back(builder.id);
    }
    return fmt::format("{}", fmt::join(ids, ", "));
}

}  // namespace

const std::vector<std::string>& sweep_names() {
    static const std::vector<std::string> names = [] {
        std::vector<std::string> list;
        std::ranges::transform(sweeps(), std::back_inserter(list), [](const Sweep& s) { return std::string(s.what); });
        return list;
    }();
    return names;
}

const Sweep& find_sweep(std::string_view name) {
    return *std::ranges::find(sweeps(), name, &Sweep::what);
}

void set_swept(const Sweep& sweep, BuildOptions& options, std::uint32_t value) {
    if (!sweep.option.empty()) set_option(options, sweep.option, std::to_string(value));
}

void keep_readers(const Sweep& sweep, BuilderChoice& choice) {
    const auto fail = [&](const std::string& why) {
        throw Error(ErrorCode::invalid_input, fmt::format("--sweep {}: {} {}; those that do: {}", sweep.what, why,
                                                          find_option(sweep.option).flag, readers_text(sweep)));
    };
    for (const std::string& id : choice.named_ids) {
        if (!is_read(sweep, id)) fail(fmt::format("{} does not read", id));
    }
    std::erase_if(choice.ids, [&](const std::string& id) { return !is_read(sweep, id); });
    if (!choice.ids.empty()) return;
    fail(fmt::format("{}no builder that can run here reads", choice.reason.empty() ? "" : choice.reason + ": "));
}

std::vector<std::uint32_t> sweep_sizes(std::uint32_t largest) {
    const auto size = [](int step) { return kSmallestSize * std::pow(10.0, 0.5 * step); };
    std::vector<std::uint32_t> sizes;
    // A size just below the largest would tell nothing.
    for (int step = 0; size(step) < 0.99 * largest; ++step)
        sizes.push_back(static_cast<std::uint32_t>(std::lround(size(step))));
    sizes.push_back(largest);
    return sizes;
}

std::vector<std::uint32_t> sweep_sizes(const std::string& scene, std::uint32_t largest) {
    if (!is_generated_scene(scene)) {
        throw Error(ErrorCode::invalid_input,
                    scene + " has one size; --sweep size takes generated scenes, as gen:NAME:COUNT (see clbvh scenes)");
    }
    const auto own = static_cast<std::uint32_t>(parse_generated_scene(scene).count.value_or(kDefaultSceneTriangles));
    const std::uint32_t last = largest > 0 ? largest : own;
    if (last < kSmallestSize) {
        throw Error(ErrorCode::invalid_input,
                    fmt::format("{}: sizes begin at {}, and {} is below it; give more triangles, or --sweep-to", scene,
                                kSmallestSize, last));
    }
    return sweep_sizes(last);
}

std::string with_count(const std::string& scene, std::uint32_t count) {
    const GeneratedScene generated = parse_generated_scene(scene);
    const std::string seed = generated.seed ? fmt::format(":{}", *generated.seed) : "";
    return fmt::format("gen:{}:{}{}", generated.name, count, seed);
}

}  // namespace clbvh::tool
