#include "device/api/layout_book.hpp"

#include <algorithm>
#include <mutex>
#include <string>
#include <vector>

#include "clbvh/core/error.hpp"

namespace clbvh::device {
namespace {

/// Bytes of a buffer that is no sub-buffer. The handle is only compared: buffers that are gone do no harm, since what
/// comes to be under the same handle is written before it is traced.
struct Range {
    cl_mem buffer = nullptr;
    std::uint64_t begin = 0, end = 0;

    explicit Range(const CallerMemory& memory)
        : buffer(memory.place.buffer()), begin(memory.place.offset), end(memory.place.offset + memory.bytes) {}
    [[nodiscard]] bool meets(const Range& other) const noexcept {
        return buffer == other.buffer && begin < other.end && other.begin < end;
    }
    [[nodiscard]] bool operator==(const Range&) const = default;
};

struct TrueLayout {
    Range layout, nodes;
};

/// Never destroyed: memory may still be written while the program ends.
struct Book {
    std::mutex mutex;
    std::vector<TrueLayout> layouts;

    static Book& get() {
        static Book& book = *new Book;
        return book;
    }
};

}  // namespace

void note_written(const CallerMemory& memory) {
    if (!memory.is_there()) return;
    const Range written(memory);
    Book& book = Book::get();
    const std::lock_guard lock(book.mutex);
    std::erase_if(book.layouts,
                  [&](const TrueLayout& entry) { return written.meets(entry.layout) || written.meets(entry.nodes); });
}

void note_layout(const CallerMemory& layout, const CallerMemory& nodes) {
    note_written(layout);
    Book& book = Book::get();
    const std::lock_guard lock(book.mutex);
    book.layouts.push_back({Range(layout), Range(nodes)});
}

void check_layout_of(const CallerMemory& layout, const CallerMemory& nodes) {
    const Range layout_range(layout), nodes_range(nodes);
    Book& book = Book::get();
    const std::lock_guard lock(book.mutex);
    const bool is_true = std::ranges::any_of(book.layouts, [&](const TrueLayout& entry) {
        return entry.layout == layout_range && entry.nodes == nodes_range;
    });
    if (is_true) return;
    throw Error(ErrorCode::invalid_input,
                std::string(layout.name) +
                    " is no wide8 layout of this tree, or the tree was built, optimised or refitted since; enqueue the "
                    "layout again, or give it to DeviceRefitter");
}

}  // namespace clbvh::device
