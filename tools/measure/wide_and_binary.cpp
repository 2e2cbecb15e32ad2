#include "measure/wide_and_binary.hpp"

namespace clbvh::tool {

void WideAndBinary::add(const std::string& name, RayEngine& engine) {
    entrants_.push_back({name, &engine});
    entrants_.push_back({name + ", binary", &counting_.emplace_back(engine, counts_)});
}

void WideAndBinary::measure(RayEngine& reference, const RaySet& set, std::size_t runs, RoundsProgress& progress) {
    costs_ = measure_rays(entrants_, reference, set, runs, progress);
}

}  // namespace clbvh::tool
