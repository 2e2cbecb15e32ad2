// The box tests for code that is compiled with -ffast-math, which may not have them inline.
#define CLBVH_DEFINES_BOX_TESTS 1
#include "clbvh/trace/box_tests.hpp"
