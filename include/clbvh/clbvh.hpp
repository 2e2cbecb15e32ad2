#pragma once

/// Everything of libclbvh but file input and output, which live in clbvh/io/ and the library clbvh::io.

#include "clbvh/builder.hpp"
#include "clbvh/core/aabb.hpp"
#include "clbvh/core/build_options.hpp"
#include "clbvh/core/build_stats.hpp"
#include "clbvh/core/bvh.hpp"
#include "clbvh/core/error.hpp"
#include "clbvh/core/mesh.hpp"
#include "clbvh/core/validate.hpp"
#include "clbvh/device/context.hpp"
#include "clbvh/device/device.hpp"
#include "clbvh/metrics/sah.hpp"
#include "clbvh/registry.hpp"
