// LBVH. Lauterbach, Garland, Sengupta, Luebke, Manocha 2009, "Fast BVH Construction on GPUs"; Karras 2012, "Maximizing
// Parallelism in the Construction of BVHs, Octrees, and k-d Trees"; Apetrei 2014, "Fast and Simple Agglomerative LBVH
// Construction".

#include <algorithm>

#include "device/build/device_algorithm.hpp"

namespace clbvh::device {
namespace {

constexpr std::uint32_t kPendingBytes = kernels::PENDING_BYTES;
constexpr std::uint32_t kMostPending = kernels::MOST_PENDING;
constexpr std::uint32_t kLeastPieceLength = 1024;

std::uint32_t most_pieces(const BuildSettings& settings) {
    return std::min(2 * settings.groups_to_fill, kMostPieces);
}

// Bytes for the subtrees that the lane shape's pieces leave to be joined, or for what the group shape's work items
// tell each other.
std::uint64_t extra_bytes(const BuildSettings& settings, std::uint32_t primitives) {
    return settings.lane() ? std::uint64_t{kPendingBytes} * kMostPending * most_pieces(settings)
                           : sizeof(std::uint32_t) * std::uint64_t{primitives};
}

ProgramSpec program(const BuildSettings& settings) {
    return {"lbvh.cl", settings.stream_group_size, ""};
}

void climb(const ClusterJob& job) {
    Launcher& launcher = job.launcher;
    const BuildBuffers& b = job.buffers;
    const std::size_t group_size = job.settings.stream_group_size;
    const std::size_t groups = (job.leaf_count + group_size - 1) / group_size;
    const auto kernel = [&](std::string_view name) -> Kernel& {
        return launcher.session().kernel(program(job.settings), name);
    };
    const cl::Buffer reached = view_of(b.extra, 0, extra_bytes(job.settings, job.leaf_count));
    launcher.launch(kernel("clear_nodes"), groups, b.leaf_count, reached, b.nodes);
    launcher.launch(kernel("climb_boxes"), groups, b.codes, b.primitive_ids, b.boxes, b.leaf_count, reached, b.nodes,
                    b.root_reference);
}

void build_pieces(const ClusterJob& job) {
    Launcher& launcher = job.launcher;
    Session& session = launcher.session();
    const BuildBuffers& b = job.buffers;
    const Pieces pieces = cut_into_pieces(job.leaf_count, most_pieces(job.settings), kLeastPieceLength);
    const cl::Buffer pending = view_of(b.extra, 0, extra_bytes(job.settings, job.leaf_count));
    launcher.launch(session.kernel(program(job.settings), "build_pieces"), pieces.count, b.codes, b.primitive_ids,
                    b.boxes, b.leaf_count, pieces.length, b.nodes, pending, b.counts);
    launcher.launch(session.kernel(program(job.settings), "join_pieces"), 1, pending, b.counts, pieces.count,
                    b.leaf_count, b.nodes, b.root_reference);
}

void cluster(const ClusterJob& job) {
    // A code, an id and a box are read, a sibling pair is written.
    job.launcher.count_bytes((8 + 4 + 24 + 64) * std::uint64_t{job.leaf_count});
    if (job.settings.lane()) {
        build_pieces(job);
    } else {
        climb(job);
    }
}

}  // namespace

extern const DeviceAlgorithm kLbvh{
    .cluster = cluster, .extra_bytes = extra_bytes, .box_order = BoxOrder::input, .program = program};

}  // namespace clbvh::device
