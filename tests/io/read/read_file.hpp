#pragma once

#include <catch2/catch.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "clbvh/io/scene.hpp"
#include "io/temp_folder.hpp"
#include "support/expect_error.hpp"

namespace clbvh::test {

/// Loads a file of that name and text.
inline Mesh load_text(std::string_view name, const std::string& text, LoadReport* report = nullptr) {
    const TempFolder folder;
    return load_scene(folder.write(name, text), {{}, report});
}

/// Checks that such a file is refused by an error of this code, which names the file and each part.
inline void expect_refused(ErrorCode code, std::string_view name, const std::string& text,
                           const std::vector<std::string>& parts) {
    const TempFolder folder;
    const std::string path = folder.write(name, text);
    INFO(text.substr(0, 1000));
    for (const std::string& part : parts)
        expect_error(code, {path, part}, [&] { (void)load_scene(path); });
}

/// The bytes of a value as they lie in memory.
template <typename T>
std::string bytes_of(const T& value) {
    return {reinterpret_cast<const char*>(&value), sizeof value};
}

/// The corners of all triangles, in order.
inline std::vector<Vec3> corners_of(const Mesh& mesh) {
    std::vector<Vec3> corners;
    for (const Triangle& triangle : mesh.triangles) {
        for (const std::uint32_t corner : triangle)
            corners.push_back(mesh.vertices.at(corner));
    }
    return corners;
}

}  // namespace clbvh::test
