#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <clbvh/core/vector.hpp>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "render/colour_map.hpp"
#include "render/heat_map.hpp"
#include "render/lighting.hpp"
#include "render/picture.hpp"
#include "render/sample_sequence.hpp"
#include "tools/scratch_folder.hpp"
#include "tools/tool_process.hpp"

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wall"
#pragma GCC diagnostic ignored "-Wextra"
#ifndef __clang_analyzer__  // what it says of other people's code is not for this project
#define STB_IMAGE_IMPLEMENTATION
#endif
#define STBI_ONLY_PNG
#include <stb/stb_image.h>
#pragma GCC diagnostic pop

using namespace clbvh;
using namespace clbvh::test;
using namespace clbvh::tool;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

namespace {

using Words = std::vector<std::string>;

/// A decoded PNG.
struct Image {
    int width = 0;
    int height = 0;
    std::vector<unsigned char> bytes;  // three a pixel

    [[nodiscard]] std::array<unsigned char, 3> at(int x, int y) const {
        const auto i = static_cast<std::size_t>(3 * (y * width + x));
        return {bytes[i], bytes[i + 1], bytes[i + 2]};
    }
};

Image decode(const std::string& png) {
    Image image;
    int channels = 0;
    const std::unique_ptr<unsigned char, decltype(&std::free)> pixels(
        stbi_load_from_memory(reinterpret_cast<const unsigned char*>(png.data()), static_cast<int>(png.size()),
                              &image.width, &image.height, &channels, 3),
        &std::free);
    REQUIRE(pixels);
    REQUIRE(channels == 3);
    image.bytes.assign(pixels.get(), pixels.get() + 3 * image.width * image.height);
    return image;
}

/// Runs `render` to a file of a folder of its own, and returns the file's content.
std::string png_of(const Words& arguments) {
    const ScratchFolder folder;
    Words words{"render", "--width", "48", "--height", "30", "-o", folder.path("picture.png")};
    words.insert(words.end(), arguments.begin(), arguments.end());
    if (std::ranges::find(arguments, "--spp") == arguments.end()) words.insert(words.end(), {"--spp", "2"});
    const Outcome outcome = run_tool(words);
    INFO(outcome.err);
    REQUIRE(outcome.exit_code == 0);
    CHECK(outcome.err.empty());
    CHECK_THAT(outcome.out, StartsWith(folder.path("picture.png") + ": 48 x 30, ") && Contains("--camera "));
    CHECK(folder.file_count() == 1);
    return read_text(folder.path("picture.png"));
}

void expect_failure(Words arguments, const Words& parts, int code = 1) {
    arguments.insert(arguments.begin(), "render");
    const Outcome outcome = run_tool(arguments);
    INFO(outcome.err);
    CHECK(outcome.exit_code == code);
    CHECK(outcome.out.empty());
    for (const std::string& part : parts)
        CHECK_THAT(outcome.err, Contains(part));
}

}  // namespace

TEST_CASE("every mode draws the object before a background") {
    for (const std::string mode : {"path", "ao", "normal", "heat-nodes", "heat-leaves"}) {
        INFO(mode);
        const std::string png = png_of({"gen:sphere:2000", "--mode", mode});
        const Image image = decode(png);
        CHECK(image.width == 48);
        CHECK(image.height == 30);
        CHECK(image.at(24, 14) != image.at(1, 1));
        CHECK(png_of({"gen:sphere:2000", "--mode", mode}) == png);
        CHECK(png_of({"gen:sphere:2000", "--mode", mode, "--threads", "1"}) == png);
    }
}

TEST_CASE("the picture does not depend on who traces") {
    for (const char* mode : {"path", "ao", "normal", "heat-nodes"}) {
        INFO(mode);
        CHECK(png_of({"gen:city:2000", "--mode", mode}) ==
              png_of({"gen:city:2000", "--mode", mode, "--tracer", "device"}));
    }
}

TEST_CASE("the picture does not depend on the tree, but the heat does") {
    CHECK(png_of({"gen:city:2000"}) == png_of({"gen:city:2000", "--builder", "median"}));
    CHECK(png_of({"gen:city:2000", "--mode", "heat-nodes"}) !=
          png_of({"gen:city:2000", "--mode", "heat-nodes", "--builder", "median"}));
}

