#include "device/session.hpp"

#include "clbvh/core/error.hpp"
#include "device/device_info.hpp"
#include "device/kernel_source.hpp"
#include "device/lane_self_test.hpp"

namespace clbvh::device {

Session::Session(const DeviceInfo& info) : info_(info) {
    with_opencl_errors(info.name, [&] {
        device_ = cl::Device(static_cast<cl_device_id>(info.id), true);
        context_ = cl::Context(device_);
        queue_ = cl::CommandQueue(context_, device_, CL_QUEUE_PROFILING_ENABLE);
    });
}

Session::Session(cl_command_queue queue) {
    with_opencl_errors("adopting a queue", [&] {
        queue_ = cl::CommandQueue(queue, true);
        context_ = queue_.getInfo<CL_QUEUE_CONTEXT>();
        device_ = queue_.getInfo<CL_QUEUE_DEVICE>();
        const cl_command_queue_properties properties = queue_.getInfo<CL_QUEUE_PROPERTIES>();
        if ((properties & CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE) != 0) {
            throw Error(ErrorCode::unsupported,
                        "the queue is out of order; create it without CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE");
        }
        profiles_ = (properties & CL_QUEUE_PROFILING_ENABLE) != 0;
        info_ = describe_device(device_);
        for (const DeviceInfo& listed : list_devices()) {
            if (listed.id == info_.id) {
                info_.index = listed.index;
            }
        }
    });
}

cl::Program Session::build_program(const std::string& file, const std::string& options) const {
    cl::Program program(context_, kernel_source(file));
    try {
        program.build(device_, options.c_str());
    } catch (const cl::Error& error) {
        throw_opencl_error(error, "kernels/" + file + " with options '" + options + "' on " + info_.name + ":\n" +
                                      program.getBuildInfo<CL_PROGRAM_BUILD_LOG>(device_));
    }
    return program;
}

Kernel& Session::kernel(std::string_view file, std::string_view name, std::size_t work_group_size,
                        const std::string& options) {
    const std::string all_options = "-cl-std=CL1.2 -D WORK_GROUP_SIZE=" + std::to_string(work_group_size) + options;
    const std::string program_key = std::string(file) + " " + all_options;
    const std::string kernel_key = std::string(name) + " " + program_key;
    if (const auto known = kernels_.find(kernel_key); known != kernels_.end()) {
        return known->second;
    }
    return with_opencl_errors("kernel " + std::string(name) + " of kernels/" + std::string(file), [&]() -> Kernel& {
        auto program = programs_.find(program_key);
        if (program == programs_.end()) {
            program = programs_.emplace(program_key, build_program(std::string(file), all_options)).first;
        }
        Kernel kernel{cl::Kernel(program->second, std::string(name).c_str()), std::string(name), work_group_size};
        return kernels_.emplace(kernel_key, std::move(kernel)).first->second;
    });
}

bool Session::prefers_lane_shape() {
    if (info_.type != DeviceType::cpu) {
        return false;
    }
    if (!lane_shape_works_) {
        lane_shape_works_ = lane_shape_passes_self_test(*this);
    }
    return *lane_shape_works_;
}

}  // namespace clbvh::device
