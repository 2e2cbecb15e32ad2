// The table of options: its defaults are those of the Configs, what it takes is taken by every way in, and what it
// refuses is refused with the option's name.
#include "clbvh/options.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <functional>
#include <limits>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "clbvh/catalog.hpp"
#include "clbvh/core/error.hpp"
#include "support/expect_error.hpp"

using namespace clbvh;
using clbvh::test::expect_error;

namespace {

using Values = std::vector<std::string>;
using Change = std::function<void(BuildOptions&)>;

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/// What an option takes and refuses at the ends of its range, as its documentation has it.
struct Limits {
    Values taken;
    Values refused;
    std::string range;  ///< What an error says.
};

const std::map<std::string, Limits, std::less<>>& limits() {
    const Limits bins{{"2", "64"}, {"0", "1", "65"}, "2 to 64"};
    const Limits cost{{"1e-30", "3.5"}, {"0", "-1", "inf", "nan"}, "finite and above 0"};
    const Limits shape{{"auto", "group", "lane"}, {"Group", "group ", "automatic"}, "auto, group or lane"};
    static const std::map<std::string, Limits, std::less<>> table{
        {"optimizers", {{"", "reinsert", "rotate,reinsert"}, {"reinzert", "rotate,", ","}, "known are: reinsert"}},
        {"optimize_passes", {{"0", "1", "4294967295"}, {"-1", "4294967296"}, "0 or more"}},
        {"optimize_on", {{"host", "device"}, {"gpu"}, "host or device"}},
        {"max_leaf_size", {{"0", "1", "64"}, {"65"}, "0 to 64"}},
        {"ray_cost", {{"on", "off"}, {"true", "1"}, "on or off"}},
        {"opening", {{"largest-first", "least-cost"}, {"first"}, "largest-first or least-cost"}},
        {"presplit_level", {{"0", "1", "40"}, {"41"}, "0 to 40"}},
        {"split_quota", {{"0", "0.001", "4"}, {"-0.1", "4.1", "nan"}, "0 to 4"}},
        {"inner_cost", cost},
        {"primitive_cost", cost},
        {"thread_count", {{"0", "1", "1024"}, {"1025"}, "0 to 1024"}},
        {"binned_sah.bin_count", bins},
        {"binned_sah.longest_axis_only", {{"on", "off"}, {"true", "1"}, "on or off"}},
        {"sbvh.bin_count", bins},
        {"sbvh.spatial_bin_count", bins},
        {"sbvh.alpha", {{"0", "1"}, {"-0.5", "1.5", "nan"}, "0 to 1"}},
        {"sbvh.overlap", {{"0", "1"}, {"-0.5", "1.5", "nan"}, "0 to 1"}},
        {"sbvh.reference_budget", {{"1", "8"}, {"0.5", "8.5", "inf", "nan"}, "1 to 8"}},
        {"device.shape", shape},
        {"device.sort_shape", shape},
        {"device.morton_code", {{"cubic", "xyz", "extended"}, {"zyx"}, "cubic, xyz or extended"}},
        {"device.code_bits", {{"33", "44", "63"}, {"0", "1", "32", "43", "64"}, "33, 44 or 63"}},
        {"ploc.search_radius", {{"1", "2", "31", "32"}, {"0", "33", "4294967295"}, "1 to 32"}},
        {"ploc.neighbour_encoding", {{"bits32", "bits64"}, {"bits", "64", "auto"}, "bits32 or bits64"}},
        {"ploc.neighbour_search", {{"auto", "symmetric", "scan"}, {"far"}, "auto, symmetric or scan"}},
        {"ploc.chunk_size",
         {{"0", "64", "128", "192", "4096"},
          {"1", "63", "65", "4095", "4160"},
          "64 to 4096 in steps of 64, or 0 to have it chosen"}},
        {"ploc.work_group_size",
         {{"0", "32", "64", "1024"},
          {"1", "16", "48", "1023", "2048"},
          "a power of two from 32 to 1024, or 0 to have it chosen"}},
        {"ploc.single_group_threshold",
         {{"0", "2", "1048576"}, {"1", "1048577"}, "2 to 1048576, or 0 to have it chosen"}},
        {"ploc.range_count", {{"0", "1", "512"}, {"513", "4294967295"}, "1 to 512, or 0 to have it chosen"}},
        {"hploc.search_radius", {{"0", "1", "31"}, {"32"}, "0 to 31"}},
        {"hploc.cluster_limit", {{"8", "16"}, {"0", "1", "7", "9", "15", "17", "32"}, "8 or 16"}},
        {"hploc.small_range", {{"1", "2", "1073741824"}, {"0", "1073741825"}, "1 to 1073741824"}},
        {"hploc.small_limit", {{"1", "8"}, {"0", "9"}, "1 to 8"}},
        {"hploc.merge_pairs", {{"on", "off"}, {"auto", ""}, "on or off"}},
        {"hploc.leaf_size", {{"1", "2", "8"}, {"0", "9"}, "1 to 8"}},
    };
    return table;
}

void expect_message(const std::string& message, const Change& change) {
    BuildOptions options;
    change(options);
    expect_error(ErrorCode::invalid_input, {message}, [&] { check_options(options); });
}

std::string text_of(float value) {
    std::ostringstream text;
    text << value;
    return text.str();
}

/// The names of all options, and of those whose values differ.
Values names_where(const BuildOptions& a, const BuildOptions& b) {
    Values names;
    for (const OptionInfo& option : options()) {
        if (get_option(a, option.name) != get_option(b, option.name)) names.emplace_back(option.name);
    }
    return names;
}

}  // namespace