TEST_CASE("the seed and the view change the picture") {
    const std::string plain = png_of({"gen:city:2000"});
    CHECK(png_of({"gen:city:2000", "--seed", "2"}) != plain);
    CHECK(png_of({"gen:city:2000", "--up", "-y"}) != plain);
    CHECK(png_of({"gen:city:2000", "--camera", "20,20,20,0,0,0,40"}) != plain);
}

TEST_CASE("what nothing is in shows the sky") {
    const Image image = decode(png_of({"gen:soup:0"}));
    CHECK(image.at(5, 5)[2] > 100);
    const Image away = decode(png_of({"gen:soup:100", "--camera", "9,9,9,10,10,10"}));
    CHECK(away.at(24, 15)[2] > 100);
}

TEST_CASE("render names what is wrong with its input") {
    const ScratchFolder folder;
    const std::string file = folder.path("picture.png");
    expect_failure({"gen:soup:10"}, {"--output"}, 2);
    expect_failure({"gen:soup:10", "-o", file, "--mode", "oil"}, {"--mode", "heat-leaves"}, 2);
    expect_failure({"gen:soup:10", "-o", file, "--width", "0"}, {"--width"}, 2);
    expect_failure({"gen:soup:10", "-o", file, "--spp", "0"}, {"--spp"}, 2);
    expect_failure({"gen:soup:10", "-o", file, "--heat-max", "0.5"}, {"--heat-max"}, 2);
    expect_failure({"gen:soup:10", "-o", file, "--width", "16000", "--height", "16000"}, {"--width, --height"});
    expect_failure({"gen:soup:10", "-o", file, "--width", "16384", "--height", "1"}, {"--width, --height", "narrow"});
    expect_failure({"gen:soup:10", "-o", file, "--heat-max", "nan"}, {"--heat-max"});
    expect_failure(
        {"gen:soup:10", "-o", file, "--mode", "heat-nodes", "--builder", "host", "--width", "8192", "--height", "8192"},
        {"--width, --height", "side by side"});
    expect_failure({"gen:soup:10", "-o", file, "--camera", "1,1,1,1,1,1"}, {"--camera", "target is at its eye"});
    expect_failure({"gen:soup:10", "-o", file, "--builder", "plocpq"}, {"plocpq", "plocpp"});
    expect_failure({"gen:soup:10", "-o", file, "--tracer", "device", "--mode", "heat-leaves"}, {"--tracer"});
    expect_failure({missing_path("scene.obj"), "-o", folder.path("none/picture.png")}, {missing_path("scene.obj")});
    expect_failure({"gen:soup:10", "-o", folder.path("none/picture.png")}, {"none/picture.png"});
    CHECK(folder.file_count() == 0);
}

TEST_CASE("a picture that is interrupted leaves no file") {
    const ScratchFolder folder;
    ToolProcess process({"render", "gen:city:100000", "--spp", "65536", "-o", folder.path("picture.png")});
    process.interrupt();
    const Outcome outcome = process.wait();
    CHECK(outcome.exit_code == 130);
    CHECK(outcome.err == "clbvh: cancelled\n");
    CHECK(folder.file_count() == 0);
}

TEST_CASE("heat maps have their scale at the lower edge") {
    constexpr std::uint32_t width = 320;
    constexpr std::uint32_t height = 200;
    const std::vector<float> values(width * height, 5.0f);
    Picture picture = heat_map(values, width, height, 10.0f);
    const auto close = [](const Vec3& a, const Vec3& b) { return length(a - b) < 1e-3f; };
    CHECK(close(picture.at(10, 10), heat_colour(0.5f)));
    std::size_t changes = 0;
    for (std::uint32_t x = 20; x + 20 < width; ++x)
        changes += close(picture.at(x, height - 6), picture.at(x + 1, height - 6)) ? 0U : 1U;
    CHECK(changes > 200);
    CHECK(decode(png_bytes(heat_map({1.0f}, 1, 1, 1.0f))).width == 1);
}

