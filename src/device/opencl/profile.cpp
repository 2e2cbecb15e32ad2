#include "clbvh/device/profile.hpp"

#include <cerrno>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <system_error>

#include "clbvh/core/error.hpp"
#include "core/fnv1a.hpp"
#include "device/opencl/user_folder.hpp"

namespace clbvh {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr const char* kFormat = "clbvh-profile";
constexpr int kVersion = 1;
/// Far more than a profile has: not every file that a variable names is one.
constexpr std::uintmax_t kMostBytes = 1 << 16;

/// The members of a profile's JSON, read one by one.
class ProfileReader {
public:
    explicit ProfileReader(const ordered_json& json) : json_(json) {
        if (!json.is_object()) fail("it is not an object");
        if (text("format") != kFormat) fail("its format is not " + std::string(kFormat));
        if (number_of("version", require("version")) != kVersion) fail("its version is not 1");
    }

    [[nodiscard]] std::string text(const char* name) const {
        const ordered_json& value = require(name);
        if (!value.is_string()) fail(std::string(name) + " is not a text");
        return value.get<std::string>();
    }
    /// 0 where it is not there.
    [[nodiscard]] std::uint32_t number(const char* name) const {
        return json_.contains(name) ? number_of(name, json_.at(name)) : 0;
    }
    /// Automatic where it is not there.
    [[nodiscard]] Shape shape(const char* name) const {
        if (!json_.contains(name)) return Shape::automatic;
        const std::optional<Shape> shape = shape_from(text(name));
        if (!shape) fail(std::string(name) + " is not auto, group or lane");
        return *shape;
    }

private:
    [[noreturn]] static void fail(const std::string& what) { throw Error(ErrorCode::invalid_input, what); }

    [[nodiscard]] const ordered_json& require(const char* name) const {
        if (!json_.contains(name)) fail("it has no " + std::string(name));
        return json_.at(name);
    }
    [[nodiscard]] static std::uint32_t number_of(const char* name, const ordered_json& value) {
        if (!value.is_number_unsigned() || value.get<std::uint64_t>() > UINT32_MAX) {
            fail(std::string(name) + " is not a whole number");
        }
        return value.get<std::uint32_t>();
    }

    const ordered_json& json_;
};

/// In range as the options are.
void check_profile(const Profile& profile) {
    BuildOptions options;
    options.chunk_size = profile.chunk_size;
    options.work_group_size = profile.work_group_size;
    options.single_group_threshold = profile.single_group_threshold;
    check_options(options);
}

Profile read_profile(std::string_view text) {
    const ordered_json json = ordered_json::parse(text, nullptr, false);
    if (json.is_discarded()) throw Error(ErrorCode::invalid_input, "it is not JSON");
    const ProfileReader reader(json);
    Profile profile;
    profile.platform = reader.text("platform");
    profile.device = reader.text("device");
    profile.driver_version = reader.text("driver_version");
    profile.sort_shape = reader.shape("sort_shape");
    profile.chunk_size = reader.number("chunk_size");
    profile.work_group_size = reader.number("work_group_size");
    profile.single_group_threshold = reader.number("single_group_threshold");
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
    return folder / ("profile-" + hexadecimal(id) + ".json");
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
    ordered_json json{{"format", kFormat},
                      {"version", kVersion},
                      {"platform", profile.platform},
                      {"device", profile.device},
                      {"driver_version", profile.driver_version}};
    if (profile.sort_shape != Shape::automatic) json["sort_shape"] = to_string(profile.sort_shape);
    if (profile.chunk_size != 0) json["chunk_size"] = profile.chunk_size;
    if (profile.work_group_size != 0) json["work_group_size"] = profile.work_group_size;
    if (profile.single_group_threshold != 0) json["single_group_threshold"] = profile.single_group_threshold;
    return json.dump(2, ' ', false, ordered_json::error_handler_t::replace) + '\n';
}

Profile parse_profile(std::string_view text, std::string_view name) {
    try {
        return read_profile(text);
    } catch (const Error& error) {
        throw Error(ErrorCode::invalid_input, std::string(name) + " is no profile: " + error.what());
    }
}

}  // namespace clbvh
