#pragma once

#include <cstdint>

#include "device/opencl/session.hpp"

namespace clbvh::device {

/// A read-write buffer of `bytes` (at least 1). On CPU devices it lies in memory that asks the system for huge pages:
/// the sort's scatters and the clusters' gathers otherwise spend a good part of their time on address translation.
[[nodiscard]] cl::Buffer allocate_buffer(const Session& session, std::uint64_t bytes);

/// A buffer that stays for the next use, where it is large enough.
class KeptBuffer {
public:
    /// At least `bytes`; a null buffer where that is 0 and none was made before.
    const cl::Buffer& reserve(const Session& session, std::uint64_t bytes);
    void release() { *this = {}; }

private:
    cl::Buffer buffer_;
    std::uint64_t bytes_ = 0;
};

}  // namespace clbvh::device
