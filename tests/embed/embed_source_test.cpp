#include <catch2/catch.hpp>
#include <string_view>

#include "clbvh/clbvh.h"
#include "clbvh/embed.hpp"

TEST_CASE("the source for kernels of one's own is there without a device, also in C") {
    const std::string_view source = clbvh::embed_source();
    CHECK(source.starts_with("// Rays through trees"));
    CHECK(source.ends_with("#endif\n"));
    CHECK(std::string_view(clbvh_embed_source()) == source);
}

TEST_CASE("the source for kernels of one's own holds no name without its prefix") {
    // What it defines: each macro, function and type.
    const std::string_view source = clbvh::embed_source();
    std::size_t macros = 0, others = 0;
    for (std::size_t at = source.find("#define "); at != source.npos; at = source.find("#define ", at + 1)) {
        const std::string_view name = source.substr(at + 8, 6);
        ++macros;
        if (name != "CLBVH_" && name != "clbvh_") ++others;
    }
    CHECK(macros > 10);
    CHECK(others == 0);
}
