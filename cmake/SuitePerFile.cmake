# suite_per_file(TARGET PREFIX SOURCES...): a test of CTest for every *_test.cpp of TARGET, a program of Catch2's, which runs
# the cases of that file and names those that fail. A process per case would start OpenCL and load the same kernels
# hundreds of times. Catch2 knows files by their names alone, so no two may have the same.
function(suite_per_file target prefix)
  set(suites)
  foreach(source IN LISTS ARGN)
    if(source MATCHES "([^/]+_test)\\.cpp$")
      if(CMAKE_MATCH_1 IN_LIST suites)
        message(FATAL_ERROR "${target} has two files named ${CMAKE_MATCH_1}.cpp")
      endif()
      list(APPEND suites ${CMAKE_MATCH_1})
    endif()
  endforeach()
  set(environment POCL_AFFINITY=1)
  if(CLBVH_SANITIZE)
    # Without it, more memory than there is ends the program.
    list(APPEND environment ASAN_OPTIONS=allocator_may_return_null=1 UBSAN_OPTIONS=print_stacktrace=1)
  endif()
  foreach(suite IN LISTS suites)
    # Hidden cases, such as benchmarks, are run by hand. A file without a case is an error.
    add_test(NAME ${prefix}${suite} COMMAND ${target} --filenames-as-tags "[#${suite}]~[.]" --warn NoTests)
    set_tests_properties(${prefix}${suite} PROPERTIES ENVIRONMENT "${environment}" TIMEOUT 1800)
  endforeach()
endfunction()
