#include "c/guarded.hpp"

#include <algorithm>
#include <cstring>
#include <exception>
#include <new>

#include "clbvh/clbvh.hpp"

namespace clbvh::c {
namespace {

// Not a std::string: a message must not ask for memory, least of all when there is none.
thread_local char message[kMessageBytes];

clbvh_error report(const char* text, clbvh_error code) noexcept {
    const std::size_t length = std::min(std::strlen(text), kMessageBytes - 1);
    std::memcpy(message, text, length);
    message[length] = '\0';
    return code;
}

}  // namespace

const char* last_message() noexcept {
    return message;
}

clbvh_error report_exception() noexcept {
    try {
        throw;
    } catch (const Error& error) {
        return report(error.what(), static_cast<clbvh_error>(error.code()));
    } catch (const std::bad_alloc&) {
        return report("the host has no memory left", CLBVH_OUT_OF_MEMORY);
    } catch (const std::exception& error) {
        return report(error.what(), CLBVH_INTERNAL);
    } catch (...) {
        return report("an unknown exception", CLBVH_INTERNAL);
    }
}

}  // namespace clbvh::c
