# `clbvh build` with OPTIONS for every device builder.
include(${CMAKE_CURRENT_LIST_DIR}/run_each.cmake)
run_each(builders kind device ${CLBVH} build gen:soup:600 --builder %id% --validate ${OPTIONS})
