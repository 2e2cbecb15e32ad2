#include "clbvh/version.h"

uint32_t clbvh_version(void) {
    return CLBVH_VERSION_NUMBER;
}

const char* clbvh_version_string(void) {
    return CLBVH_VERSION_STRING;
}
