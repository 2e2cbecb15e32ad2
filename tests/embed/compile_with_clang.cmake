# Fails where CLANG has to say anything about FILE, included by a program in this VERSION of OpenCL C.
set(switches_plain)
set(switches_triangles -DCLBVH_LAYOUT=compressed8 -DCLBVH_TRIANGLE_TEST=1 -DCLBVH_INDEX=ushort)
set(switches_hooks -DCLBVH_LAYOUT=pair -DCLBVH_ACCEPT_HIT=accept -DCLBVH_INTERSECT_PRIMITIVE=intersect)
foreach(target IN ITEMS spir64 nvptx64 amdgcn)
  foreach(switches IN ITEMS plain triangles hooks)
    execute_process(COMMAND ${CLANG} -x cl -cl-std=${VERSION} -target ${target} -Xclang -finclude-default-header
      -fsyntax-only -Wall -Wextra -Werror ${switches_${switches}} -include ${FILE} /dev/null
      COMMAND_ERROR_IS_FATAL ANY)
  endforeach()
endforeach()
