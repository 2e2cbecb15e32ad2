# How the libraries are made, of which kinds, and what they ask of their users.

# What the public headers ask of whoever includes them.
set(clbvh_definitions)
set(clbvh_packages)
if(CLBVH_WITH_OPENCL)
  set(clbvh_packages OpenCL::OpenCL)
else()
  set(clbvh_definitions CLBVH_NO_OPENCL)
endif()

if(NOT CLBVH_VECTORS)
  list(APPEND clbvh_definitions CLBVH_NO_VECTORS)
endif()

# The kind of library that is built. The tests of the installed package want the other one, too.
set(clbvh_kind STATIC)
set(clbvh_other_kind SHARED)
if(BUILD_SHARED_LIBS)
  set(clbvh_kind SHARED)
  set(clbvh_other_kind STATIC)
endif()
set(clbvh_builds_both_kinds OFF)
if(CLBVH_BUILD_TESTS AND CLBVH_INSTALL AND NOT CLBVH_SANITIZE)
  set(clbvh_builds_both_kinds ON)
endif()

add_library(clbvh_headers INTERFACE)
target_compile_features(clbvh_headers INTERFACE cxx_std_20)
target_compile_definitions(clbvh_headers INTERFACE ${clbvh_definitions})
target_include_directories(clbvh_headers INTERFACE ${PROJECT_SOURCE_DIR}/include)
target_link_libraries(clbvh_headers INTERFACE ${clbvh_packages})

# clbvh_objects(NAME SOURCES...): compiles them to NAME_objects.
function(clbvh_objects name)
  add_library(${name}_objects OBJECT ${ARGN})
  set_target_properties(${name}_objects PROPERTIES
    POSITION_INDEPENDENT_CODE ON
    CXX_VISIBILITY_PRESET hidden
    VISIBILITY_INLINES_HIDDEN ON)
  string(TOUPPER ${name}_EXPORTS exports)
  target_compile_definitions(${name}_objects PRIVATE ${exports})
  if(NOT BUILD_SHARED_LIBS AND NOT clbvh_builds_both_kinds)
    target_compile_definitions(${name}_objects PRIVATE CLBVH_STATIC)
  endif()
  target_include_directories(${name}_objects PRIVATE ${CMAKE_CURRENT_SOURCE_DIR} ${PROJECT_SOURCE_DIR})
  # Infinities and NaNs are part of the algorithms, whatever the flags of a project around this one say.
  target_compile_options(${name}_objects PRIVATE -fno-fast-math)
  target_link_libraries(${name}_objects PUBLIC clbvh_headers PRIVATE clbvh_flags)
endfunction()

# clbvh_library(NAME KIND SUFFIX EXPORT_NAME): makes NAME and SUFFIX a library, SHARED or STATIC, of NAME_objects.
function(clbvh_library name kind suffix export_name)
  set(target ${name}${suffix})
  add_library(${target} ${kind} $<TARGET_OBJECTS:${name}_objects>)
  set_target_properties(${target} PROPERTIES
    LINKER_LANGUAGE CXX
    OUTPUT_NAME ${name}
    EXPORT_NAME ${export_name}
    VERSION ${PROJECT_VERSION}
    SOVERSION 0)
  target_compile_features(${target} INTERFACE cxx_std_20)
  target_compile_definitions(${target} INTERFACE ${clbvh_definitions} $<$<STREQUAL:${kind},STATIC>:CLBVH_STATIC>)
  target_include_directories(${target} INTERFACE
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_link_libraries(${target} PRIVATE $<BUILD_INTERFACE:clbvh_flags>)
endfunction()

# clbvh_libraries(KIND SUFFIX): the three libraries.
function(clbvh_libraries kind suffix)
  clbvh_library(clbvh ${kind} "${suffix}" clbvh)
  target_link_libraries(clbvh${suffix} PUBLIC ${clbvh_packages} PRIVATE TBB::tbb)
  clbvh_library(clbvh_io ${kind} "${suffix}" io)
  target_link_libraries(clbvh_io${suffix} PUBLIC clbvh${suffix})
  if(TARGET assimp::assimp)
    target_link_libraries(clbvh_io${suffix} PRIVATE assimp::assimp)
  endif()
  clbvh_library(clbvh_eval ${kind} "${suffix}" eval)
  target_link_libraries(clbvh_eval${suffix} PUBLIC clbvh${suffix} PRIVATE TBB::tbb)
endfunction()
