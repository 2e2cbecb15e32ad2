#pragma once

/// For what is used in code of several instruction sets: a copy of its own, compiled for one of them, might be called
/// by code of another.
#if defined(__GNUC__)
#define CLBVH_ALWAYS_INLINE inline __attribute__((always_inline))
#else
#define CLBVH_ALWAYS_INLINE inline
#endif
