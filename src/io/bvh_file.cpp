#include "clbvh/io/bvh_file.hpp"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "clbvh/core/error.hpp"
#include "clbvh/core/mesh.hpp"
#include "core/tree_walk.hpp"
#include "io/input_file.hpp"
#include "io/output_file.hpp"

namespace clbvh {
namespace {

static_assert(std::endian::native == std::endian::little, "BVH files are written as they lie in memory");

constexpr char kMagic[8] = {'C', 'L', 'B', 'V', 'H', '\0', '\0', '\1'};

/// Bits of FileHeader::flags.
constexpr std::uint32_t kSplitReferences = 1;

struct FileHeader {
    char magic[8];
    std::uint64_t node_count;
    std::uint64_t id_count;
    std::uint64_t primitive_count;
    std::uint32_t flags;
    std::uint32_t node_bytes;
    std::uint64_t reserved;
    std::uint64_t payload_hash;
    std::uint64_t zero;
};
static_assert(sizeof(FileHeader) == 64);

std::size_t node_bytes(const Bvh& bvh) {
    return bvh.nodes.size() * sizeof(Node);
}
std::size_t id_bytes(const Bvh& bvh) {
    return bvh.primitive_ids.size() * sizeof(std::uint32_t);
}

std::uint64_t hash_payload(const Bvh& bvh) {
    XXH64_state_t state;
    XXH64_reset(&state, 0);
    // xxHash takes no null pointers, which empty vectors may hold.
    if (!bvh.nodes.empty()) XXH64_update(&state, bvh.nodes.data(), node_bytes(bvh));
    if (!bvh.primitive_ids.empty()) XXH64_update(&state, bvh.primitive_ids.data(), id_bytes(bvh));
    return XXH64_digest(&state);
}

/// Reads one file and distrusts it: nothing is allocated before the file's size confirms it, and nothing is returned
/// that a traversal could leave or loop in.
class BvhReader {
public:
    explicit BvhReader(const std::filesystem::path& path) : path_(path), file_(path) {}

    Bvh read() {
        read_header();
        Bvh bvh;
        bvh.primitive_count = header_.primitive_count;
        bvh.split_references = (header_.flags & kSplitReferences) != 0;
        bvh.nodes.resize(header_.node_count);
        file_.read(bvh.nodes.data(), node_bytes(bvh));
        bvh.primitive_ids.resize(header_.id_count);
        file_.read(bvh.primitive_ids.data(), id_bytes(bvh));
        if (hash_payload(bvh) != header_.payload_hash) fail("the hash does not match: the file is damaged");
        check_ids(bvh);
        check_tree(bvh);
        return bvh;
    }

private:
    void read_header() {
        if (file_.size() < sizeof(FileHeader)) fail("too short for the header of a BVH file");
        file_.read(&header_, sizeof header_);
        if (std::memcmp(header_.magic, kMagic, sizeof kMagic - 1) != 0) fail("not a BVH file: the magic is missing");
        if (header_.magic[7] != kMagic[7]) {
            fail("version " + std::to_string(static_cast<unsigned char>(header_.magic[7])) +
                 " of the format; this library reads version 1");
        }
        if (header_.node_bytes != sizeof(Node))
            fail("nodes of " + std::to_string(header_.node_bytes) + " bytes, not 32");
        if ((header_.flags & ~kSplitReferences) != 0) fail("unknown flags " + std::to_string(header_.flags));
        if (header_.reserved != 0 || header_.zero != 0) fail("a reserved field of the header is not zero");
        check_sizes();
    }

    void check_sizes() const {
        const std::uint64_t payload = file_.size() - sizeof(FileHeader);
        const std::uint64_t nodes = header_.node_count;
        const std::uint64_t ids = header_.id_count;
        // The first two comparisons keep the sum from overflowing.
        if (nodes > payload / sizeof(Node) || ids > payload / sizeof(std::uint32_t) ||
            nodes * sizeof(Node) + ids * sizeof(std::uint32_t) != payload) {
            fail("the header promises " + std::to_string(nodes) + " nodes and " + std::to_string(ids) + " ids, but " +
                 std::to_string(payload) + " bytes follow it");
        }
        if (header_.primitive_count > kMaxPrimitives) {
            fail(std::to_string(header_.primitive_count) + " primitives, more than the limit of " +
                 std::to_string(kMaxPrimitives));
        }
    }

    void check_ids(const Bvh& bvh) const {
        for (std::size_t i = 0; i < bvh.primitive_ids.size(); ++i) {
            if (bvh.primitive_ids[i] < bvh.primitive_count) continue;
            fail("id " + std::to_string(i) + " names primitive " + std::to_string(bvh.primitive_ids[i]) + " of " +
                 std::to_string(bvh.primitive_count));
        }
    }

    /// No cycle remains, and no leaf leaves the ids.
    void check_tree(const Bvh& bvh) const {
        if (bvh.nodes.empty() && !bvh.primitive_ids.empty()) fail("ids without nodes");
        if (bvh.nodes.size() > 1 && bvh.nodes[1] != Node{}) fail("node 1 is not an unused zero");
        TreeWalk walk(bvh);
        while (walk.next()) {
        }
        if (walk.failed()) fail(walk.fault());
    }

    [[noreturn]] void fail(const std::string& what) const {
        throw Error(ErrorCode::io, "cannot read " + path_.string() + ": " + what);
    }

    std::filesystem::path path_;
    io::InputFile file_;
    FileHeader header_{};
};

}  // namespace

void write_bvh(const Bvh& bvh, const std::filesystem::path& path) {
    FileHeader header{};
    std::memcpy(header.magic, kMagic, sizeof kMagic);
    header.node_count = bvh.nodes.size();
    header.id_count = bvh.primitive_ids.size();
    header.primitive_count = bvh.primitive_count;
    header.flags = bvh.split_references ? kSplitReferences : 0;
    header.node_bytes = sizeof(Node);
    header.payload_hash = hash_payload(bvh);

    io::OutputFile file(path);
    file.write(&header, sizeof header);
    file.write(bvh.nodes.data(), node_bytes(bvh));
    file.write(bvh.primitive_ids.data(), id_bytes(bvh));
    file.commit();
}

Bvh read_bvh(const std::filesystem::path& path) {
    return BvhReader(path).read();
}

}  // namespace clbvh
