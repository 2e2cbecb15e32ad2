// Trees over boxes of the caller's own, on the host: no mesh, no OpenCL device.

#include <clbvh/clbvh.hpp>
#include <cmath>
#include <iostream>
#include <vector>

int main() {
    // A spiral of boxes that grow.
    std::vector<clbvh::Aabb> boxes;
    for (int i = 0; i < 10000; ++i) {
        const float turn = 0.01f * static_cast<float>(i), size = 0.001f * static_cast<float>(i);
        const clbvh::Vec3 corner{turn * std::cos(turn), turn * std::sin(turn), turn};
        boxes.push_back({corner, {corner.x + size, corner.y + size, corner.z + size}});
    }
    try {
        const clbvh::Bvh sweep = clbvh::build_sweep_sah(boxes);
        const clbvh::Bvh clustered = clbvh::build_aac(boxes, clbvh::AacConfig::hq());
        std::cout << "SAH cost: sweep SAH " << clbvh::sah_cost(sweep) << ", AAC " << clbvh::sah_cost(clustered) << '\n';
        return 0;
    } catch (const clbvh::Error& error) {
        std::cerr << "host_boxes: " << error.what() << '\n';
        return 1;
    }
}
