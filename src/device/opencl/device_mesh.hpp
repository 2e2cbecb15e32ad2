#pragma once

#include <cstdint>

#include "device/opencl/memory_block.hpp"
#include "kernels/build/build_constants.h"

namespace clbvh::device {

/// How primitives lie in memory; see kernels/build/build_constants.h.
enum class InputForm : std::uint8_t {
    tight = kernels::INPUT_TIGHT,
    indexed_32 = kernels::INPUT_INDEXED_32,
    indexed_16 = kernels::INPUT_INDEXED_16,
    triangles = kernels::INPUT_TRIANGLES,
    boxes = kernels::INPUT_BOXES,
};

/// Primitives in device memory. Sizes and strides are in bytes.
struct DeviceMesh {
    Block vertices;  ///< Triangles: float[3] each; boxes: float[6] each.
    Block indices;   ///< Three a triangle, where the form has them; else without a buffer.
    std::uint32_t primitive_count = 0;
    std::uint32_t active_count = 0;  ///< Primitives without a NaN, the leaves of the tree; or as many as there may be.
    InputForm form = InputForm::tight;
    std::uint32_t vertex_stride = 0, index_stride = 0;  ///< Not used by the tight form.

    /// A buffer for kernels, none of which is given a null one: where there are no indices they are not read.
    [[nodiscard]] const cl::Buffer& index_buffer() const {
        return indices.is_there() ? indices.buffer : vertices.buffer;
    }
};

}  // namespace clbvh::device
