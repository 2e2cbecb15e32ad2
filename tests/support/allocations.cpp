#include "support/allocations.hpp"

#include <atomic>
#include <cstdlib>
#include <new>

namespace clbvh::test {
namespace {

/// Allocations that still succeed before one fails; negative: all do.
std::atomic<long> allocations_left{-1};
/// Those behind the one that fails do, too.
std::atomic<bool> is_exhausted_for_good{false};

std::atomic<std::size_t> least_counted{0}, counted{0};

bool may_allocate() noexcept {
    const long left = allocations_left.load();
    if (left < 0) return true;
    if (left == 0 && is_exhausted_for_good.load()) return false;
    return allocations_left.fetch_sub(1) > 0;
}

}  // namespace

void allow_allocations(long allowed) {
    is_exhausted_for_good = false;
    allocations_left = allowed;
}

void allow_only_allocations(long allowed) {
    is_exhausted_for_good = true;
    allocations_left = allowed;
}

void count_allocations(std::size_t bytes) noexcept {
    least_counted = bytes;
    counted = 0;
}

std::size_t counted_allocations() noexcept {
    return counted;
}

}  // namespace clbvh::test

void* operator new(std::size_t size) {
    void* const memory = clbvh::test::may_allocate() ? std::malloc(size == 0 ? 1 : size) : nullptr;
    if (memory == nullptr) throw std::bad_alloc();
    if (size >= clbvh::test::least_counted) ++clbvh::test::counted;
    return memory;
}
// A sanitizer's own would not fit the delete below.
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
    try {
        return operator new(size);
    } catch (const std::bad_alloc&) {
        return nullptr;
    }
}
void operator delete(void* memory) noexcept {
    std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
    std::free(memory);
}
