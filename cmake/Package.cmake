# Installation: libraries, headers, the CMake package, pkg-config files. Everything installed finds the rest
# relative to itself, so that the tree may be moved; CMake appends DESTDIR and --prefix as usual.
if(NOT CLBVH_INSTALL)
  return()
endif()
include(CMakePackageConfigHelpers)

set(clbvh_package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/clbvh)
set(clbvh_kernel_dir ${CMAKE_INSTALL_DATADIR}/clbvh/kernels)  # what callers include into programs of their own
file(RELATIVE_PATH clbvh_pc_prefix ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX})
string(REGEX REPLACE "/$" "" clbvh_pc_prefix ${clbvh_pc_prefix})
cmake_path(APPEND clbvh_pc_libdir "\${prefix}" ${CMAKE_INSTALL_LIBDIR})
cmake_path(APPEND clbvh_pc_includedir "\${prefix}" ${CMAKE_INSTALL_INCLUDEDIR})
cmake_path(APPEND clbvh_pc_kerneldir "\${prefix}" ${clbvh_kernel_dir})

# What C programs need beside what their compiler links: the C++ runtime.
set(clbvh_cxx_runtime ${CMAKE_CXX_IMPLICIT_LINK_LIBRARIES})
list(REMOVE_ITEM clbvh_cxx_runtime ${CMAKE_C_IMPLICIT_LINK_LIBRARIES})

# clbvh_package(SUFFIX KIND COMPONENT...): installs the libraries clbvh<SUFFIX>, ..., which are SHARED or STATIC, and what goes
# with them. What follows is said of each file that is installed.
function(clbvh_package suffix kind)
  set(build_dir ${PROJECT_BINARY_DIR}/package${suffix})
  install(TARGETS clbvh${suffix} clbvh_io${suffix} clbvh_eval${suffix} EXPORT clbvh-targets${suffix}
    RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} ${ARGN}
    LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} ${ARGN}
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} ${ARGN})
  set(left_out)
  if(NOT CLBVH_WITH_OPENCL)
    set(left_out REGEX "/device/(device_[a-z]+|batch_builder)\\.hpp$" EXCLUDE)
  endif()
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/clbvh DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} ${ARGN}
    FILES_MATCHING PATTERN "*.hpp" PATTERN "*.h" ${left_out})
  install(FILES ${PROJECT_BINARY_DIR}/kernels/clbvh_trace.clh DESTINATION ${clbvh_kernel_dir} ${ARGN})
  install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} ${ARGN})

  # CMake package. A static library hands what it links to its consumer; a shared one has linked it already.
  set(clbvh_is_static OFF)
  if(kind STREQUAL STATIC)
    set(clbvh_is_static ON)
  endif()
  set(clbvh_needs_assimp OFF)
  if(clbvh_is_static AND TARGET assimp::assimp)
    set(clbvh_needs_assimp ON)
  endif()
  configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/clbvh-config.cmake.in ${build_dir}/clbvh-config.cmake
    INSTALL_DESTINATION ${clbvh_package_dir}
    PATH_VARS clbvh_kernel_dir
    NO_SET_AND_CHECK_MACRO)
  write_basic_package_version_file(${build_dir}/clbvh-config-version.cmake COMPATIBILITY SameMinorVersion)
  # CMake makes files of one name and destination only once, hence the suffix.
  install(EXPORT clbvh-targets${suffix} NAMESPACE clbvh:: DESTINATION ${clbvh_package_dir} ${ARGN})
  install(FILES ${build_dir}/clbvh-config.cmake ${build_dir}/clbvh-config-version.cmake
    DESTINATION ${clbvh_package_dir} ${ARGN})

  clbvh_pkg_config("${suffix}" ${clbvh_is_static} ${ARGN})
endfunction()

# clbvh_pkg_config(SUFFIX IS_STATIC COMPONENT...): the pkg-config files, relative to their own place. Private needs are for
# static linking: where there are only static libraries, they are everybody's.
function(clbvh_pkg_config suffix is_static)
  set(build_dir ${PROJECT_BINARY_DIR}/package${suffix})
  set(definitions ${clbvh_definitions})
  set(requires)
  set(private_requires tbb)
  set(io_private_requires)
  list(TRANSFORM clbvh_cxx_runtime PREPEND -l OUTPUT_VARIABLE private_libs)
  if(CLBVH_WITH_OPENCL)
    list(APPEND requires OpenCL)
  endif()
  if(TARGET assimp::assimp)
    list(APPEND io_private_requires assimp)
  endif()
  set(libs)
  set(io_requires "clbvh = ${PROJECT_VERSION}")
  if(is_static)
    list(APPEND definitions CLBVH_STATIC)
    list(APPEND requires ${private_requires})
    list(APPEND io_requires ${io_private_requires})
    list(APPEND libs ${private_libs})
    set(private_requires)
    set(io_private_requires)
    set(private_libs)
  endif()
  list(TRANSFORM definitions PREPEND " -D")
  list(JOIN definitions "" clbvh_pc_definitions)
  list(JOIN requires ", " clbvh_pc_requires)
  list(JOIN private_requires ", " clbvh_pc_private_requires)
  list(JOIN io_requires ", " clbvh_io_pc_requires)
  list(JOIN io_private_requires ", " clbvh_io_pc_private_requires)
  list(TRANSFORM libs PREPEND " ")
  list(JOIN libs "" clbvh_pc_libs)
  list(JOIN private_libs " " clbvh_pc_private_libs)
  foreach(name IN ITEMS clbvh clbvh-io clbvh-eval)
    configure_file(${PROJECT_SOURCE_DIR}/cmake/${name}.pc.in ${build_dir}/${name}.pc @ONLY)
    install(FILES ${build_dir}/${name}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig ${ARGN})
  endforeach()
endfunction()

clbvh_package("" ${clbvh_kind})
if(clbvh_builds_both_kinds)
  clbvh_package(_other ${clbvh_other_kind} COMPONENT clbvh_other EXCLUDE_FROM_ALL)
endif()
