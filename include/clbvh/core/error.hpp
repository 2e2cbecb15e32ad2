#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

#include "clbvh/export.h"

namespace clbvh {

/// Kinds of failure that an Error reports. The C API returns the same values.
enum class ErrorCode : int {
    invalid_input = 1,   ///< The caller's data or options are out of their documented range.
    unsupported = 2,     ///< The request is valid, but this device or build of the library cannot serve it.
    no_device = 3,       ///< No OpenCL device, or none that fits the selector.
    device_failure = 4,  ///< An OpenCL call failed for a reason other than memory.
    out_of_memory = 5,   ///< Host or device memory is exhausted.
    io = 6,              ///< A file could not be read, parsed or written.
    cancelled = 7,       ///< The progress callback asked to stop.
};

/// The code's name as documented, for example "invalid_input".
[[nodiscard]] constexpr std::string_view to_string(ErrorCode code) noexcept {
    switch (code) {
        case ErrorCode::invalid_input: return "invalid_input";
        case ErrorCode::unsupported: return "unsupported";
        case ErrorCode::no_device: return "no_device";
        case ErrorCode::device_failure: return "device_failure";
        case ErrorCode::out_of_memory: return "out_of_memory";
        case ErrorCode::io: return "io";
        case ErrorCode::cancelled: return "cancelled";
    }
    return "unknown";
}

/// The one exception type that the library throws on purpose.
class CLBVH_API Error : public std::runtime_error {
public:
    /// `message` names the first offender and says what to do.
    Error(ErrorCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
    Error(const Error&) = default;
    Error& operator=(const Error&) = default;
    ~Error() override;  // in the library, and with it the one type information by which it is caught everywhere

    [[nodiscard]] ErrorCode code() const noexcept { return code_; }

private:
    ErrorCode code_;
};

}  // namespace clbvh