TEST_CASE("options: the defaults are valid, and the table states them as the Configs do") {
    CHECK_NOTHROW(check_options({}));
    for (const OptionInfo& option : options()) {
        INFO(option.name);
        CHECK(option.default_value == get_option(BuildOptions{}, option.name));
    }
    CHECK(find_option("ploc.search_radius").default_value == std::to_string(PlocConfig{}.search_radius));
    CHECK(find_option("sbvh.alpha").default_value == "1e-05");
    CHECK(find_option("inner_cost").default_value == "1.2");
    CHECK(find_option("hploc.merge_pairs").default_value == "on");
    CHECK(find_option("device.shape").default_value == "auto");
    CHECK(find_option("optimizers").default_value == "");
}

TEST_CASE("options: each has a name of its own, a flag, and a help of one line") {
    std::set<std::string_view> names;
    std::set<std::string_view> finished_groups;
    std::string_view group;
    for (const OptionInfo& option : options()) {
        INFO(option.name);
        CHECK(names.insert(option.name).second);
        CHECK(&find_option(option.name) == &option);
        CHECK(option.flag.starts_with("--"));
        CHECK_FALSE(option.help.empty());
        CHECK(option.help.find_first_of("\n|") == std::string_view::npos);
        CHECK(option.values.find_first_of("\n|") == std::string::npos);
        CHECK((option.type == OptionType::choice) == !option.choices.empty());
        if (option.group != group) CHECK(finished_groups.insert(group).second);
        group = option.group;
        CHECK_FALSE(finished_groups.contains(option.group));
    }
    CHECK(names.size() == limits().size());
}

TEST_CASE("options: what one flag sets is of one kind, with one default") {
    for (const OptionInfo& a : options()) {
        for (const OptionInfo& b : options()) {
            if (a.flag != b.flag) continue;
            INFO(a.name << " and " << b.name);
            CHECK(a.type == b.type);
            CHECK(a.values == b.values);
            CHECK(a.default_value == b.default_value);
            CHECK(a.group == b.group);
        }
    }
}

TEST_CASE("options: each value that is set is the value that is read, and nothing else changes") {
    for (const OptionInfo& option : options()) {
        for (const std::string& value : limits().at(std::string(option.name)).taken) {
            INFO(option.name << " " << value);
            BuildOptions changed;
            set_option(changed, option.name, value);
            CHECK(get_option(changed, option.name) == value);
            CHECK_NOTHROW(check_options(changed));
            const Values expected = value == option.default_value ? Values{} : Values{std::string(option.name)};
            CHECK(names_where(changed, {}) == expected);
        }
    }
}

