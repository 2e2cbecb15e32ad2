#pragma once

#include <cstddef>

// The test program's operator new counts, and can fail. It stands in place of the standard library's, for the whole
// program and the libraries that it loads.
namespace clbvh::test {

/// Lets the next `allowed` allocations succeed and the one behind them fail; negative: all succeed.
void allow_allocations(long allowed);
/// Lets the next `allowed` allocations succeed and all behind them fail, until allow_allocations(-1).
void allow_only_allocations(long allowed);

/// Counts allocations of at least `bytes` from now on, from 0.
void count_allocations(std::size_t bytes) noexcept;
[[nodiscard]] std::size_t counted_allocations() noexcept;

/// How many allocations of at least `bytes` there are in `body`.
template <typename Body>
[[nodiscard]] std::size_t allocations_of(std::size_t bytes, Body&& body) {
    count_allocations(bytes);
    body();
    return counted_allocations();
}

}  // namespace clbvh::test
