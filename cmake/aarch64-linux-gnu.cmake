# Toolchain: from any Debian to aarch64, with g++-aarch64-linux-gnu and, for the tests, qemu-user.
# CLBVH_AARCH64_SYSROOT: what cmake/aarch64-sysroot.sh has made.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
set(CMAKE_LIBRARY_ARCHITECTURE aarch64-linux-gnu)

set(CLBVH_AARCH64_SYSROOT ${CMAKE_CURRENT_LIST_DIR}/../build-aarch64-sysroot CACHE PATH "Packages for aarch64, unpacked")
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES CLBVH_AARCH64_SYSROOT)
set(CMAKE_FIND_ROOT_PATH ${CLBVH_AARCH64_SYSROOT} /usr/aarch64-linux-gnu)
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)

set(CMAKE_CROSSCOMPILING_EMULATOR qemu-aarch64 -L /usr/aarch64-linux-gnu)
