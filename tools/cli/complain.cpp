#include "cli/complain.hpp"

#include <cstdio>

namespace clbvh::tool {

void complain(const std::string& text) noexcept {
    std::fputs("clbvh: ", stderr);
    std::fputs(text.c_str(), stderr);
    std::fputc('\n', stderr);
}

}  // namespace clbvh::tool