TEST_CASE("options: each value out of range is refused with the option and what it takes, and changes nothing") {
    for (const OptionInfo& option : options()) {
        const Limits& of_option = limits().at(std::string(option.name));
        for (const std::string& value : of_option.refused) {
            INFO(option.name << " '" << value << "'");
            BuildOptions changed;
            const std::string name = option.type == OptionType::text ? "" : std::string(option.name) + " is ";
            expect_error(ErrorCode::invalid_input, {name, of_option.range},
                         [&] { set_option(changed, option.name, value); });
            CHECK(names_where(changed, {}).empty());
        }
        if (option.type != OptionType::text) CHECK(option.values == of_option.range);
        if (option.type == OptionType::text || option.type == OptionType::choice) continue;
        for (const std::string value : {"", "many", "1 ", " 1", "1x"}) {
            BuildOptions changed;
            expect_error(ErrorCode::invalid_input,
                         {std::string(option.name) + " is '" + value + "'; it must be " + of_option.range},
                         [&] { set_option(changed, option.name, value); });
        }
    }
}

TEST_CASE("options: what a flag alone stands for is a value that the option takes") {
    for (const OptionInfo& option : options()) {
        if (option.implied.empty()) continue;
        BuildOptions changed;
        set_option(changed, option.name, option.implied);
        CHECK(names_where(changed, {}) == Values{std::string(option.name)});
    }
    CHECK(find_option("presplit_level").implied == "14");
    CHECK(find_option("split_quota").implied == "0.3");
}

TEST_CASE("options: a name that there is not is refused with those that there are") {
    BuildOptions some;
    for (const std::string name : {"", "radius", "ploc", "ploc.", "PLOC.search_radius", "device.search_radius"}) {
        INFO(name);
        expect_error(ErrorCode::invalid_input, {"unknown option '" + name + "'", "max_leaf_size", "ploc.search_radius"},
                     [&] { set_option(some, name, "1"); });
        CHECK_THROWS_AS(get_option(some, name), Error);
        CHECK_THROWS_AS(find_option(name), Error);
        CHECK_THROWS_AS(reads_option("ploc", name), Error);
    }
    expect_error(ErrorCode::invalid_input, {"did you mean ploc.search_radius or hploc.search_radius;"},
                 [&] { set_option(some, "search_radius", "1"); });
    expect_error(ErrorCode::invalid_input, {"did you mean binned_sah.bin_count or sbvh.bin_count;"},
                 [&] { set_option(some, "bin_count", "8"); });
}

TEST_CASE("options: builders and presets read those of their own Config and of all builds") {
    const auto own_names = [](std::string_view builder) {
        std::string names;
        for (const OptionInfo& option : options()) {
            const bool is_own = option.name.find('.') != std::string_view::npos && !option.name.starts_with("device.");
            if (is_own && reads_option(builder, option.name)) names += std::string(option.name) + " ";
        }
        return names;
    };
    CHECK(own_names("ploc") == "ploc.search_radius ploc.chunk_size ploc.work_group_size ");
    CHECK(own_names("plocpp") ==
          "ploc.search_radius ploc.neighbour_encoding ploc.neighbour_search ploc.chunk_size ploc.work_group_size "
          "ploc.single_group_threshold ");
    CHECK(own_names("plocpp-two-level") ==
          "ploc.search_radius ploc.neighbour_encoding ploc.neighbour_search ploc.chunk_size ploc.work_group_size "
          "ploc.range_count ");
    CHECK(own_names("hploc") ==
          "hploc.search_radius hploc.cluster_limit hploc.small_range hploc.small_limit hploc.merge_pairs "
          "hploc.leaf_size ");
    CHECK(own_names("binned-sah") == "binned_sah.bin_count binned_sah.longest_axis_only ");
    CHECK(own_names("sbvh") == "sbvh.bin_count sbvh.spatial_bin_count sbvh.alpha sbvh.overlap sbvh.reference_budget ");
    for (const std::string_view id : {"lbvh", "sweep-sah", "aac-hq", "aac-fast", "locally-ordered", "median"})
        CHECK(own_names(id).empty());
    CHECK(own_names("balanced") == own_names("hploc"));
    for (const BuilderInfo& builder : builders()) {
        INFO(builder.id);
        for (const OptionInfo& option : options()) {
            if (option.name.starts_with("device."))
                CHECK(reads_option(builder.id, option.name) == (builder.kind == BuilderKind::device));
        }
        CHECK(reads_option(builder.id, "max_leaf_size"));
        CHECK(reads_option(builder.id, "thread_count"));
    }
    CHECK_THROWS_AS(reads_option("plok", "thread_count"), Error);
}

