#include "device/opencl/hand_over_check.hpp"

#include <algorithm>
#include <array>
#include <bit>

#include "clbvh/core/error.hpp"
#include "kernels/core/hand_over_constants.h"

namespace clbvh::device {
namespace {

constexpr std::size_t kMostItems = 256;

cl::Buffer zeros(Session& session, std::uint64_t words) {
    const cl::Buffer buffer(session.context(), CL_MEM_READ_WRITE, sizeof(cl_uint) * words);
    session.queue().enqueueFillBuffer(buffer, cl_uint{0}, 0, sizeof(cl_uint) * words);
    return buffer;
}

}  // namespace

bool hand_over_passes_check(Session& session, std::uint32_t launches, const std::string& options) {
    const std::size_t items = std::min(kMostItems, std::bit_floor(session.info().max_work_group_size));
    const std::uint64_t places = std::uint64_t{kernels::HAND_OVER_DISTANCES} * (kernels::HAND_OVER_GROUPS / 2) * items;
    std::array<cl_uint, 3> found{};
    try {
        Kernel& kernel = session.kernel({"hand_over_check.cl", items, options}, "hand_over_check");
        const cl::Buffer meetings = zeros(session, places);
        const cl::Buffer words = zeros(session, kernels::HAND_OVER_WORDS * places);
        const cl::Buffer out = zeros(session, found.size());
        kernel.kernel.setArg(0, meetings);
        kernel.kernel.setArg(1, words);
        kernel.kernel.setArg(3, out);
        session.queue().finish();  // also where a queue of the caller's keeps no order
        for (cl_uint launch = 1; launch <= launches; ++launch) {
            kernel.kernel.setArg(2, launch);
            session.queue().enqueueNDRangeKernel(kernel.kernel, cl::NullRange,
                                                 cl::NDRange(kernels::HAND_OVER_GROUPS * items), cl::NDRange(items));
            session.queue().finish();
        }
        session.queue().enqueueReadBuffer(out, CL_TRUE, 0, sizeof(found), found.data());
    } catch (const cl::Error&) {
        return false;
    } catch (const Error&) {
        return false;
    }
    return found[0] == launches * places * kernels::HAND_OVER_SENT && found[1] == 0;
}

}  // namespace clbvh::device
