# Installation: libraries, headers, the CMake package, pkg-config files. Everything installed finds the rest
# relative to itself, so that the tree may be moved; CMake appends DESTDIR and --prefix as usual.
if(NOT CLBVH_INSTALL)
  return()
endif()
include(CMakePackageConfigHelpers)

set(clbvh_package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/clbvh)

install(TARGETS clbvh clbvh_io clbvh_eval EXPORT clbvh-targets
  RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR}
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/clbvh DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
  FILES_MATCHING PATTERN "*.hpp" PATTERN "*.h")
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})

# CMake package. A static library hands what it links to its consumer; a shared one has linked it already.
set(clbvh_needs_tbb OFF)
set(clbvh_needs_assimp OFF)
if(NOT BUILD_SHARED_LIBS)
  set(clbvh_needs_tbb ON)
  if(TARGET assimp::assimp)
    set(clbvh_needs_assimp ON)
  endif()
endif()
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/clbvh-config.cmake.in
  ${PROJECT_BINARY_DIR}/package/clbvh-config.cmake
  INSTALL_DESTINATION ${clbvh_package_dir}
  NO_SET_AND_CHECK_MACRO)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/package/clbvh-config-version.cmake COMPATIBILITY SameMinorVersion)
install(EXPORT clbvh-targets NAMESPACE clbvh:: DESTINATION ${clbvh_package_dir})
install(FILES
  ${PROJECT_BINARY_DIR}/package/clbvh-config.cmake
  ${PROJECT_BINARY_DIR}/package/clbvh-config-version.cmake
  DESTINATION ${clbvh_package_dir})

# pkg-config files, relative to their own place. Where only static libraries exist, their private needs are everybody's.
set(clbvh_pc_requires OpenCL)
set(clbvh_eval_pc_requires "clbvh = ${PROJECT_VERSION}")
set(clbvh_io_pc_requires "clbvh = ${PROJECT_VERSION}")
if(clbvh_needs_tbb)
  string(APPEND clbvh_pc_requires ", tbb")
endif()
if(clbvh_needs_assimp)
  string(APPEND clbvh_io_pc_requires ", assimp")
endif()
file(RELATIVE_PATH clbvh_pc_prefix ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX})
string(REGEX REPLACE "/$" "" clbvh_pc_prefix ${clbvh_pc_prefix})
cmake_path(APPEND clbvh_pc_libdir "\${prefix}" ${CMAKE_INSTALL_LIBDIR})
cmake_path(APPEND clbvh_pc_includedir "\${prefix}" ${CMAKE_INSTALL_INCLUDEDIR})
foreach(name IN ITEMS clbvh clbvh-io clbvh-eval)
  configure_file(${CMAKE_CURRENT_LIST_DIR}/${name}.pc.in ${PROJECT_BINARY_DIR}/package/${name}.pc @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/package/${name}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
endforeach()
