// Watching a build, stopping it in the middle, and building again with the same builder.

#include <clbvh/clbvh.hpp>
#include <cstdint>
#include <iostream>
#include <string>

namespace {

// A row of `count` triangles.
clbvh::Mesh make_row(std::uint32_t count) {
    clbvh::Mesh mesh;
    for (std::uint32_t i = 0; i < count; ++i) {
        const auto x = static_cast<float>(i);
        mesh.vertices.insert(mesh.vertices.end(), {{x, 0.0F, 0.0F}, {x + 1.0F, 0.0F, 0.0F}, {x, 1.0F, 0.0F}});
        mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    return mesh;
}

}  // namespace

int main() {
    try {
        bool may_finish = false;
        std::string last_stage;
        clbvh::BuildOptions options;
        options.progress = [&](const clbvh::Progress& progress) {
            if (progress.stage != last_stage) {
                last_stage = progress.stage;
                std::cout << static_cast<int>(100.0 * progress.fraction) << "% done, now: " << progress.stage << '\n';
            }
            return may_finish || progress.stage != "cluster";
        };
        clbvh::Builder builder("plocpp", options);
        const clbvh::Mesh mesh = make_row(50000);
        try {
            const clbvh::Bvh unexpected = builder.build(mesh);
            std::cerr << "progress: the build was not stopped\n";
            return 1;
        } catch (const clbvh::Error& error) {
            if (error.code() != clbvh::ErrorCode::cancelled) {
                throw;
            }
            std::cout << "stopped: " << error.what() << '\n';
        }
        may_finish = true;
        const clbvh::Bvh bvh = builder.build(mesh);
        return clbvh::validate(bvh, mesh) ? 0 : 1;
    } catch (const clbvh::Error& error) {
        std::cerr << "progress: " << error.what() << '\n';
        return 1;
    }
}
