// A C++ program that makes a mesh, builds a tree on the host, and catches what the two libraries throw.
#include <clbvh/clbvh.hpp>
#include <clbvh/io/scene.hpp>
#include <exception>
#include <iostream>

namespace {

/// The code of the error that `action` throws, caught as clbvh::Error.
template <typename Action>
clbvh::ErrorCode code_of(Action&& action) {
    try {
        action();
    } catch (const clbvh::Error& error) {
        return error.code();
    }
    return clbvh::ErrorCode::cancelled;
}

}  // namespace

int main() {
    const clbvh::Mesh mesh = clbvh::generate_scene("soup", 1000);
    clbvh::Builder builder("sweep-sah");
    const clbvh::ValidationReport report = clbvh::validate(builder.build(mesh), mesh);
    const clbvh::ErrorCode of_core = code_of([] { static_cast<void>(clbvh::find_builder("none")); });
    const clbvh::ErrorCode of_io = code_of([] { static_cast<void>(clbvh::load_scene("gen:none")); });
    std::cout << report.nodes << " nodes, version " << clbvh_version_string() << '\n';
    return report && of_core == clbvh::ErrorCode::invalid_input && of_io == clbvh::ErrorCode::invalid_input ? 0 : 1;
}
