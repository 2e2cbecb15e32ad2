#include "clbvh/device/context.hpp"

#include "clbvh/core/error.hpp"
#include "device/opencl/hand_over_check.hpp"
#include "device/opencl/session.hpp"

namespace clbvh {

Context::Context(std::shared_ptr<device::Session> session) : session_(std::move(session)) {}

Context Context::open(std::string_view selector, const ContextOptions& options) {
    return Context(std::make_shared<device::Session>(pick_device(selector), options));
}

Context Context::adopt(cl_command_queue queue, const ContextOptions& options) {
    if (queue == nullptr) {
        throw Error(ErrorCode::invalid_input, "the queue to adopt is null");
    }
    return Context(std::make_shared<device::Session>(queue, options));
}

const DeviceInfo& Context::device() const noexcept {
    return session_->info();
}
cl_context Context::opencl_context() const noexcept {
    return session_->context()();
}
cl_command_queue Context::opencl_queue() const noexcept {
    return session_->queue()();
}
const FoundProfile& Context::profile() const noexcept {
    return session_->profile();
}
bool Context::prefers_lane_shape() const {
    return session_->prefers_lane_shape();
}
bool Context::passes_hand_over_check() const {
    return device::hand_over_passes_check(*session_);
}

}  // namespace clbvh
