#pragma once

#include "clbvh/clbvh.h"
#include "clbvh/core/mesh.hpp"

namespace clbvh::test {

/// A builder of the C interface, destroyed with this.
struct CBuilder {
    clbvh_builder* handle = nullptr;
    CBuilder() = default;
    CBuilder(const CBuilder&) = delete;
    CBuilder& operator=(const CBuilder&) = delete;
    ~CBuilder() { clbvh_destroy_builder(handle); }
};

inline clbvh_error build(clbvh_builder* builder, const Mesh& mesh) {
    return clbvh_build(builder, &mesh.vertices.data()->x, mesh.vertices.size(), mesh.triangles.data()->data(),
                       mesh.triangles.size());
}

}  // namespace clbvh::test
