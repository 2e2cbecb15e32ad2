#include "device/opencl/memory_block.hpp"

namespace clbvh::device {

cl::Buffer view_of(const Block& block, std::uint64_t offset, std::uint64_t bytes) {
    const cl_buffer_region region{block.offset + offset, bytes};
    cl::Buffer buffer = block.buffer;  // createSubBuffer is not const
    return buffer.createSubBuffer(CL_MEM_READ_WRITE, CL_BUFFER_CREATE_TYPE_REGION, &region);
}

}  // namespace clbvh::device
