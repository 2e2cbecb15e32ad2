# `clbvh build` with OPTIONS and each optimizer that runs on devices.
include(${CMAKE_CURRENT_LIST_DIR}/run_each.cmake)
run_each(optimizers on_device ON
  ${CLBVH} build gen:soup:300 --builder lbvh --validate --optimize %id% --optimize-on device ${OPTIONS})
