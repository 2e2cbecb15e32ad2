#include "device/opencl/program_store.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <system_error>
#include <utility>
#include <vector>

#include "core/fnv1a.hpp"

namespace clbvh::device {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kSuffix = ".program";
constexpr std::size_t kHashDigits = 16;
constexpr std::array<char, 8> kMagic{'c', 'l', 'b', 'v', 'h', 'p', 'r', 'g'};
constexpr std::uint32_t kFormat = 1;

struct Header {
    std::array<char, 8> magic = kMagic;
    std::uint32_t format = kFormat;
    std::uint32_t key_bytes = 0;
    std::uint64_t binary_bytes = 0;
    std::uint64_t checksum = 0;  ///< fnv1a of the key and the binary
};
static_assert(sizeof(Header) == 32);

/// Header of a binary's file.
std::string prefix_of(std::string_view key, std::string_view binary) {
    Header header;
    header.key_bytes = static_cast<std::uint32_t>(key.size());
    header.binary_bytes = binary.size();
    header.checksum = fnv1a(binary, fnv1a(key));
    std::string prefix(sizeof(Header), '\0');
    std::memcpy(prefix.data(), &header, sizeof(Header));
    return prefix.append(key);
}

/// An open file, closed at the end; closing may fail, which only close() reports.
class File {
public:
    explicit File(int descriptor) : descriptor_(descriptor) {}
    File(const File&) = delete;
    File& operator=(const File&) = delete;
    ~File() { close(); }

    [[nodiscard]] bool is_open() const noexcept { return descriptor_ >= 0; }
    [[nodiscard]] int descriptor() const noexcept { return descriptor_; }

    /// False where the file ends before, or cannot be read.
    [[nodiscard]] bool read(void* to, std::size_t bytes) const {
        auto* out = static_cast<char*>(to);
        while (bytes > 0) {
            const ssize_t got = ::read(descriptor_, out, bytes);
            if (got <= 0) return false;
            out += got;
            bytes -= static_cast<std::size_t>(got);
        }
        return true;
    }
    [[nodiscard]] bool write(const void* from, std::size_t bytes) const {
        const auto* in = static_cast<const char*>(from);
        while (bytes > 0) {
            const ssize_t put = ::write(descriptor_, in, bytes);
            if (put <= 0) return false;
            in += put;
            bytes -= static_cast<std::size_t>(put);
        }
        return true;
    }
    bool close() { return descriptor_ < 0 || ::close(std::exchange(descriptor_, -1)) == 0; }

private:
    int descriptor_;
};

/// The length of a regular file of this user; of anything else, nothing.
std::optional<std::uint64_t> own_length(const File& file) {
    struct stat status {};
    if (::fstat(file.descriptor(), &status) != 0 || !S_ISREG(status.st_mode) || status.st_uid != ::geteuid()) {
        return std::nullopt;
    }
    return static_cast<std::uint64_t>(status.st_size);
}

/// All of a file but what has to stand before the binary of `key`.
std::optional<std::string> read_binary(const File& file, std::uint64_t length, std::string_view key) {
    const std::size_t prefix_bytes = sizeof(Header) + key.size();
    if (length < prefix_bytes) return std::nullopt;
    std::string content(length, '\0');
    if (!file.read(content.data(), content.size())) return std::nullopt;
    const std::string binary = content.substr(prefix_bytes);
    if (!content.starts_with(prefix_of(key, binary))) return std::nullopt;
    return binary;
}

/// Files that this class made, finished or left behind by a process that was killed: 16 digits and the suffix first.
bool is_ours(const fs::path& path) {
    const std::string name = path.filename().string();
    return name.size() >= kHashDigits + kSuffix.size() && name.find_first_not_of("0123456789abcdef") == kHashDigits &&
           name.compare(kHashDigits, kSuffix.size(), kSuffix) == 0;
}

struct StoredFile {
    fs::path path;
    std::uint64_t bytes;
    fs::file_time_type used;
};

std::vector<StoredFile> files_in(const fs::path& folder) {
    std::vector<StoredFile> files;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
        std::error_code gone;  // another process may drop files too
        if (!is_ours(entry.path()) || !entry.is_regular_file(gone)) continue;
        const StoredFile file{entry.path(), entry.file_size(gone), entry.last_write_time(gone)};
        if (!gone) files.push_back(file);
    }
    return files;
}

/// Where a file is written before it gets its name; removed unless it does.
class Temporary {
public:
    explicit Temporary(const fs::path& target)
        : name_(target.string() + ".XXXXXX"), file_(::mkostemp(name_.data(), O_CLOEXEC)) {}
    Temporary(const Temporary&) = delete;
    Temporary& operator=(const Temporary&) = delete;
    ~Temporary() {
        if (file_.is_open()) ::unlink(name_.c_str());
    }

    [[nodiscard]] bool write(std::string_view bytes) const {
        return file_.is_open() && file_.write(bytes.data(), bytes.size());
    }
    void rename_to(const fs::path& target) {
        // A full disk may say so only here.
        const bool closed = file_.close();
        if (!closed || std::rename(name_.c_str(), target.c_str()) != 0) ::unlink(name_.c_str());
    }

private:
    std::string name_;
    File file_;
};

}  // namespace

ProgramStore::ProgramStore(fs::path folder, std::uint64_t most_bytes)
    : folder_(std::move(folder)), most_bytes_(most_bytes) {}

fs::path ProgramStore::path_of(std::string_view key) const {
    return folder_ / (hexadecimal(fnv1a(key)) + std::string(kSuffix));
}

std::optional<std::string> ProgramStore::load(std::string_view key) const noexcept {
    try {
        // Without O_NONBLOCK a pipe of that name would make this wait for a writer.
        const File file(::open(path_of(key).c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
        if (!file.is_open()) return std::nullopt;
        const std::optional<std::uint64_t> length = own_length(file);
        if (!length || *length > most_bytes_) return std::nullopt;
        std::optional<std::string> binary = read_binary(file, *length, key);
        if (binary) ::futimens(file.descriptor(), nullptr);  // used now
        return binary;
    } catch (const std::exception&) {
        return std::nullopt;
    }
}

void ProgramStore::store(std::string_view key, std::string_view binary) const noexcept {
    try {
        make_folder();
        const fs::path target = path_of(key);
        Temporary temporary(target);
        if (temporary.write(prefix_of(key, binary)) && temporary.write(binary)) {
            temporary.rename_to(target);
            drop_oldest();
        }
    } catch (const std::exception&) {
        return;  // then it is built from source again
    }
}

void ProgramStore::make_folder() const {
    std::error_code ignored;
    fs::create_directories(folder_.parent_path(), ignored);
    ::mkdir(folder_.c_str(), S_IRWXU);
}

void ProgramStore::drop_oldest() const {
    std::vector<StoredFile> files = files_in(folder_);
    std::uint64_t bytes = 0;
    for (const StoredFile& file : files)
        bytes += file.bytes;
    std::ranges::sort(files, {}, &StoredFile::used);
    for (auto oldest = files.begin(); bytes > most_bytes_ && oldest != files.end(); ++oldest) {
        std::error_code ignored;
        fs::remove(oldest->path, ignored);
        bytes -= oldest->bytes;
    }
}

}  // namespace clbvh::device
