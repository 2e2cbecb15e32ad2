#include "device/api/caller_tree.hpp"

#include "clbvh/core/bvh.hpp"

namespace clbvh::device {

CallerMemory examine_active_count(const Session& session, const DeviceSpan& span) {
    if (span.buffer == nullptr) return {};
    check_multiple("the active count's offset", span.offset, 0, sizeof(cl_uint));
    return examine(session, "the active count", span, sizeof(cl_uint));
}

CallerTree check_tree(const Session& session, const DeviceBvh& given, std::uint64_t alignment) {
    CallerTree checked;
    checked.nodes = examine(session, "the nodes", given.nodes, sizeof(Node) * std::uint64_t{given.node_count});
    check_views_allowed(checked.nodes, alignment);
    checked.active_count = examine_active_count(session, given.active_count);
    check_readable(checked.active_count);
    checked.tree.active_count = checked.active_count.given;
    checked.tree.nodes = view_of(checked.nodes.place, 0, checked.nodes.bytes);
    checked.tree.node_count = given.node_count;
    return checked;
}

}  // namespace clbvh::device
