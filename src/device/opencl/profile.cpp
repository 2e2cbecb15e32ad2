#include "clbvh/device/profile.hpp"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <map>
#include <system_error>

#include "clbvh/core/error.hpp"
#include "core/fnv1a.hpp"
#include "device/opencl/layout_rules.hpp"
#include "device/opencl/user_folder.hpp"

namespace clbvh {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFormat = "clbvh-profile";
constexpr const char* kVersion = "1";
/// Far more than a profile has: not every file that a variable names is one.
constexpr std::uintmax_t kMostBytes = 1 << 16;

std::string_view without_blanks(std::string_view text) {
    constexpr std::string_view kBlanks = " \t\r";
    const std::size_t begin = text.find_first_not_of(kBlanks);
    return begin == std::string_view::npos ? std::string_view{}
                                           : text.substr(begin, text.find_last_not_of(kBlanks) - begin + 1);
}

/// The lines `NAME = VALUE` of a profile; empty ones and those that begin with # say nothing.
class ProfileReader {
public:
    explicit ProfileReader(std::string_view text) {
        for (std::size_t number = 1; !text.empty(); ++number) {
            const std::size_t length = std::min(text.find('\n'), text.size());
            read_line(without_blanks(text.substr(0, length)), number);
            text.remove_prefix(std::min(length + 1, text.size()));
        }
        if (this->text("format") != kFormat) fail("its format is not " + std::string(kFormat));
        if (this->text("version") != kVersion) fail("its version is not " + std::string(kVersion));
    }

    [[nodiscard]] const std::string& text(const std::string& name) const {
        const auto value = values_.find(name);
        if (value == values_.end()) fail("it has no " + name);
        return value->second;
    }
    /// 0 where it is not there.
    [[nodiscard]] std::uint32_t number(const std::string& name) const {
        const auto value = values_.find(name);
        if (value == values_.end()) return 0;
        std::uint32_t number = 0;
        const char* const end = value->second.data() + value->second.size();
        const auto [parsed_to, error] = std::from_chars(value->second.data(), end, number);
        if (error != std::errc() || parsed_to != end) fail(name + " is not a whole number");
        return number;
    }
    /// Automatic where it is not there.
    [[nodiscard]] Shape shape(const std::string& name) const {
        const auto value = values_.find(name);
        if (value == values_.end()) return Shape::automatic;
        for (const Shape shape : {Shape::automatic, Shape::group, Shape::lane}) {
            if (value->second == to_string(shape)) return shape;
        }
        fail(name + " is not auto, group or lane");
    }

    /// Automatic where it is not there.
    [[nodiscard]] HandOver hand_over(const std::string& name) const {
        const auto value = values_.find(name);
        if (value == values_.end()) return HandOver::automatic;
        for (const HandOver each : {HandOver::automatic, HandOver::within_launch, HandOver::between_launches}) {
            if (value->second == to_string(each)) return each;
        }
        fail(name + " is not auto, within or between");
    }

private:
    [[noreturn]] static void fail(const std::string& what) { throw Error(ErrorCode::invalid_input, what); }

    void read_line(std::string_view line, std::size_t number) {
        if (line.empty() || line.starts_with('#')) return;
        const std::size_t equals = line.find('=');
        const std::string_view name = without_blanks(line.substr(0, equals));
        if (equals == std::string_view::npos || name.empty()) {
            fail("line " + std::to_string(number) + " is not NAME = VALUE");
        }
        if (!values_.emplace(name, without_blanks(line.substr(equals + 1))).second) {
            fail(std::string(name) + " is there twice");
        }
    }

