# Runs PROGRAM with ARGUMENTS, and fails where Oclgrind reports anything.
include(${CMAKE_CURRENT_LIST_DIR}/oclgrind.cmake)

run_in_oclgrind(report ${PROGRAM} ${ARGUMENTS})
if(report)
  message(FATAL_ERROR "Oclgrind has reports about ${PROGRAM} ${ARGUMENTS}:\n${report}")
endif()
