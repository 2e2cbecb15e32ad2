#include "io/read/gltf_nodes.hpp"

#include <algorithm>
#include <cmath>
#include <string>

namespace clbvh::io {
namespace {

using Json = GltfDocument::Json;

constexpr std::uint32_t kNoParent = 0xFFFFFFFFU;

template <std::size_t Size>
std::array<double, Size> array_of(const std::vector<double>& numbers, const std::array<double, Size>& missing) {
    std::array<double, Size> result = missing;
    std::ranges::copy(numbers, result.begin());
    return result;
}

Affine local_map(const GltfDocument& document, std::uint64_t index) {
    const std::string place = gltf_place("nodes", index);
    const Json& node = document.element("nodes", index, place);
    const std::vector<double> matrix = document.numbers(node, "matrix", 16, place);
    if (!matrix.empty()) {
        if (matrix[3] != 0.0 || matrix[7] != 0.0 || matrix[11] != 0.0 || matrix[15] != 1.0)
            document.fail(place + ".matrix", "it is not affine");
        return affine_of_columns(matrix.data());
    }
    return affine_of(array_of<3>(document.numbers(node, "translation", 3, place), {0.0, 0.0, 0.0}),
                     array_of<4>(document.numbers(node, "rotation", 4, place), {0.0, 0.0, 0.0, 1.0}),
                     array_of<3>(document.numbers(node, "scale", 3, place), {1.0, 1.0, 1.0}));
}

/// The indices of nodes in an array of an object.
std::vector<std::uint32_t> node_list(const GltfDocument& document, const Json& object, const char* name,
                                     const std::string& place) {
    std::vector<std::uint32_t> result;
    const Json* const array = document.find(object, name, Json::value_t::array, place);
    if (array == nullptr) return result;
    for (const Json& index : *array) {
        if (!index.is_number_unsigned() || index.get<std::uint64_t>() >= document.count("nodes")) {
            document.fail(place + '.' + name, "node " + index.dump().substr(0, 40) + " does not exist; the file has " +
                                                  std::to_string(document.count("nodes")));
        }
        result.push_back(index.get<std::uint32_t>());
    }
    return result;
}

class NodePlacer {
public:
    explicit NodePlacer(const GltfDocument& document)
        : document_(document), count_(document.count("nodes")), parents_(count_, kNoParent), children_(count_) {
        for (std::uint32_t node = 0; node < count_; ++node) {
            children_[node] =
                node_list(document, document.element("nodes", node, "nodes"), "children", gltf_place("nodes", node));
            for (const std::uint32_t child : children_[node]) {
                if (parents_[child] != kNoParent) {
                    document.fail(gltf_place("nodes", child), "it is a child of " +
                                                                  gltf_place("nodes", parents_[child]) + " and of " +
                                                                  gltf_place("nodes", node));
                }
                parents_[child] = node;
            }
        }
    }

    GltfNodes place() {
        GltfNodes result;
        result.to_world.resize(count_);
        std::vector<std::uint32_t> roots;
        for (std::uint32_t node = 0; node < count_; ++node) {
            if (parents_[node] == kNoParent) roots.push_back(node);
        }
        const std::vector<std::uint32_t> all = below(roots);
        // Below no root is what is below itself.
        if (all.size() < count_) {
            std::vector<bool> is_reached(count_, false);
            for (const std::uint32_t node : all)
                is_reached[node] = true;
            const auto lost = std::ranges::find(is_reached, false) - is_reached.begin();
            document_.fail(gltf_place("nodes", static_cast<std::uint64_t>(lost)), "it is its own ancestor");
        }
        for (const std::uint32_t node : all) {
            const Affine local = local_map(document_, node);
            const std::uint32_t parent = parents_[node];
            result.to_world[node] = parent != kNoParent ? result.to_world[parent] * local : local;
        }
        result.visited = below(shown(roots));
        return result;
    }

private:
    /// The nodes from which the file's scene begins.
    [[nodiscard]] std::vector<std::uint32_t> shown(const std::vector<std::uint32_t>& roots) const {
        const std::size_t scenes = document_.count("scenes");
        const std::uint64_t scene = document_.whole(document_.root(), "scene", "the file", 0);
        if (scenes == 0) return roots;
        const std::string place = gltf_place("scenes", scene);
        return node_list(document_, document_.element("scenes", scene, "scene"), "nodes", place);
    }

    [[nodiscard]] std::vector<std::uint32_t> below(const std::vector<std::uint32_t>& roots) const {
        std::vector<std::uint32_t> result, open(roots.rbegin(), roots.rend());
        std::vector<bool> is_seen(count_, false);
        while (!open.empty()) {
            const std::uint32_t node = open.back();
            open.pop_back();
            if (is_seen[node]) continue;
            is_seen[node] = true;
            result.push_back(node);
            open.insert(open.end(), children_[node].rbegin(), children_[node].rend());
        }
        return result;
    }

    const GltfDocument& document_;
    std::size_t count_;
    std::vector<std::uint32_t> parents_;
    std::vector<std::vector<std::uint32_t>> children_;
};

}  // namespace

Affine operator*(const Affine& outer, const Affine& inner) {
    Affine result;
    for (std::size_t row = 0; row < 3; ++row) {
        for (std::size_t column = 0; column < 4; ++column) {
            double sum = column == 3 ? outer.rows[row][3] : 0.0;
            for (std::size_t i = 0; i < 3; ++i)
                sum += outer.rows[row][i] * inner.rows[i][column];
            result.rows[row][column] = sum;
        }
    }
    return result;
}

std::array<double, 3> Affine::operator()(const std::array<double, 3>& point) const {
    std::array<double, 3> result{};
    for (std::size_t row = 0; row < 3; ++row)
        result[row] = rows[row][0] * point[0] + rows[row][1] * point[1] + rows[row][2] * point[2] + rows[row][3];
    return result;
}

bool Affine::mirrors() const {
    const auto& [x, y, z] = rows;
    const double determinant =
        x[0] * (y[1] * z[2] - y[2] * z[1]) - x[1] * (y[0] * z[2] - y[2] * z[0]) + x[2] * (y[0] * z[1] - y[1] * z[0]);
    return determinant < 0.0;
}

Affine affine_of(const std::array<double, 3>& translation, const std::array<double, 4>& rotation,
                 const std::array<double, 3>& scale) {
    const auto [x, y, z, w] = rotation;
    const double squared = x * x + y * y + z * z + w * w, two = squared > 0.0 ? 2.0 / squared : 0.0;
    const std::array<std::array<double, 3>, 3> turned{
        {{1 - two * (y * y + z * z), two * (x * y - z * w), two * (x * z + y * w)},
         {two * (x * y + z * w), 1 - two * (x * x + z * z), two * (y * z - x * w)},
         {two * (x * z - y * w), two * (y * z + x * w), 1 - two * (x * x + y * y)}}};
    Affine result;
    for (std::size_t row = 0; row < 3; ++row) {
        for (std::size_t column = 0; column < 3; ++column)
            result.rows[row][column] = turned[row][column] * scale[column];
        result.rows[row][3] = translation[row];
    }
    return result;
}

Affine affine_of_columns(const double* columns) {
    Affine result;
    for (std::size_t row = 0; row < 3; ++row) {
        for (std::size_t column = 0; column < 4; ++column)
            result.rows[row][column] = columns[4 * column + row];
    }
    return result;
}

GltfNodes place_nodes(const GltfDocument& document) {
    return NodePlacer(document).place();
}

}  // namespace clbvh::io
