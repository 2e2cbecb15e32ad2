#include "device/opencl/lane_shape_check.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "clbvh/core/error.hpp"
#include "device/opencl/session.hpp"
#include "kernels/core/lane_check_constants.h"

namespace clbvh::device {
namespace {

constexpr std::uint32_t kGroups = 8;
constexpr std::uint32_t kLength = kernels::CHECK_LENGTH;
constexpr std::uint32_t kRows = kernels::CHECK_ROWS;
constexpr std::uint32_t kStride = kernels::CHECK_STRIDE;

std::uint32_t value_at(std::uint32_t group, std::uint32_t t, std::uint32_t row) {
    return (group * 7919u + t * 31u + row * 101u) * 2654435761u;
}

// The kernel stores each minimum over row 0, whose first slots later minima have read by then.
std::vector<std::uint32_t> expected_result() {
    std::vector<std::uint32_t> result;
    for (std::uint32_t group = 0; group < kGroups; ++group) {
        std::array<std::uint32_t, kStride> first_row{};
        for (std::uint32_t t = 0; t < kStride; ++t) {
            first_row[t] = value_at(group, t, 0);
        }
        for (std::uint32_t t = 0; t < kLength; ++t) {
            std::uint32_t best = first_row[t + kRows];
            for (std::uint32_t row = 1; row < kRows; ++row) {
                best = std::min(best, value_at(group, t + kRows - row, row));
            }
            first_row[t] = best;
        }
        std::array<std::uint32_t, 16> counters{};
        for (std::uint32_t t = 0; t < kLength; ++t) {
            result.push_back(first_row[t] + counters[first_row[t] & 15]++);
        }
    }
    return result;
}

}  // namespace

ProgramSpec lane_shape_check_program() {
    return {"lane_shape_check.cl", 1, ""};
}

bool lane_shape_passes_check(Session& session) {
    const std::vector<std::uint32_t> expected = expected_result();
    const std::size_t bytes = expected.size() * sizeof(std::uint32_t);
    std::vector<std::uint32_t> result(expected.size());
    try {
        Kernel& kernel = session.kernel(lane_shape_check_program(), "lane_shape_check");
        const cl::Buffer buffer(session.context(), CL_MEM_WRITE_ONLY, bytes);
        kernel.kernel.setArg(0, buffer);
        session.queue().enqueueNDRangeKernel(kernel.kernel, cl::NullRange, cl::NDRange(kGroups), cl::NDRange(1));
        session.queue().enqueueReadBuffer(buffer, CL_TRUE, 0, bytes, result.data());
    } catch (const cl::Error&) {
        return false;
    } catch (const Error&) {
        return false;
    }
    return result == expected;
}

}  // namespace clbvh::device
