#include "clbvh/io/bvh_file.hpp"

#include <cstdint>
#include <string>

#include "core/tree_walk.hpp"
#include "io/binary_file.hpp"

namespace clbvh {
namespace {

constexpr io::BinaryFormat kTreeFormat = {{'C', 'L', 'B', 'V', 'H', '\0', '\0', '\1'}, "BVH file"};

struct TreeFileHeader {
    std::array<char, 8> magic;
    std::uint64_t node_count;
    std::uint64_t id_count;
    std::uint64_t primitive_count;
    std::uint32_t flags;
    std::uint32_t node_bytes;
    std::uint64_t reserved;
    std::uint64_t payload_hash;
    std::uint64_t zero;
};
static_assert(sizeof(TreeFileHeader) == 64);

std::uint64_t hash_payload(const Bvh& bvh) {
    return io::hash_bytes({io::bytes_of(bvh.nodes), io::bytes_of(bvh.primitive_ids)});
}

/// Nothing is allocated before the file's size confirms it, and nothing is returned that a traversal could leave or
/// loop in.
class TreeReader {
public:
    explicit TreeReader(const std::filesystem::path& path) : reader_(path, kTreeFormat) {}

    Bvh read() {
        const auto header = reader_.read_header<TreeFileHeader>();
        check_header(header);
        Bvh bvh;
        bvh.primitive_count = header.primitive_count;
        bvh.split_references = (header.flags & io::kSplitReferences) != 0;
        bvh.nodes.resize(header.node_count);
        reader_.read(bvh.nodes);
        bvh.primitive_ids.resize(header.id_count);
        reader_.read(bvh.primitive_ids);
        reader_.check_hash(header.payload_hash, hash_payload(bvh));
        check_ids(bvh);
        check_tree(bvh);
        return bvh;
    }

private:
    void check_header(const TreeFileHeader& header) const {
        const io::ArraySize nodes{header.node_count, sizeof(Node), "nodes"};
        const io::ArraySize ids{header.id_count, sizeof(std::uint32_t), "ids"};
        reader_.check_element(nodes, header.node_bytes);
        reader_.check_flags(header.flags);
        reader_.check_reserved(header.reserved | header.zero);
        reader_.check_arrays({nodes, ids});
        reader_.check_primitive_count(header.primitive_count);
    }

    void check_ids(const Bvh& bvh) const {
        for (std::size_t i = 0; i < bvh.primitive_ids.size(); ++i) {
            if (bvh.primitive_ids[i] < bvh.primitive_count) continue;
            reader_.fail("id " + std::to_string(i) + " names primitive " + std::to_string(bvh.primitive_ids[i]) +
                         " of " + std::to_string(bvh.primitive_count));
        }
    }

    /// No cycle remains, and no leaf leaves the ids.
    void check_tree(const Bvh& bvh) const {
        if (bvh.nodes.empty() && !bvh.primitive_ids.empty()) reader_.fail("ids without nodes");
        if (bvh.nodes.size() > 1 && bvh.nodes[1] != Node{}) reader_.fail("node 1 is not an unused zero");
        TreeWalk walk(bvh);
        while (walk.next()) {
        }
        if (walk.failed()) reader_.fail(walk.fault());
    }

    io::BinaryReader reader_;
};

}  // namespace

void write_bvh(const Bvh& bvh, const std::filesystem::path& path) {
    TreeFileHeader header{};
    header.magic = kTreeFormat.magic;
    header.node_count = bvh.nodes.size();
    header.id_count = bvh.primitive_ids.size();
    header.primitive_count = bvh.primitive_count;
    header.flags = bvh.split_references ? io::kSplitReferences : 0;
    header.node_bytes = sizeof(Node);
    header.payload_hash = hash_payload(bvh);
    io::write_parts(path,
                    {io::bytes_of(std::span(&header, 1)), io::bytes_of(bvh.nodes), io::bytes_of(bvh.primitive_ids)});
}

Bvh read_bvh(const std::filesystem::path& path) {
    return TreeReader(path).read();
}

}  // namespace clbvh
