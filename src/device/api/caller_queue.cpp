#include "device/api/caller_queue.hpp"

#include <vector>

#include "clbvh/core/error.hpp"

namespace clbvh::device {
namespace {

void check_queue(const Session& session, cl_command_queue queue) {
    if (queue == nullptr) throw Error(ErrorCode::invalid_input, "the queue is null");
    const cl::CommandQueue given(queue, true);
    if (given.getInfo<CL_QUEUE_CONTEXT>()() != session.context()()) {
        throw Error(ErrorCode::invalid_input, "the queue belongs to another OpenCL context than the kernels");
    }
    if (given.getInfo<CL_QUEUE_DEVICE>()() != session.info().id) {
        throw Error(ErrorCode::invalid_input,
                    "the queue is not one of the device that the kernels are for, " + session.info().name);
    }
}

std::vector<cl::Event> copy_events(const EventList& list) {
    std::vector<cl::Event> copies;
    for (cl_event event : list.events()) {
        if (event == nullptr) throw Error(ErrorCode::invalid_input, "the wait list has a null event");
        copies.emplace_back(event, true);
    }
    return copies;
}

}  // namespace

void enqueue_for_caller(std::string_view what, Session& session, const CallerQueue& on,
                        const std::function<void(Launcher&)>& launch) {
    with_opencl_errors(what, [&] {
        check_queue(session, on.queue);
        Launcher launcher(session, cl::CommandQueue(on.queue, true), copy_events(on.wait_list));
        launch(launcher);
        launcher.hand_over_end(on.event);
    });
}

}  // namespace clbvh::device
