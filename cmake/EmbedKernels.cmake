# clbvh_embed_kernels(OUTPUT FILES...): writes a C++ source with the text of every kernel file, so that the installed
# library needs no file at run time.
function(clbvh_embed_kernels output)
  add_custom_command(
    OUTPUT ${output}
    COMMAND ${CMAKE_COMMAND} "-DOUTPUT=${output}" "-DROOT=${PROJECT_SOURCE_DIR}" "-DFILES=${ARGN}"
      -P ${PROJECT_SOURCE_DIR}/cmake/embed_kernels.cmake
    DEPENDS ${ARGN} ${PROJECT_SOURCE_DIR}/cmake/embed_kernels.cmake
    COMMENT "Embedding kernels"
    VERBATIM)
endfunction()
