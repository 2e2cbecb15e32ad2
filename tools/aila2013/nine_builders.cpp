#include "aila2013/nine_builders.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bitset>
#include <clbvh/core/error.hpp>
#include <string>

namespace clbvh::tool {
namespace {

constexpr std::array kNine{
    NineBuilder{"lbvh", "LBVH", "lbvh", "", LeafMerging::never},
    NineBuilder{"bbvh", "BBVH", "sweep-sah", ""},
    NineBuilder{"sbvh", "SBVH", "sbvh", ""},
    NineBuilder{"agglo", "Agglo", "locally-ordered", ""},
    NineBuilder{"bittner", "Bittner", "lbvh", "reinsert-batches"},
    NineBuilder{"hclimb", "H.Climb", "lbvh", "rotate", LeafMerging::twice},
    NineBuilder{"anneal", "Anneal.", "lbvh", "anneal", LeafMerging::twice},
    NineBuilder{"treelet", "Treelet", "lbvh", "treelet"},
    NineBuilder{"streelet", "STreelet", "lbvh", "treelet-split"},
};

std::size_t index_of(std::string_view id) {
    const auto row = std::ranges::find(kNine, id, &NineBuilder::id);
    if (row != kNine.end()) return static_cast<std::size_t>(row - kNine.begin());
    std::string known;
    for (const NineBuilder& each : kNine)
        known += fmt::format("{}, ", each.id);
    throw Error(ErrorCode::invalid_input,
                fmt::format("unknown builder '{}' of the table; known are: {}or all of them: all", id, known));
}

}  // namespace

std::span<const NineBuilder> nine_builders() noexcept {
    return kNine;
}

std::vector<NineBuilder> choose_nine(std::string_view list) {
    std::bitset<kNine.size()> wanted;
    for (std::size_t begin = 0; begin <= list.size();) {
        const std::size_t end = std::min(list.find(',', begin), list.size());
        const std::string_view id = list.substr(begin, end - begin);
        if (id == "all") {
            wanted.set();
        } else {
            wanted.set(index_of(id));
        }
        begin = end + 1;
    }
    std::vector<NineBuilder> chosen;
    for (std::size_t i = 0; i < kNine.size(); ++i) {
        if (wanted[i]) chosen.push_back(kNine[i]);
    }
    return chosen;
}

}  // namespace clbvh::tool
