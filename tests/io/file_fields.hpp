#pragma once

#include <cstddef>
#include <cstring>
#include <string>

namespace clbvh::test {

/// What is at `offset` of a file's bytes.
template <typename T>
T field(const std::string& bytes, std::size_t offset) {
    T value{};
    std::memcpy(&value, bytes.data() + offset, sizeof value);
    return value;
}

template <typename T>
std::string with_field(std::string bytes, std::size_t offset, T value) {
    std::memcpy(bytes.data() + offset, &value, sizeof value);
    return bytes;
}

}  // namespace clbvh::test
