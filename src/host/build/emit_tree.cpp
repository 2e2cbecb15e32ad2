#include "host/build/emit_tree.hpp"

#include <tbb/task_group.h>

#include <algorithm>
#include <array>
#include <vector>

#include "core/simd/prefetch.hpp"

namespace clbvh::host {
namespace {

/// The subtree of an inner node that stays one, to be written.
struct Job {
    const Node* root;
    std::uint32_t pair;  ///< Where its pairs begin in the result.
    std::uint32_t id;    ///< Where its primitive ids begin there.
};

class Emitter {
public:
    Emitter(const TreeSlots& slots, Bvh& result) : slots_(slots), result_(result) {}

    void run() {
        const Extent whole = extent_of(slots_.nodes[0], slots_.extents);
        result_.nodes.resize(2 * (std::size_t{whole.pairs} + 1));
        result_.primitive_ids.resize(whole.primitives);
        const Job root{&slots_.nodes[0], 1, 0};
        result_.nodes[0] = place(root, whole);
        result_.nodes[1] = Node{};
        if (whole.pairs > 0) tasks_.run_and_wait([&] { emit(root); });
    }

private:
    static constexpr std::uint32_t kParallelPairs = 4096;
    static constexpr std::size_t kBatch = 16;

    /// Takes up small subtrees before large ones, so that few wait at any time, whatever the tree.
    void emit(const Job& root) {
        std::vector<Job> waiting{root};
        while (!waiting.empty()) {
            const std::size_t count = std::min(waiting.size(), kBatch);
            std::array<Job, kBatch> batch;
            std::copy_n(waiting.end() - static_cast<std::ptrdiff_t>(count), count, batch.begin());
            waiting.resize(waiting.size() - count);
            for (std::size_t i = 0; i < count; ++i) {
                prefetch_pair(child_pair(slots_.nodes[batch[i].root->first]));
                prefetch_pair(child_pair(slots_.nodes[std::size_t{batch[i].root->first} + 1]));
            }
            for (std::size_t i = 0; i < count; ++i)
                emit_children(batch[i], waiting);
        }
    }

    void prefetch_pair(std::uint32_t pair) const noexcept {
        prefetch(&slots_.extents[pair]);
        prefetch(&slots_.nodes[2 * std::size_t{pair}]);
    }

    [[nodiscard]] static std::uint32_t child_pair(const Node& node) noexcept {
        return node.is_leaf() ? 0 : node.first / 2;
    }

    void emit_children(const Job& job, std::vector<Job>& waiting) {
        const Node& left = slots_.nodes[job.root->first];
        const Node& right = slots_.nodes[std::size_t{job.root->first} + 1];
        const Extent left_extent = extent_of(left, slots_.extents);
        const Extent right_extent = extent_of(right, slots_.extents);
        const Job left_job{&left, job.pair + 1, job.id};
        const Job right_job{&right, job.pair + 1 + left_extent.pairs, job.id + left_extent.primitives};
        result_.nodes[2 * std::size_t{job.pair}] = place(left_job, left_extent);
        result_.nodes[2 * std::size_t{job.pair} + 1] = place(right_job, right_extent);
        if (left_extent.pairs < right_extent.pairs) {
            wait(right_job, waiting);
            if (left_extent.pairs > 0) start(left_job, left_extent, waiting);
        } else if (left_extent.pairs > 0) {
            wait(left_job, waiting);
            if (right_extent.pairs > 0) start(right_job, right_extent, waiting);
        }
    }

    static void wait(const Job& job, std::vector<Job>& waiting) { waiting.push_back(job); }

    void start(const Job& job, const Extent& extent, std::vector<Job>& waiting) {
        if (extent.pairs < kParallelPairs) return wait(job, waiting);
        tasks_.run([this, job] { emit(job); });
    }

    /// The node itself, with the ids of a leaf.
    Node place(const Job& job, const Extent& extent) {
        Node node = *job.root;
        node.first = 2 * job.pair;
        if (extent.pairs > 0) return node;
        node.first = job.id;
        node.count = extent.primitives;
        std::uint32_t* const ids = result_.primitive_ids.data() + job.id;
        if (job.root->is_leaf() && slots_.next_ids.empty()) {
            std::copy_n(slots_.primitive_ids.data() + job.root->first, node.count, ids);
        } else {
            gather(*job.root, ids, ids);
        }
        return node;
    }

    /// Adds the ids below `root` to the ascending ones in begin .. end. Not deep: there are few.
    std::uint32_t* gather(const Node& root, std::uint32_t* begin, std::uint32_t* end) const {
        if (!root.is_leaf()) {
            end = gather(slots_.nodes[root.first], begin, end);
            return gather(slots_.nodes[std::size_t{root.first} + 1], begin, end);
        }
        std::uint32_t place = root.first;
        for (std::uint32_t i = 0; i < root.count; ++i) {
            end = insert(slots_.primitive_ids[place], begin, end);
            place = slots_.next_ids.empty() ? place + 1 : slots_.next_ids[place];
        }
        return end;
    }

    /// Adds `id` to the ascending ones in begin .. end, unless it is there.
    static std::uint32_t* insert(std::uint32_t id, const std::uint32_t* begin, std::uint32_t* end) noexcept {
        std::uint32_t* place = end;
        while (place != begin && place[-1] > id)
            --place;
        if (place != begin && place[-1] == id) return end;
        std::copy_backward(place, end, end + 1);
        *place = id;
        return end + 1;
    }

    const TreeSlots& slots_;
    Bvh& result_;
    tbb::task_group tasks_;
};

}  // namespace

void emit_tree(const TreeSlots& slots, Bvh& result) {
    Emitter(slots, result).run();
}

}  // namespace clbvh::host
