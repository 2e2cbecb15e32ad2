# run_in_oclgrind(REPORT COMMAND...): runs COMMAND with Oclgrind's device as the only one. Fails where the command fails;
# what Oclgrind reported goes to the variable REPORT. CHECKS are options of Oclgrind, LOG is the file to use.
# One thread: with more, Oclgrind is no faster, and it finds races by what work items may do, not by what its threads did.
# More local memory than its 32 KiB: it adds up the local variables of all kernels of a program.
# Its check of uninitialised memory forgets a whole buffer where the host copies or fills a part of it; the library then
# looks faulty now and then, so it copies whole buffers, or leaves such work to kernels.
function(run_in_oclgrind report)
  file(REMOVE ${LOG})
  set(ENV{CLBVH_DEVICE} Oclgrind)
  set(ENV{CLBVH_CACHE} off)
  set(ENV{CLBVH_PROFILE} off)
  # It says that it is a GPU, whose self-test passes ten million messages: that takes it hours.
  if(NOT DEFINED ENV{CLBVH_HAND_OVER})
    set(ENV{CLBVH_HAND_OVER} within)
  endif()
  execute_process(COMMAND ${OCLGRIND} --num-threads 1 --local-mem-size 2097152 ${CHECKS} --log ${LOG} ${ARGN}
    OUTPUT_VARIABLE output ERROR_VARIABLE output RESULT_VARIABLE result)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${ARGN} ended with ${result} under Oclgrind:\n${output}")
  endif()
  if(NOT EXISTS ${LOG})
    message(FATAL_ERROR "${ARGN} ran, but not on Oclgrind's device:\n${output}")
  endif()
  file(READ ${LOG} text)
  set(${report} "${text}" PARENT_SCOPE)
endfunction()