TEST_CASE("options: readers are words that there are") {
    for (const OptionInfo& option : options()) {
        INFO(option.name << ": " << option.readers);
        if (option.readers == "all" || option.readers == "device") continue;
        std::istringstream words(std::string(option.readers) + ",");
        for (std::string word; words >> word;) {
            REQUIRE(word.ends_with(','));
            CHECK(reads_option(word.substr(0, word.size() - 1), option.name));
        }
    }
}

TEST_CASE("options: numbers that are none are rejected where they stand in a struct") {
    for (const float cost : {0.0f, -1.0f, kInfinity, kNan}) {
        expect_message("inner_cost is " + text_of(cost) + "; it must be finite and above 0",
                       [&](BuildOptions& o) { o.inner_cost = cost; });
        expect_message("primitive_cost is " + text_of(cost) + "; it must be finite and above 0",
                       [&](BuildOptions& o) { o.primitive_cost = cost; });
    }
    expect_message("sbvh.alpha is nan; it must be 0 to 1", [](BuildOptions& o) { o.sbvh.alpha = kNan; });
    expect_message("ploc.search_radius is 33; it must be 1 to 32", [](BuildOptions& o) { o.ploc.search_radius = 33; });
}

TEST_CASE("options: values that are no enumerators are rejected") {
    expect_message("device.shape is 3; it must be auto, group or lane",
                   [](BuildOptions& o) { o.device.shape = static_cast<Shape>(3); });
    expect_message("device.morton_code is 3;",
                   [](BuildOptions& o) { o.device.morton_code = static_cast<MortonCode>(3); });
    expect_message("ploc.neighbour_encoding is 9;",
                   [](BuildOptions& o) { o.ploc.neighbour_encoding = static_cast<NeighbourEncoding>(9); });
    expect_message("ploc.neighbour_search is 255;",
                   [](BuildOptions& o) { o.ploc.neighbour_search = static_cast<NeighbourSearch>(255); });
    expect_message("optimize_on is 2;", [](BuildOptions& o) { o.optimize_on = static_cast<OptimizeOn>(2); });
}

TEST_CASE("options: the first out of its range is named") {
    expect_message("ploc.search_radius is 0", [](BuildOptions& o) {
        o.ploc.search_radius = 0;
        o.ploc.range_count = 1000;
    });
}

TEST_CASE("options: costs and leaf sizes of Configs have no say in a build, and are refused there") {
    expect_message("binned_sah.inner_cost is set", [](BuildOptions& o) { o.binned_sah.inner_cost = 2.0f; });
    expect_message("sbvh.primitive_cost is set", [](BuildOptions& o) { o.sbvh.primitive_cost = 2.0f; });
    expect_message("sbvh.max_leaf_size is set, but builds take BuildOptions::max_leaf_size",
                   [](BuildOptions& o) { o.sbvh.max_leaf_size = 4; });
}

TEST_CASE("options: leaves that are made before clustering are no larger than the largest") {
    BuildOptions options;
    options.hploc.leaf_size = 4;
    check_options(options);
    options.max_leaf_size = 4;
    check_options(options);
    options.max_leaf_size = 3;
    expect_error(ErrorCode::invalid_input, {"hploc.leaf_size 4", "max_leaf_size 3"}, [&] { check_options(options); });
}

TEST_CASE("options: two ways to split triangles contradict each other") {
    expect_message("presplit_level and split_quota", [](BuildOptions& o) {
        o.presplit_level = 14;
        o.split_quota = 0.3f;
    });
}
