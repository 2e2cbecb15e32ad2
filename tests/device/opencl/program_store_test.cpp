// Binaries in files: kept exactly, found only whole, never in the way. No device is needed here.
#include "device/opencl/program_store.hpp"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <csignal>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "io/temp_folder.hpp"

using namespace clbvh::test;
using clbvh::device::ProgramStore;
namespace fs = std::filesystem;

namespace {

const std::string kKey = "a device\nits driver\n-D OPTION=1\n";

/// Bytes of every value, the zero too.
std::string binary_of(std::size_t bytes, unsigned char first = 0) {
    std::string binary(bytes, '\0');
    for (std::size_t i = 0; i < bytes; ++i)
        binary[i] = static_cast<char>(first + i * 7);
    return binary;
}

std::size_t entries_in(const fs::path& folder) {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

/// Checks that nothing is found under kKey, and that storing mends it.
void expect_mended(const ProgramStore& store) {
    CHECK_FALSE(store.load(kKey).has_value());
    store.store(kKey, binary_of(100));
    CHECK(store.load(kKey) == binary_of(100));
}

/// No file of this process grows beyond a size, as on a full disk, as long as this lives.
class FileSizeLimit {
public:
    explicit FileSizeLimit(rlim_t bytes) : old_handler_(std::signal(SIGXFSZ, SIG_IGN)) {
        REQUIRE(getrlimit(RLIMIT_FSIZE, &old_) == 0);
        const rlimit limit{bytes, old_.rlim_max};
        REQUIRE(setrlimit(RLIMIT_FSIZE, &limit) == 0);
    }
    FileSizeLimit(const FileSizeLimit&) = delete;
    FileSizeLimit& operator=(const FileSizeLimit&) = delete;
    ~FileSizeLimit() {
        setrlimit(RLIMIT_FSIZE, &old_);
        std::signal(SIGXFSZ, old_handler_);
    }

private:
    void (*old_handler_)(int);
    rlimit old_{};
};

}  // namespace

TEST_CASE("program store: what was stored is found by its key alone, in this and the next process") {
    const TempFolder folder;
    const ProgramStore store(folder.path("cache"));
    CHECK_FALSE(store.load(kKey).has_value());
    store.store(kKey, binary_of(1000));
    store.store(kKey + "x", binary_of(10, 3));
    store.store("", "");
    for (const ProgramStore& reader : {store, ProgramStore(folder.path("cache"))}) {
        CHECK(reader.load(kKey) == binary_of(1000));
        CHECK(reader.load(kKey + "x") == binary_of(10, 3));
        CHECK(reader.load("") == "");
        CHECK_FALSE(reader.load(kKey + "y").has_value());
    }
    store.store(kKey, binary_of(20, 5));
    CHECK(store.load(kKey) == binary_of(20, 5));
    CHECK(entries_in(folder.path("cache")) == 3);
}

TEST_CASE("program store: the folder and its files are for their owner alone") {
    const TempFolder folder;
    const ProgramStore store(folder.path("deep/er/cache"));
    store.store(kKey, "x");
    CHECK((fs::status(folder.path("deep/er/cache")).permissions() & fs::perms::all) == fs::perms::owner_all);
    const fs::perms of_file = fs::status(store.path_of(kKey)).permissions() & fs::perms::all;
    CHECK(of_file == (fs::perms::owner_read | fs::perms::owner_write));
}

TEST_CASE("program store: a file with any bit flipped is not found") {
    const TempFolder folder;
    const ProgramStore store(folder.path("cache"));
    store.store(kKey, binary_of(50));
    const fs::path path = store.path_of(kKey);
    const std::string whole = content_of(path);
    std::size_t found = 0;
    for (std::size_t bit = 0; bit < 8 * whole.size(); ++bit) {
        std::string flipped = whole;
        flipped[bit / 8] = static_cast<char>(flipped[bit / 8] ^ (1 << bit % 8));
        std::ofstream(path, std::ios::binary) << flipped;
        found += store.load(kKey).has_value() ? 1 : 0;
    }
    CHECK(found == 0);
    expect_mended(store);
}

TEST_CASE("program store: a file that is cut short or too long is not found") {
    const TempFolder folder;
    const ProgramStore store(folder.path("cache"));
    store.store(kKey, binary_of(50));
    const fs::path path = store.path_of(kKey);
    const std::string whole = content_of(path);
    std::size_t found = 0;
    for (std::size_t length = 0; length < whole.size(); ++length) {
        std::ofstream(path, std::ios::binary) << whole.substr(0, length);
        found += store.load(kKey).has_value() ? 1 : 0;
    }
    std::ofstream(path, std::ios::binary) << whole << 'x';
    found += store.load(kKey).has_value() ? 1 : 0;
    CHECK(found == 0);
    expect_mended(store);
}

TEST_CASE("program store: the file of another key, other files, folders and pipes are not found") {
    const TempFolder folder;
    const ProgramStore store(folder.path("cache"));
    store.store("another key", binary_of(50));
    const fs::path path = store.path_of(kKey);
    fs::copy_file(store.path_of("another key"), path);
    expect_mended(store);
    std::ofstream(path) << "#!/bin/sh\n";
    expect_mended(store);
    fs::remove(path);
    REQUIRE(mkfifo(path.c_str(), 0600) == 0);
    expect_mended(store);
    fs::remove(path);
    fs::create_directory(path);
    CHECK_FALSE(store.load(kKey).has_value());
    store.store(kKey, "x");
    CHECK_FALSE(store.load(kKey).has_value());
    CHECK(entries_in(folder.path("cache")) == 2);
}

TEST_CASE("program store: a file of another user is not found") {
    if (geteuid() != 0) {
        WARN("SKIPPED: only root can give files away");
        return;
    }
    const TempFolder folder;
    const ProgramStore store(folder.path("cache"));
    store.store(kKey, binary_of(50));
    REQUIRE(chown(store.path_of(kKey).c_str(), 12345, 12345) == 0);
    expect_mended(store);
}

TEST_CASE("program store: where nothing can be written, nothing is kept and nothing fails") {
    const TempFolder folder;
    for (const fs::path& path : {fs::path(folder.write("file", "x")), fs::path("/dev/null/cache"), fs::path("/proc")}) {
        INFO(path);
        const ProgramStore store(path);
        store.store(kKey, binary_of(50));
        CHECK_FALSE(store.load(kKey).has_value());
    }
    CHECK(content_of(folder.path("file")) == "x");
}

TEST_CASE("program store: a folder that may not be written is read") {
    if (geteuid() == 0) {
        WARN("SKIPPED: root may write anywhere");
        return;
    }
    const TempFolder folder;
    const ProgramStore store(folder.path("cache"));
    store.store(kKey, binary_of(50));
    fs::permissions(folder.path("cache"), fs::perms::owner_read | fs::perms::owner_exec);
    store.store("another key", "x");
    CHECK(store.load(kKey) == binary_of(50));
    CHECK_FALSE(store.load("another key").has_value());
    fs::permissions(folder.path("cache"), fs::perms::owner_all);
}

TEST_CASE("program store: on a full disk nothing is left behind") {
    const TempFolder folder;
    const ProgramStore store(folder.path("cache"));
    store.store(kKey, binary_of(100));
    {
        const FileSizeLimit limit(1000);
        store.store("another key", binary_of(5000));
        store.store(kKey, binary_of(5000));
    }
    CHECK(store.load(kKey) == binary_of(100));
    CHECK_FALSE(store.load("another key").has_value());
    CHECK(entries_in(folder.path("cache")) == 1);
}

TEST_CASE("program store: the files used longest ago go first, and no file that is not its own") {
    const TempFolder folder;
    const ProgramStore store(folder.path("cache"), 3500);
    const auto stored_at = [&](const std::string& key, int hour) {
        store.store(key, binary_of(1000));
        fs::last_write_time(store.path_of(key), fs::file_time_type::clock::now() - std::chrono::hours(24 - hour));
    };
    stored_at("first", 1);
    stored_at("second", 2);
    stored_at("third", 3);
    for (const char* const name : {"notes.txt", "0123456789abcdef", "zz23456789abcdef.program"}) {
        std::ofstream(folder.path("cache") / name) << binary_of(4000);
        fs::last_write_time(folder.path("cache") / name, fs::file_time_type::min());
    }
    // Files that a killed process left behind.
    const fs::path left_behind = folder.path("cache") / "0123456789abcdef.program.AbCdEf";
    std::ofstream(left_behind) << binary_of(1000);
    fs::last_write_time(left_behind, fs::file_time_type::clock::now() - std::chrono::hours(48));
    CHECK(store.load("first").has_value());
    store.store("fourth", binary_of(1000));
    CHECK_FALSE(fs::exists(left_behind));
    CHECK_FALSE(store.load("second").has_value());
    for (const char* const key : {"first", "third", "fourth"})
        CHECK(store.load(key).has_value());
    CHECK(entries_in(folder.path("cache")) == 6);
    CHECK_FALSE(ProgramStore(folder.path("cache"), 1000).load("first").has_value());
}

TEST_CASE("program store: writers and readers of one file at the same time see whole files") {
    const TempFolder folder;
    std::vector<std::thread> threads;
    std::atomic<std::size_t> torn{0};
    for (unsigned char writer = 0; writer < 4; ++writer) {
        threads.emplace_back([&, writer] {
            const ProgramStore store(folder.path("cache"));
            for (int round = 0; round < 50; ++round) {
                store.store(kKey, binary_of(20000, writer));
                const std::optional<std::string> found = store.load(kKey);
                const bool whole = found && *found == binary_of(20000, static_cast<unsigned char>((*found)[0]));
                torn += whole ? 0 : 1;
            }
        });
    }
    for (std::thread& thread : threads)
        thread.join();
    CHECK(torn == 0);
    CHECK(entries_in(folder.path("cache")) == 1);
}
