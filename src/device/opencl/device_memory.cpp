#include "device/opencl/device_memory.hpp"

#include <cstdlib>

#include "core/huge_pages.hpp"

namespace clbvh::device {
namespace {

void CL_CALLBACK free_host_memory(cl_mem, void* memory) {
    std::free(memory);
}

cl::Buffer wrap_huge_pages(const Session& session, std::uint64_t bytes) {
    HugePageMemory memory = allocate_in_huge_pages(bytes);
    cl::Buffer buffer(session.context(), CL_MEM_READ_WRITE | CL_MEM_USE_HOST_PTR, bytes, memory.get());
    buffer.setDestructorCallback(free_host_memory, memory.get());
    static_cast<void>(memory.release());  // the callback owns it now
    return buffer;
}

}  // namespace

cl::Buffer allocate_buffer(const Session& session, std::uint64_t bytes) {
    if (session.info().type == DeviceType::cpu && bytes >= kHugePage) {
        return wrap_huge_pages(session, bytes);
    }
    return {session.context(), CL_MEM_READ_WRITE, bytes};
}

const cl::Buffer& KeptBuffer::reserve(const Session& session, std::uint64_t bytes) {
    if (bytes > bytes_) {
        release();  // old and new are never alive together
        buffer_ = allocate_buffer(session, bytes);
        bytes_ = bytes;
    }
    return buffer_;
}

}  // namespace clbvh::device
