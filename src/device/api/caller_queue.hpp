#pragma once

#include <functional>
#include <span>
#include <string_view>

#include "clbvh/device/memory.hpp"
#include "device/opencl/launcher.hpp"

namespace clbvh::device {

/// Where and when a caller's work is enqueued.
struct CallerQueue {
    cl_command_queue queue;
    EventList wait_list;  ///< what it waits for
    cl_event* event;      ///< becomes the caller's own event of its end; may be null
};

/// Calls `launch` with a launcher on the caller's queue, behind the wait list, and hands over the event of the end.
/// `what` is what errors of OpenCL say of it. Throws Error(invalid_input) where the queue is not one of the session's
/// context and device, or an event is null, and what `launch` throws.
void enqueue_for_caller(std::string_view what, Session& session, const CallerQueue& on,
                        const std::function<void(Launcher&)>& launch);

}  // namespace clbvh::device
