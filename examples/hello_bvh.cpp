// A mesh in, a tree and its cost out: hello_bvh [SCENE]

#include <clbvh/clbvh.hpp>
#include <clbvh/io/scene.hpp>
#include <iostream>

int main(int argc, char** argv) {
    try {
        const clbvh::Mesh mesh = clbvh::load_scene(argc > 1 ? argv[1] : "gen:sphere:20000");
        const clbvh::Bvh bvh = clbvh::build(mesh);
        const clbvh::ValidationReport report = clbvh::validate(bvh, mesh);
        std::cout << mesh.triangles.size() << " triangles, " << report.nodes << " nodes, depth " << report.depth
                  << ", SAH cost " << clbvh::sah_cost(bvh) << (report ? ", valid\n" : ", broken\n");
        return report ? 0 : 1;
    } catch (const clbvh::Error& error) {
        std::cerr << "hello_bvh: " << error.what() << '\n';
        return 1;
    }
}