    std::map<std::string, std::string> values_;
};

/// In range as the options are.
void check_profile(const Profile& profile) {
    check_field("chunk_size", profile.chunk_size, device::kChunkSizes);
    check_field("work_group_size", profile.work_group_size, device::kWorkGroupSizes);
    check_field("single_group_threshold", profile.single_group_threshold, device::kSingleGroupThresholds);
}

Profile read_profile(std::string_view text) {
    const ProfileReader reader(text);
    Profile profile;
    profile.platform = reader.text("platform");
    profile.device = reader.text("device");
    profile.driver_version = reader.text("driver_version");
    profile.sort_shape = reader.shape("sort_shape");
    profile.chunk_size = reader.number("chunk_size");
    profile.work_group_size = reader.number("work_group_size");
    profile.single_group_threshold = reader.number("single_group_threshold");
    profile.hand_over = reader.hand_over("hand_over");
    check_profile(profile);
    return profile;
}

std::string read_file(const fs::path& path) {
    std::error_code error;
    const fs::file_status status = fs::status(path, error);
    // Opening a pipe would wait for whoever writes to it.
    const bool is_too_large = fs::is_regular_file(status) && fs::file_size(path, error) > kMostBytes;
    if (is_too_large || (fs::exists(status) && !fs::is_regular_file(status))) {
        throw Error(ErrorCode::invalid_input, path.string() + " is no profile");
    }
    errno = 0;
    std::ifstream file(path, std::ios::binary);
    if (!file) {
        throw Error(ErrorCode::io, "cannot read " + path.string() + ": " + std::generic_category().message(errno));
    }
    return {std::istreambuf_iterator<char>(file), {}};
}

/// The profile of the file where it is for this device, else why not.
FoundProfile profile_in(const fs::path& path, const DeviceInfo& device) {
    FoundProfile found{path, parse_profile(read_file(path), path.string()), ""};
    const auto reject = [&](const std::string& reason) {
        found.profile.reset();
        found.reason = reason;
    };
    const Profile profile = *found.profile;
    if (profile.platform != device.platform || profile.device != device.name) {
        reject("it is for " + profile.device + " of " + profile.platform);
    } else if (profile.driver_version != device.driver_version) {
        reject("it is for driver version " + profile.driver_version + ", not " + device.driver_version);
    }
    return found;
}

}  // namespace

fs::path profile_path(const DeviceInfo& device) {
    const fs::path folder = device::user_folder("XDG_CONFIG_HOME", ".config");
    if (folder.empty()) return {};
    const std::uint64_t id = fnv1a(device.platform + '\n' + device.name + '\n' + device.driver_version);
    return folder / ("profile-" + hexadecimal(id) + ".txt");
}

FoundProfile find_profile(const DeviceInfo& device) {
    if (const std::string_view named = device::environment("CLBVH_PROFILE"); !named.empty()) {
        if (named == "off") return {};
        try {
            return profile_in(named, device);
        } catch (const Error& error) {
            throw Error(error.code(), std::string("CLBVH_PROFILE: ") + error.what());
        }
    }
    const fs::path path = profile_path(device);
    std::error_code unreadable;
    if (path.empty() || !fs::exists(path, unreadable)) return {path, std::nullopt, ""};
    try {
        return profile_in(path, device);
    } catch (const Error& error) {
        return {path, std::nullopt, error.what()};
    }
}

std::string profile_text(const Profile& profile) {
    std::string text;
    const auto add = [&](const char* name, std::string value) {
        std::ranges::replace(value, '\n', ' ');
        text += std::string(name) + " = " + value + '\n';
    };
    add("format", kFormat);
    add("version", kVersion);
    add("platform", profile.platform);
    add("device", profile.device);
    add("driver_version", profile.driver_version);
    if (profile.sort_shape != Shape::automatic) add("sort_shape", std::string(to_string(profile.sort_shape)));
    if (profile.hand_over != HandOver::automatic) add("hand_over", std::string(to_string(profile.hand_over)));
    for (const auto& [name, value] :
         {std::pair{"chunk_size", profile.chunk_size}, std::pair{"work_group_size", profile.work_group_size},
          std::pair{"single_group_threshold", profile.single_group_threshold}}) {
        if (value != 0) add(name, std::to_string(value));
    }
    return text;
}

Profile parse_profile(std::string_view text, std::string_view name) {
    try {
        return read_profile(text);
    } catch (const Error& error) {
        throw Error(ErrorCode::invalid_input, std::string(name) + " is no profile: " + error.what());
    }
}

}  // namespace clbvh
