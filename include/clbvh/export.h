#ifndef CLBVH_EXPORT_H
#define CLBVH_EXPORT_H

/* What a library exports is marked with CLBVH_API (the library clbvh), CLBVH_IO_API (clbvh_io) or CLBVH_EVAL_API
   (clbvh_eval); all else stays inside. The packages define CLBVH_STATIC for static libraries, which export nothing. */

#if defined(CLBVH_STATIC)
#define CLBVH_EXPORT
#define CLBVH_IMPORT
#define CLBVH_NO_EXPORT
#elif defined(_WIN32)
#define CLBVH_EXPORT __declspec(dllexport)
#define CLBVH_IMPORT __declspec(dllimport)
#define CLBVH_NO_EXPORT
#else
#define CLBVH_EXPORT __attribute__((visibility("default")))
#define CLBVH_IMPORT __attribute__((visibility("default")))
#define CLBVH_NO_EXPORT __attribute__((visibility("hidden"))) /* what an exported class keeps to itself */
#endif

/* CLBVH_EXPORTS and its kind are defined while the library itself is compiled. */
#if defined(CLBVH_EXPORTS)
#define CLBVH_API CLBVH_EXPORT
#else
#define CLBVH_API CLBVH_IMPORT
#endif

#if defined(CLBVH_IO_EXPORTS)
#define CLBVH_IO_API CLBVH_EXPORT
#else
#define CLBVH_IO_API CLBVH_IMPORT
#endif

#if defined(CLBVH_EVAL_EXPORTS)
#define CLBVH_EVAL_API CLBVH_EXPORT
#else
#define CLBVH_EVAL_API CLBVH_IMPORT
#endif

#endif
