# Files that are compiled for AVX2 define no function that the linker may choose for code of others: inline functions
# and templates have to be inlined there, or to be in an anonymous namespace, or to have avx2 in their name.
# cmake -DNM=nm -DOBJECTS=a.o,b.o -P check_symbols.cmake
string(REPLACE "," ";" OBJECTS "${OBJECTS}")
list(FILTER OBJECTS INCLUDE REGEX "_avx2\\.cpp")
if(NOT OBJECTS)
  message(FATAL_ERROR "there is no file that is compiled for AVX2")
endif()
foreach(object IN LISTS OBJECTS)
  execute_process(COMMAND ${NM} --demangle --defined-only ${object} OUTPUT_VARIABLE symbols COMMAND_ERROR_IS_FATAL ANY)
  string(REGEX MATCHALL "[^\n]* W [^\n]*" weak "${symbols}")
  list(FILTER weak EXCLUDE REGEX "avx2")
  if(weak)
    list(JOIN weak "\n" weak)
    message(FATAL_ERROR "${object} defines functions that code of other instruction sets may come to call:\n${weak}")
  endif()
endforeach()
