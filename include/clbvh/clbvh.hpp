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
#include "clbvh/host/aac.hpp"
#include "clbvh/host/binned_sah.hpp"
#include "clbvh/host/collapse.hpp"
#include "clbvh/host/locally_ordered.hpp"
#include "clbvh/host/median.hpp"
#include "clbvh/host/presplit.hpp"
#include "clbvh/host/sbvh.hpp"
#include "clbvh/host/sweep_sah.hpp"
#include "clbvh/metrics/sah.hpp"
#include "clbvh/registry.hpp"
