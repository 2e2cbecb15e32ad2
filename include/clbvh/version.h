#ifndef CLBVH_VERSION_H
#define CLBVH_VERSION_H

/* The version of the headers, and that of the library which is linked; for C and C++. The build reads it here. */

#include <stdint.h>

#include "clbvh/export.h"

#define CLBVH_VERSION_MAJOR 0
#define CLBVH_VERSION_MINOR 1
#define CLBVH_VERSION_PATCH 0

/** One number that grows with the version: 10203 for 1.2.3. */
#define CLBVH_VERSION_NUMBER (CLBVH_VERSION_MAJOR * 10000 + CLBVH_VERSION_MINOR * 100 + CLBVH_VERSION_PATCH)

#define CLBVH_VERSION_TEXT_OF_(number) #number
#define CLBVH_VERSION_TEXT_(major, minor, patch) \
    CLBVH_VERSION_TEXT_OF_(major) "." CLBVH_VERSION_TEXT_OF_(minor) "." CLBVH_VERSION_TEXT_OF_(patch)
/** The version as text: "1.2.3". */
#define CLBVH_VERSION_STRING CLBVH_VERSION_TEXT_(CLBVH_VERSION_MAJOR, CLBVH_VERSION_MINOR, CLBVH_VERSION_PATCH)

#ifdef __cplusplus
extern "C" {
#endif

/** CLBVH_VERSION_NUMBER of the library that is linked, which may be another than the headers'. */
CLBVH_API uint32_t clbvh_version(void);
/** CLBVH_VERSION_STRING of the library that is linked; never null. */
CLBVH_API const char* clbvh_version_string(void);

#ifdef __cplusplus
}
#endif

#endif
