#pragma once

#include <cstddef>

#include "clbvh/clbvh.h"

// Exceptions end here: no function of the C interface lets one out.
namespace clbvh::c {

/// The longest message of clbvh_last_error, with the zero behind it; longer ones are cut.
inline constexpr std::size_t kMessageBytes = 4096;

/// This thread's last message; "" before the first.
[[nodiscard]] const char* last_message() noexcept;

/// Called while an exception is handled: its code. Its message becomes last_message(). Asks for no memory.
[[nodiscard]] clbvh_error report_exception() noexcept;

/// Runs `body`; what it throws becomes a code, and its message last_message().
template <class Body>
clbvh_error guarded(Body&& body) noexcept {
    try {
        body();
        return CLBVH_OK;
    } catch (...) {
        return report_exception();
    }
}

}  // namespace clbvh::c
