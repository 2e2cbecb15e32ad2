#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "clbvh/core/bvh.hpp"

namespace clbvh {

/// A node whose sibling goes first, and where the ray enters it.
struct DeferredNode {
    const Node* node;
    float t;
};

/// A stack of nodes without allocations, for trees that are known to be at most kCapacity deep: of every level one node
/// at most is deferred.
class FixedNodeStack {
public:
    static constexpr std::size_t kCapacity = 64;

    [[nodiscard]] bool empty() const noexcept { return size_ == 0; }
    void push(const DeferredNode& deferred) noexcept { entries_[size_++] = deferred; }
    DeferredNode pop() noexcept { return entries_[--size_]; }

private:
    std::size_t size_ = 0;
    std::array<DeferredNode, kCapacity> entries_;  // NOLINT(cppcoreguidelines-pro-type-member-init): filled by push
};

/// The same for any depth: what does not fit goes to the heap.
class GrowingNodeStack {
public:
    [[nodiscard]] bool empty() const noexcept { return size_ == 0; }
    void push(const DeferredNode& deferred) {
        if (size_ < entries_.size()) {
            entries_[size_] = deferred;
        } else {
            overflow_.push_back(deferred);
        }
        ++size_;
    }
    DeferredNode pop() noexcept {
        if (--size_ < entries_.size()) return entries_[size_];
        const DeferredNode deferred = overflow_.back();
        overflow_.pop_back();
        return deferred;
    }

private:
    std::size_t size_ = 0;
    std::array<DeferredNode, FixedNodeStack::kCapacity> entries_;
    std::vector<DeferredNode> overflow_;
};

}  // namespace clbvh
