# clbvh_embed_kernels(OUTPUT FILES...): writes a C++ source with the text of every kernel file, so that the installed
# library needs no file at run time.
function(clbvh_embed_kernels output)
  add_custom_command(
    OUTPUT ${output}
    COMMAND ${CMAKE_COMMAND} "-DOUTPUT=${output}" "-DROOT=${PROJECT_SOURCE_DIR}" "-DFILES=${ARGN}"
      -P ${PROJECT_SOURCE_DIR}/cmake/embed_kernels.cmake
    DEPENDS ${ARGN} ${PROJECT_SOURCE_DIR}/cmake/embed_kernels.cmake ${PROJECT_SOURCE_DIR}/cmake/raw_string.cmake
    COMMENT "Embedding kernels"
    VERBATIM)
endfunction()

# clbvh_embed_trace(OUTPUT TEXT FILE PARTS...): writes TEXT, which is FILE with the PARTS that it includes in their places, and
# the C++ source of clbvh::embed_source(), which returns it.
function(clbvh_embed_trace output text file)
  add_custom_command(
    OUTPUT ${output} ${text}
    COMMAND ${CMAKE_COMMAND} "-DOUTPUT=${output}" "-DTEXT=${text}" "-DFILE=${file}"
      -P ${PROJECT_SOURCE_DIR}/cmake/embed_trace.cmake
    DEPENDS ${file} ${ARGN} ${PROJECT_SOURCE_DIR}/cmake/embed_trace.cmake ${PROJECT_SOURCE_DIR}/cmake/raw_string.cmake
    COMMENT "Embedding the kernel code for callers"
    VERBATIM)
endfunction()
