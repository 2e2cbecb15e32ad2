#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace clbvh::device {

/// Binaries of programs in a folder, one file each, for the next process. A cache: nothing fails. What cannot be
/// written is not kept, and what is not exactly what was written is not found.
///
/// A file begins with a header that names its format, the lengths and a checksum of what follows: the key, whole, and
/// the binary. It is written under another name and renamed, so any number of processes may share the folder. Files of
/// other users are not read: a binary is code.
class ProgramStore {
public:
    /// Enough for some hundred programs of the largest kind seen (150 KB).
    static constexpr std::uint64_t kMostBytes = std::uint64_t{64} << 20;

    /// `folder` is made, for its owner alone, by the first store(). The files that were used longest ago go where all
    /// together exceed `most_bytes`.
    explicit ProgramStore(std::filesystem::path folder, std::uint64_t most_bytes = kMostBytes);

    /// The binary that was stored under `key`.
    [[nodiscard]] std::optional<std::string> load(std::string_view key) const noexcept;

    /// Keeps `binary`, in place of what `key` may have had.
    void store(std::string_view key, std::string_view binary) const noexcept;

    /// Where the binary of `key` is, or would be.
    [[nodiscard]] std::filesystem::path path_of(std::string_view key) const;

private:
    void make_folder() const;
    void drop_oldest() const;

    std::filesystem::path folder_;
    std::uint64_t most_bytes_;
};

}  // namespace clbvh::device
