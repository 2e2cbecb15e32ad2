#include "aila2013/aila_builders.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bitset>
#include <clbvh/core/error.hpp>
#include <string>

namespace clbvh::tool {
namespace {

constexpr std::array kAilaIds{
    AilaBuilder{"lbvh", "LBVH", "lbvh", "", LeafMerging::never},
    AilaBuilder{"bbvh", "BBVH", "sweep-sah", ""},
    AilaBuilder{"sbvh", "SBVH", "sbvh", ""},
    AilaBuilder{"agglo", "Agglo", "locally-ordered", ""},
    AilaBuilder{"bittner", "Bittner", "lbvh", "reinsert-batches"},
    AilaBuilder{"hclimb", "H.Climb", "lbvh", "rotate", LeafMerging::twice},
    AilaBuilder{"anneal", "Anneal.", "lbvh", "anneal", LeafMerging::twice},
    AilaBuilder{"treelet", "Treelet", "lbvh", "treelet"},
    AilaBuilder{"streelet", "STreelet", "lbvh", "treelet-split"},
};

std::size_t index_of(std::string_view id) {
    const auto row = std::ranges::find(kAilaIds, id, &AilaBuilder::id);
    if (row != kAilaIds.end()) return static_cast<std::size_t>(row - kAilaIds.begin());
    std::string known;
    for (const AilaBuilder& each : kAilaIds)
        known += fmt::format("{}, ", each.id);
    throw Error(ErrorCode::invalid_input,
                fmt::format("unknown builder '{}' of the table; known are: {}or all of them: all", id, known));
}

}  // namespace

std::span<const AilaBuilder> aila_builders() noexcept {
    return kAilaIds;
}

std::vector<AilaBuilder> choose_aila_builders(std::string_view list) {
    std::bitset<kAilaIds.size()> wanted;
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
    std::vector<AilaBuilder> chosen;
    for (std::size_t i = 0; i < kAilaIds.size(); ++i) {
        if (wanted[i]) chosen.push_back(kAilaIds[i]);
    }
    return chosen;
}

}  // namespace clbvh::tool
