#include "clbvh/io/ray_file.hpp"

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "clbvh/eval/ray_sets.hpp"
#include "io/temp_folder.hpp"
#include "support/expect_error.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

std::vector<Ray> some_rays() {
    return random_lines({{0, 0, 0}, {1, 2, 3}}, 100, 1);
}

void expect_refused(const std::string& bytes, const std::string& reason) {
    const TempFolder folder;
    const std::string path = folder.write("rays", bytes);
    expect_error(ErrorCode::io, {path, reason}, [&] { (void)read_rays(path); });
}

}  // namespace

TEST_CASE("rays are read as they were written") {
    const TempFolder folder;
    for (const std::vector<Ray>& rays : {some_rays(), std::vector<Ray>{}}) {
        write_rays(rays, folder.path("rays"));
        CHECK(read_rays(folder.path("rays")) == rays);
        CHECK(content_of(folder.path("rays")).size() == 32 + 32 * rays.size());
    }
    CHECK(folder.entry_count() == 1);
}

TEST_CASE("the hash tells sets of rays apart") {
    std::vector<Ray> rays = some_rays();
    const std::uint64_t hash = hash_rays(rays);
    CHECK(hash_rays(some_rays()) == hash);
    rays[50].t_max = 1.0f;
    CHECK(hash_rays(rays) != hash);
    CHECK(hash_rays({}) == 0xef46db3751d8e999u);  // xxHash's of nothing
}

TEST_CASE("damaged ray files are refused") {
    const TempFolder folder;
    write_rays(some_rays(), folder.path("rays"));
    const std::string good = content_of(folder.path("rays"));
    const auto with = [&](std::size_t at, char byte) { return std::string(good).replace(at, 1, 1, byte); };
    expect_refused("", "too short");
    expect_refused(good.substr(0, 31), "too short");
    expect_refused(with(0, 'X'), "magic");
    expect_refused(with(7, '\2'), "version 2");
    expect_refused(with(8, '\1'), "promises 1 rays");
    expect_refused(with(15, '\x80'), "promises");
    expect_refused(with(16, '\x40'), "rays of 64 bytes");
    expect_refused(with(20, '\1'), "reserved");
    expect_refused(with(24, static_cast<char>(good[24] + 1)), "hash");
    expect_refused(with(1000, static_cast<char>(good[1000] + 1)), "hash");
    expect_refused(good + "x", "promises 100 rays");
    expect_refused(good.substr(0, good.size() - 32), "promises 100 rays");
    const std::filesystem::path missing = folder.path("missing/rays");
    expect_error(ErrorCode::io, {missing.string()}, [&] { (void)read_rays(missing); });
    expect_error(ErrorCode::io, {missing.string()}, [&] { write_rays({}, missing); });
}
