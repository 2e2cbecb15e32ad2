/* An OpenCL driver that fails: a library for the ICD loader with one platform, whose devices cannot be listed.
 * FAILING_DRIVER_DEVICES is the error of clGetDeviceIDs, FAILING_DRIVER_NAME that of the platform's name. */
#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>
#include <CL/cl_icd.h>
#include <stdlib.h>
#include <string.h>

struct _cl_platform_id {
    cl_icd_dispatch* dispatch;
};

static cl_icd_dispatch calls;
static struct _cl_platform_id only_platform = {&calls};

static const char* text_of(cl_platform_info what) {
    switch (what) {
        case CL_PLATFORM_NAME: return "A failing driver";
        case CL_PLATFORM_VENDOR: return "Nobody";
        case CL_PLATFORM_VERSION: return "OpenCL 1.2";
        case CL_PLATFORM_PROFILE: return "FULL_PROFILE";
        case CL_PLATFORM_EXTENSIONS: return "cl_khr_icd";
        case CL_PLATFORM_ICD_SUFFIX_KHR: return "FAIL";
        default: return NULL;
    }
}

static cl_int CL_API_CALL platform_info(cl_platform_id platform, cl_platform_info what, size_t room, void* value,
                                        size_t* size) {
    const char* const text = text_of(what);
    const char* const error = getenv("FAILING_DRIVER_NAME");
    (void)platform;
    if (text == NULL) return CL_INVALID_VALUE;
    if (error != NULL && what == CL_PLATFORM_NAME) return atoi(error);
    if (size != NULL) *size = strlen(text) + 1;
    if (value == NULL) return CL_SUCCESS;
    if (room < strlen(text) + 1) return CL_INVALID_VALUE;
    strcpy(value, text);
    return CL_SUCCESS;
}

static cl_int CL_API_CALL device_ids(cl_platform_id platform, cl_device_type type, cl_uint room, cl_device_id* devices,
                                     cl_uint* count) {
    const char* const error = getenv("FAILING_DRIVER_DEVICES");
    (void)platform, (void)type, (void)room, (void)devices;
    if (count != NULL) *count = 0;
    return error != NULL ? atoi(error) : CL_DEVICE_NOT_FOUND;
}

CL_API_ENTRY cl_int CL_API_CALL clIcdGetPlatformIDsKHR(cl_uint room, cl_platform_id* platforms, cl_uint* count) {
    calls.clGetPlatformInfo = platform_info;
    calls.clGetDeviceIDs = device_ids;
    if (count != NULL) *count = 1;
    if (platforms != NULL && room > 0) platforms[0] = &only_platform;
    return CL_SUCCESS;
}

CL_API_ENTRY cl_int CL_API_CALL clGetPlatformInfo(cl_platform_id platform, cl_platform_info what, size_t room,
                                                  void* value, size_t* size) {
    return platform_info(platform, what, room, value, size);
}

CL_API_ENTRY void* CL_API_CALL clGetExtensionFunctionAddress(const char* name) {
    if (strcmp(name, "clIcdGetPlatformIDsKHR") == 0) return (void*)(size_t)&clIcdGetPlatformIDsKHR;
    return NULL;
}
