# Fails where Oclgrind does not report the faults of the kernels in PROGRAM.
include(${CMAKE_CURRENT_LIST_DIR}/oclgrind.cmake)

run_in_oclgrind(report ${PROGRAM})
foreach(fault IN ITEMS "Read-write data race at local memory" "Uninitialized value written to global memory")
  if(NOT report MATCHES "${fault}")
    message(FATAL_ERROR "Oclgrind missed: ${fault}. It reported:\n${report}")
  endif()
endforeach()
