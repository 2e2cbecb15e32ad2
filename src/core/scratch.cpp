#include "core/scratch.hpp"

#include <algorithm>

namespace clbvh {

std::byte* Scratch::take_bytes(std::uint64_t bytes) {
    const std::uint64_t rounded = (bytes + kAlignment - 1) / kAlignment * kAlignment;
    const std::lock_guard lock(mutex_);
    if (blocks_.empty() || blocks_.back().bytes - used_in_last_ < rounded) {
        const std::uint64_t size = std::max((rounded + kHugePage - 1) / kHugePage * kHugePage, kHugePage);
        blocks_.push_back({allocate_in_huge_pages(size), size});
        used_in_others_ += used_in_last_;
        used_in_last_ = 0;
    }
    std::byte* const taken = blocks_.back().memory.get() + used_in_last_;
    used_in_last_ += rounded;
    return taken;
}

void Scratch::reset() {
    const std::lock_guard lock(mutex_);
    const std::uint64_t total = used_in_others_ + used_in_last_;
    used_in_last_ = 0;
    used_in_others_ = 0;
    if (blocks_.size() <= 1) return;
    // The next build of this size finds one block that is large enough.
    blocks_.clear();
    const std::uint64_t size = (total + kHugePage - 1) / kHugePage * kHugePage;
    blocks_.push_back({allocate_in_huge_pages(size), size});
}

std::uint64_t Scratch::bytes_in_use() const {
    const std::lock_guard lock(mutex_);
    return used_in_others_ + used_in_last_;
}

}  // namespace clbvh
