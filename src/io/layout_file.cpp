#include "clbvh/io/layout_file.hpp"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "io/binary_file.hpp"

namespace clbvh {
namespace {

constexpr io::BinaryFormat kLayoutFormat = {{'C', 'L', 'B', 'V', 'H', 'L', '\0', '\1'}, "layout file"};

struct LayoutFileHeader {
    std::array<char, 8> magic;
    LayoutKind kind;
    std::uint32_t node_bytes;
    std::uint32_t element_bytes;
    std::uint32_t depth;
    std::uint64_t node_count;
    std::uint64_t element_count;
    std::uint64_t primitive_count;
    std::uint32_t flags;
    std::uint32_t zero;
    std::uint64_t hash;
};
static_assert(sizeof(LayoutFileHeader) == 64 && offsetof(LayoutFileHeader, hash) == 56);

/// How a kind of layouts lies in a file.
struct KindRow {
    LayoutKind kind;
    std::uint32_t node_bytes;
    std::uint32_t element_bytes;
    std::string_view elements;
};
constexpr std::array kKinds = {
    KindRow{LayoutKind::wide8, sizeof(WideNode<8>), sizeof(TriangleBlock), "blocks"},
    KindRow{LayoutKind::wide4, sizeof(WideNode<4>), sizeof(TriangleBlock), "blocks"},
    KindRow{LayoutKind::compressed8, sizeof(Compressed8Node), sizeof(Compressed8Triangle), "triangles"},
    KindRow{LayoutKind::pair, sizeof(PairNode), sizeof(std::uint32_t), "ids"},
    KindRow{LayoutKind::skip, sizeof(SkipNode), sizeof(std::uint32_t), "ids"},
};

/// What a layout holds beside its nodes.
template <typename Layout>
auto& elements_of(Layout& layout) {
    if constexpr (requires { layout.blocks; }) {
        return layout.blocks;
    } else if constexpr (requires { layout.triangles; }) {
        return layout.triangles;
    } else {
        return layout.primitive_ids;
    }
}

template <typename Layout>
std::uint64_t hash_of(const LayoutFileHeader& header, const Layout& layout) {
    const io::Bytes before_hash = io::bytes_of(std::span(&header, 1)).first(offsetof(LayoutFileHeader, hash));
    return io::hash_bytes({before_hash, io::bytes_of(layout.nodes), io::bytes_of(elements_of(layout))});
}

template <typename Layout>
void write(const Layout& layout, LayoutKind kind, const std::filesystem::path& path) {
    const auto& elements = elements_of(layout);
    LayoutFileHeader header{};
    header.magic = kLayoutFormat.magic;
    header.kind = kind;
    header.node_bytes = sizeof layout.nodes[0];
    header.element_bytes = sizeof elements[0];
    header.depth = layout.depth;
    header.node_count = layout.nodes.size();
    header.element_count = elements.size();
    header.primitive_count = layout.primitive_count;
    header.flags = layout.split_references ? io::kSplitReferences : 0;
    header.hash = hash_of(header, layout);
    io::write_parts(path, {io::bytes_of(std::span(&header, 1)), io::bytes_of(layout.nodes), io::bytes_of(elements)});
}

LayoutFileHeader read_header(io::BinaryReader& reader) {
    const auto header = reader.read_header<LayoutFileHeader>();
    const auto* const row = std::ranges::find(kKinds, header.kind, &KindRow::kind);
    if (row == kKinds.end()) {
        reader.fail("layouts of kind " + std::to_string(static_cast<std::uint32_t>(header.kind)) +
                    ", which this library does not know");
    }
    const io::ArraySize nodes{header.node_count, row->node_bytes, "nodes"};
    const io::ArraySize elements{header.element_count, row->element_bytes, row->elements};
    reader.check_element(nodes, header.node_bytes);
    reader.check_element(elements, header.element_bytes);
    reader.check_flags(header.flags);
    reader.check_reserved(header.zero);
    reader.check_arrays({nodes, elements});
    reader.check_primitive_count(header.primitive_count);
    if (header.depth > header.node_count) {
        reader.fail("a depth of " + std::to_string(header.depth) + ", above its " + std::to_string(header.node_count) +
                    " nodes");
    }
    return header;
}

template <typename Layout>
void read(const std::filesystem::path& path, LayoutKind kind, Layout& result) {
    io::BinaryReader reader(path, kLayoutFormat);
    const LayoutFileHeader header = read_header(reader);
    if (header.kind != kind) {
        reader.fail("it holds a layout of kind " + std::string(to_string(header.kind)) + ", not " +
                    std::string(to_string(kind)));
    }
    Layout layout;
    layout.nodes.resize_for_overwrite(header.node_count);
    reader.read(layout.nodes);
    elements_of(layout).resize_for_overwrite(header.element_count);
    reader.read(elements_of(layout));
    layout.depth = header.depth;
    layout.primitive_count = header.primitive_count;
    layout.split_references = (header.flags & io::kSplitReferences) != 0;
    reader.check_hash(header.hash, hash_of(header, layout));
    result = std::move(layout);
}

}  // namespace

void write_layout(const Wide8& layout, const std::filesystem::path& path) {
    write(layout, LayoutKind::wide8, path);
}
void write_layout(const Wide4& layout, const std::filesystem::path& path) {
    write(layout, LayoutKind::wide4, path);
}
void write_layout(const Compressed8& layout, const std::filesystem::path& path) {
    write(layout, LayoutKind::compressed8, path);
}
void write_layout(const PairLayout& layout, const std::filesystem::path& path) {
    write(layout, LayoutKind::pair, path);
}
void write_layout(const SkipLayout& layout, const std::filesystem::path& path) {
    write(layout, LayoutKind::skip, path);
}

LayoutFileInfo read_layout_info(const std::filesystem::path& path) {
    io::BinaryReader reader(path, kLayoutFormat);
    const LayoutFileHeader header = read_header(reader);
    return {header.kind,          header.node_count,
            header.element_count, header.primitive_count,
            header.depth,         (header.flags & io::kSplitReferences) != 0,
            reader.file_bytes()};
}

bool is_layout_file(const std::filesystem::path& path) {
    io::InputFile file(path);
    std::array<char, 7> magic{};
    if (file.size() < magic.size()) return false;
    file.read(magic.data(), magic.size());
    return std::equal(magic.begin(), magic.end(), kLayoutFormat.magic.begin());
}

void read_layout(const std::filesystem::path& path, Wide8& result) {
    read(path, LayoutKind::wide8, result);
}
void read_layout(const std::filesystem::path& path, Wide4& result) {
    read(path, LayoutKind::wide4, result);
}
void read_layout(const std::filesystem::path& path, Compressed8& result) {
    read(path, LayoutKind::compressed8, result);
}
void read_layout(const std::filesystem::path& path, PairLayout& result) {
    read(path, LayoutKind::pair, result);
}
void read_layout(const std::filesystem::path& path, SkipLayout& result) {
    read(path, LayoutKind::skip, result);
}

}  // namespace clbvh