TEST_CASE("a few hot pixels do not spoil a heat map's scale") {
    std::vector<float> values(1000, 7.5f);
    values[7] = 1000.0f;
    CHECK(fitting_scale_end(values) == 8.0f);
    CHECK(fitting_scale_end({0.1f}) == 1.0f);
    CHECK(fitting_scale_end({}) == 1.0f);
}

TEST_CASE("heat maps of several builders stand side by side, to the same scale") {
    const Words both{"gen:city:2000", "--mode", "heat-leaves", "--heat-max", "20", "--builder"};
    const auto image_of = [&](const std::string& builders) {
        const ScratchFolder folder;
        Words words{"render", "--width", "48", "--height", "30", "-o", folder.path("picture.png")};
        words.insert(words.end(), both.begin(), both.end());
        words.push_back(builders);
        REQUIRE(run_tool(words).exit_code == 0);
        return decode(read_text(folder.path("picture.png")));
    };
    const Image pair = image_of("median,binned-sah");
    const Image left = image_of("median");
    const Image right = image_of("binned-sah");
    REQUIRE(pair.width == 48 + 4 + 48);
    for (int x = 0; x < 48; ++x) {
        CHECK(pair.at(x, 15) == left.at(x, 15));
        CHECK(pair.at(52 + x, 15) == right.at(x, 15));
    }
    expect_failure({"gen:soup:10", "-o", "none.png", "--builder", "median,sbvh"}, {"--builder", "path"});
}

TEST_CASE("less noise is left where it is smoothed, and the picture is as bright") {
    const auto roughness_and_mean = [](const std::string& png) {
        const Image image = decode(png);
        double rough = 0.0;
        double sum = 0.0;
        for (int y = 0; y < image.height; ++y) {
            for (int x = 1; x < image.width; ++x) {
                rough += std::abs(image.at(x, y)[1] - image.at(x - 1, y)[1]);
                sum += image.at(x, y)[1];
            }
        }
        return std::pair(rough, sum);
    };
    const Words words{"gen:terrain:2000", "--spp", "4"};
    const auto [rough, mean] = roughness_and_mean(png_of({"gen:terrain:2000", "--spp", "4", "--no-denoise"}));
    const auto [smooth, same_mean] = roughness_and_mean(png_of(words));
    CHECK(smooth < 0.8 * rough);
    CHECK(same_mean == Approx(mean).epsilon(0.02));
}

TEST_CASE("colours of heat become lighter all the way") {
    float before = -1.0f;
    for (int i = 0; i <= 100; ++i) {
        const float lightness = dot(heat_colour(static_cast<float>(i) / 100.0f), {0.2126f, 0.7152f, 0.0722f});
        CHECK(lightness > before);
        before = lightness;
    }
    CHECK(heat_colour(-1.0f) == heat_colour(0.0f));
    CHECK(heat_colour(7.0f) == heat_colour(1.0f));
}

TEST_CASE("tone mapping keeps the order of light") {
    float before = -1.0f;
    for (float light = 0.0f; light < 100.0f; light = 1.3f * light + 0.01f) {
        const float shown = tone_mapped({light, light, light}, 0.7f).x;
        CHECK(shown >= before);
        CHECK(shown >= 0.0f);
        CHECK(shown <= 1.0f);
        before = shown;
    }
}

TEST_CASE("the samples of a pixel cover both dimensions evenly") {
    constexpr std::uint32_t samples = 64;
    std::array<int, 8> columns{};
    std::array<int, 8> rows{};
    for (std::uint32_t i = 0; i < samples; ++i) {
        const auto [x, y] = SampleSequence(3, 17, i).next();
        ++columns.at(static_cast<std::size_t>(x * 8.0f));
        ++rows.at(static_cast<std::size_t>(y * 8.0f));
    }
    // Independent numbers would stray from 8 by some 2.6.
    CHECK(std::ranges::all_of(columns, [](int count) { return std::abs(count - 8) <= 2; }));
    CHECK(std::ranges::all_of(rows, [](int count) { return std::abs(count - 8) <= 2; }));
    for (std::uint32_t i = 0; i < samples; ++i) {
        const auto [x, y] = SampleSequence(3, 17, i).next_in_disc();
        CHECK(x * x + y * y <= 1.0f);
    }
}
