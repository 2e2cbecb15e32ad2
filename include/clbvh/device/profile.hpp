#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "clbvh/device/device.hpp"
#include "clbvh/device/hand_over.hpp"
#include "clbvh/device/shape.hpp"
#include "clbvh/export.h"

namespace clbvh {

/// The sizes that measured fastest on one device with one driver (`clbvh tune`), and what its self-test found. They
/// stand in for options that are automatic, change how work is laid out and never the tree, and give way where the
/// device or other options leave no room for it. A zero or automatic field has nothing to say.
struct Profile {
    std::string platform;                      ///< DeviceInfo::platform of the device.
    std::string device;                        ///< DeviceInfo::name.
    std::string driver_version;                ///< DeviceInfo::driver_version.
    Shape sort_shape = Shape::automatic;       ///< See DeviceConfig.
    std::uint32_t chunk_size = 0;              ///< See PlocConfig.
    std::uint32_t work_group_size = 0;         ///< See PlocConfig.
    std::uint32_t single_group_threshold = 0;  ///< See PlocConfig.
    HandOver hand_over = HandOver::automatic;  ///< What the device's self-test found; see ContextOptions.
};

/// Where a device's profile was looked for, and what was there.
struct FoundProfile {
    std::filesystem::path path;      ///< Empty where there is no place to look.
    std::optional<Profile> profile;  ///< Absent where none is to be used.
    std::string reason;              ///< Why a file that is there is not used; empty where there is none or it is.
};

/// The device's own file in the folder of profiles: clbvh in XDG_CONFIG_HOME or in ~/.config. Empty where neither that
/// variable nor HOME is set.
[[nodiscard]] CLBVH_API std::filesystem::path profile_path(const DeviceInfo& device);

/// The profile that contexts on this device use: of the file that the variable CLBVH_PROFILE names ("off": of none),
/// else of profile_path(). It has to be for this platform, device and driver, else it is not used, and `reason` says
/// so. Throws Error(io) or Error(invalid_input) where the file that CLBVH_PROFILE names cannot be read or is no
/// profile; elsewhere such a file is not used.
[[nodiscard]] CLBVH_API FoundProfile find_profile(const DeviceInfo& device);

/// A profile as text, for a file: a line NAME = VALUE for each field that says something. Empty lines and those that
/// begin with # say nothing.
[[nodiscard]] CLBVH_API std::string profile_text(const Profile& profile);

/// The profile in such a text. Throws Error(invalid_input) naming what is wrong first, with `name` before it.
[[nodiscard]] CLBVH_API Profile parse_profile(std::string_view text, std::string_view name);

}  // namespace clbvh
