#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>

#include "clbvh/clbvh.hpp"

// Structures of callers that were compiled with another version: each begins with its size, and fields are only ever
// appended.
namespace clbvh::c {

/// Throws Error(invalid_input) where `size` is below that of the first version of `structure`.
inline void check_size(std::uint32_t size, std::size_t smallest, const std::string& structure) {
    if (size >= smallest) return;
    throw Error(ErrorCode::invalid_input, structure + ".size is " + std::to_string(size) + "; set it to sizeof(" +
                                              structure + "), which was never below " + std::to_string(smallest));
}

/// The fields that both the caller and this version know; those that only this version knows are 0. Throws as
/// check_size() does.
template <class Structure>
[[nodiscard]] Structure known_fields(const Structure& given, std::size_t smallest, const std::string& structure) {
    check_size(given.size, smallest, structure);
    Structure known{};
    std::memcpy(&known, &given, std::min<std::size_t>(given.size, sizeof(known)));
    return known;
}

/// Writes the fields that both know to the caller's structure, whose size was checked.
template <class Structure>
void write_known_fields(const Structure& known, Structure& given) {
    const std::uint32_t size = given.size;
    std::memcpy(&given, &known, std::min<std::size_t>(size, sizeof(known)));
    given.size = size;
}

}  // namespace clbvh::c
