#define CATCH_CONFIG_RUNNER
#include <catch2/catch.hpp>
#include <cstdlib>

int main(int argc, char** argv) {
    // Files kept on this machine must not influence tests, unless a test says so.
    setenv("CLBVH_CACHE", "off", 1);
    setenv("CLBVH_PROFILE", "off", 1);
    return Catch::Session().run(argc, argv);
}
