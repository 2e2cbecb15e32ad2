# Fails where the folders that pkg-config and CONFIG, the CMake package, name do not hold EXPECTED.
set(ENV{PKG_CONFIG_PATH} ${PKG_CONFIG_DIR})
execute_process(COMMAND ${PKG_CONFIG} --variable=kerneldir clbvh
  OUTPUT_VARIABLE pkg_config_dir OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)

# The package's first lines set the folder; what follows needs a project.
file(READ ${CONFIG} config)
string(REGEX MATCH "set\\(clbvh_KERNEL_DIR [^\n]*" line "${config}")
cmake_path(GET CONFIG PARENT_PATH PACKAGE_PREFIX_DIR)
cmake_path(SET PACKAGE_PREFIX_DIR NORMALIZE ${PACKAGE_PREFIX_DIR}/../../..)
cmake_language(EVAL CODE "${line}")

foreach(folder IN ITEMS ${pkg_config_dir} ${clbvh_KERNEL_DIR})
  execute_process(COMMAND ${CMAKE_COMMAND} -E compare_files ${folder}/clbvh_trace.clh ${EXPECTED} COMMAND_ERROR_IS_FATAL ANY)
endforeach()
if(NOT clbvh_KERNEL_DIR)
  message(FATAL_ERROR "${CONFIG} sets no clbvh_KERNEL_DIR")
endif()
