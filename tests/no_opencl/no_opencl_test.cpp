// A build without OpenCL lists device builders and says why they do not run.
#include <catch2/catch.hpp>
#include <string>

#include "clbvh/clbvh.h"
#include "clbvh/clbvh.hpp"
#include "support/c_builder.hpp"
#include "support/expect_error.hpp"

using namespace clbvh;
using namespace clbvh::test;

TEST_CASE("without OpenCL there is no device, and whoever asks for one is told why") {
    CHECK(list_devices().empty());
    for (const BuilderInfo& info : builders()) {
        if (info.kind == BuilderKind::host) continue;
        INFO(info.id);
        expect_error(ErrorCode::unsupported, {"no OpenCL", "CLBVH_WITH_OPENCL"}, [&] { (void)Builder(info.id); });
        CBuilder c;
        CHECK(clbvh_create_builder(std::string(info.id).c_str(), nullptr, &c.handle) == CLBVH_UNSUPPORTED);
        CHECK_THAT(clbvh_last_error(), Catch::Contains("no OpenCL"));
    }
    for (const char* const preset : {"fast", "balanced", "high"})
        expect_error(ErrorCode::unsupported, {"no OpenCL"}, [&] { (void)Builder(preset); });
}
