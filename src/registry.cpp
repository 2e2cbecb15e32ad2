#include "clbvh/registry.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include "clbvh/core/error.hpp"
#include "registry_rows.hpp"

namespace clbvh {
namespace {

// The table of builders. A new builder is one row here.
const BuilderRow kRows[] = {
    {{"ploc", "PLOC: nearest neighbours in Morton order, five kernels an iteration", "Meister, Bittner 2018",
      BuilderKind::device, true},
     &device::kPloc},
    {{"plocpp", "PLOC++: fused search and merge, two kernels an iteration, one work group for the top",
      "Benthin, Drabinski, Tessari, Dittebrandt 2022", BuilderKind::device, true},
     &device::kPlocpp},
    {{"plocpp-two-level", "PLOC++ Two-Level: independent Morton ranges, one work group each, then the top",
      "Benthin, Drabinski, Tessari, Dittebrandt 2022, section 4.5", BuilderKind::device, true},
     &device::kPlocppTwoLevel},
    {{"lbvh", "LBVH: the tree that sorted Morton codes imply, bottom-up in one pass",
      "Lauterbach et al. 2009, Karras 2012, Apetrei 2014", BuilderKind::device, false},
     &device::kLbvh},
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
    const auto row = std::ranges::find(kRows, id, [](const BuilderRow& r) { return r.info.id; });
    if (row == std::end(kRows)) {
        std::string known;
        for (const BuilderRow& r : kRows) {
            known += (known.empty() ? "" : ", ") + std::string(r.info.id);
        }
        throw Error(ErrorCode::invalid_input, "unknown builder '" + std::string(id) + "'; known are: " + known);
    }
    return *row;
}

const BuilderInfo& find_builder(std::string_view id) {
    return find_builder_row(id).info;
}

}  // namespace clbvh
