// glTF 2.0 (Khronos Group 2021, "glTF 2.0 Specification", version 2.0.1) as geometry. An own reader over a JSON
// library: the glTF readers at hand take indices on trust, walk nodes by recursion, or expand URIs by a shell.
#include "io/read/gltf.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "clbvh/core/error.hpp"
#include "clbvh/core/primitives.hpp"
#include "io/read/gltf_accessor.hpp"
#include "io/read/gltf_document.hpp"
#include "io/read/gltf_nodes.hpp"
#include "io/read/words.hpp"

namespace clbvh::io {
namespace {

using Json = GltfDocument::Json;
using Position = std::array<double, 3>;

/// The modes of primitives.
enum class Mode : std::uint64_t { line_strip = 3, triangles, triangle_strip, triangle_fan };

/// A skin: what each joint makes of a vertex.
using Skin = std::vector<Affine>;

class GltfReader {
public:
    GltfReader(std::string_view text, const std::filesystem::path& folder, MeshSink& sink)
        : document_(text, folder, sink), sink_(sink) {}

    void read() {
        const bool has_nodes = document_.count("nodes") > 0;
        nodes_ = place_nodes(document_);
        sink_.report.instances = 0;
        for (const std::uint32_t node : nodes_.visited)
            read_node(node);
        for (std::uint64_t mesh = 0; !has_nodes && mesh < document_.count("meshes"); ++mesh)
            place_mesh({mesh, {}, nullptr}, Affine{});
        sink_.report.meshes = meshes_.size();
    }

private:
    /// A mesh as a node has it.
    struct PlacedMesh {
        std::uint64_t index;
        std::vector<double> weights;  ///< Of the node; empty: those of the mesh.
        const Skin* skin;             ///< Or null.
    };

    void read_node(std::uint32_t index) {
        const std::string place = gltf_place("nodes", index);
        const Json& node = document_.element("nodes", index, place);
        if (!node.contains("mesh")) return;
        PlacedMesh mesh{document_.whole(node, "mesh", place), {}, nullptr};
        if (const Json* const weights = document_.find(node, "weights", Json::value_t::array, place))
            mesh.weights = document_.numbers(node, "weights", weights->size(), place);
        if (node.contains("skin")) {
            // The skin's joints stand in the world; where the node stands does not matter.
            const Skin skin = read_skin(document_.whole(node, "skin", place), place);
            mesh.skin = &skin;
            place_mesh(mesh, Affine{});
            return;
        }
        for (const Affine& instance : instances_of(node, place))
            place_mesh(mesh, nodes_.to_world[index] * instance);
    }

    /// Those of EXT_mesh_gpu_instancing; of other nodes one that changes nothing.
    [[nodiscard]] std::vector<Affine> instances_of(const Json& node, const std::string& place) const {
        const Json* const extensions = document_.find(node, "extensions", Json::value_t::object, place);
        const char* const name = "EXT_mesh_gpu_instancing";
        const Json* const extension =
            extensions != nullptr ? document_.find(*extensions, name, Json::value_t::object, place) : nullptr;
        if (extension == nullptr) return {Affine{}};
        const std::string where = place + ".extensions." + name;
        const Json* const attributes = document_.find(*extension, "attributes", Json::value_t::object, where);
        if (attributes == nullptr) document_.fail(where, "\"attributes\" is missing");
        std::optional<std::size_t> count;
        const auto read = [&](const char* attribute, const char* type) -> std::optional<GltfValues> {
            if (!attributes->contains(attribute)) return std::nullopt;
            GltfValues values = read_accessor(document_, document_.whole(*attributes, attribute, where), type, where);
            if (count.value_or(values.count) != values.count) document_.fail(where, "attributes of different counts");
            count = values.count;
            return values;
        };
        const auto translations = read("TRANSLATION", "VEC3"), rotations = read("ROTATION", "VEC4"),
                   scales = read("SCALE", "VEC3");
        std::vector<Affine> result(count.value_or(0));
        for (std::size_t i = 0; i < result.size(); ++i) {
            const auto three = [i](const std::optional<GltfValues>& values, double missing) {
                if (!values) return Position{missing, missing, missing};
                return Position{values->numbers[3 * i], values->numbers[3 * i + 1], values->numbers[3 * i + 2]};
            };
            std::array<double, 4> rotation{0.0, 0.0, 0.0, 1.0};
            if (rotations)
                std::copy_n(rotations->numbers.begin() + static_cast<std::ptrdiff_t>(4 * i), 4, rotation.begin());
            result[i] = affine_of(three(translations, 0.0), rotation, three(scales, 1.0));
        }
        return result;
    }

    [[nodiscard]] Skin read_skin(std::uint64_t index, const std::string& from) const {
        const Json& skin = document_.element("skins", index, from);
        const std::string place = gltf_place("skins", index);
        const Json* const joints = document_.find(skin, "joints", Json::value_t::array, place);
        if (joints == nullptr) document_.fail(place, "\"joints\" is missing");
        std::optional<GltfValues> inverses;
        if (skin.contains("inverseBindMatrices")) {
            inverses = read_accessor(document_, document_.whole(skin, "inverseBindMatrices", place), "MAT4", place);
            if (inverses->count < joints->size()) document_.fail(place, "there are more joints than matrices");
        }
        Skin result;
        for (const Json& joint : *joints) {
            if (!joint.is_number_unsigned() || joint.get<std::uint64_t>() >= nodes_.to_world.size())
                document_.fail(place + ".joints", "node " + joint.dump().substr(0, 40) + " does not exist");
            const Affine inverse =
                inverses ? affine_of_columns(inverses->numbers.data() + 16 * result.size()) : Affine{};
            result.push_back(nodes_.to_world[joint.get<std::size_t>()] * inverse);
        }
        return result;
    }

    void place_mesh(const PlacedMesh& placed, const Affine& to_world) {
        const Json& mesh = document_.element("meshes", placed.index, "a node");
        const std::string place = gltf_place("meshes", placed.index);
        const Json* const primitives = document_.find(mesh, "primitives", Json::value_t::array, place);
        if (primitives == nullptr) document_.fail(place, "\"primitives\" is missing");
        std::vector<double> weights = placed.weights;
        if (const Json* const own = document_.find(mesh, "weights", Json::value_t::array, place);
            own != nullptr && weights.empty())
            weights = document_.numbers(mesh, "weights", own->size(), place);
        meshes_.insert(placed.index);
        ++sink_.report.instances;
        std::map<std::string, std::uint32_t> placed_vertices;  // primitives often share them
        const std::size_t first = sink_.mesh.triangles.size();
        for (std::size_t i = 0; i < primitives->size(); ++i) {
            const std::string where = place + '.' + gltf_place("primitives", i);
            if (!(*primitives)[i].is_object()) document_.fail(where, "it is no object");
            read_primitive((*primitives)[i], where, weights, placed.skin, to_world, placed_vertices);
        }
        // The front of a mirrored triangle is where its corners run clockwise.
        for (std::size_t i = first; to_world.mirrors() && i < sink_.mesh.triangles.size(); ++i)
            std::swap(sink_.mesh.triangles[i][1], sink_.mesh.triangles[i][2]);
    }

    void read_primitive(const Json& primitive, const std::string& place, const std::vector<double>& weights,
                        const Skin* skin, const Affine& to_world, std::map<std::string, std::uint32_t>& placed) {
        const std::uint64_t mode =
            document_.whole(primitive, "mode", place, static_cast<std::uint64_t>(Mode::triangles));
        if (mode > static_cast<std::uint64_t>(Mode::triangle_fan))
            document_.fail(place + ".mode", std::to_string(mode) + " is none");
        if (mode <= static_cast<std::uint64_t>(Mode::line_strip)) {
            ++sink_.report.points_and_lines;
            return;
        }
        const Json* const attributes = document_.find(primitive, "attributes", Json::value_t::object, place);
        if (attributes == nullptr || !attributes->contains("POSITION")) return;  // as the format says
        const std::uint64_t positions = document_.whole(*attributes, "POSITION", place);
        const std::string accessor = gltf_place("accessors", positions);
        const std::size_t count = document_.whole(document_.element("accessors", positions, place), "count", accessor);
        // All that the places of vertices depend on.
        std::string key = std::to_string(positions);
        if (skin != nullptr) key += attributes->dump();
        if (const auto targets = primitive.find("targets"); targets != primitive.end()) key += targets->dump();
        const auto [known, is_new] = placed.try_emplace(key, 0);
        if (is_new) {
            sink_.require_room(count, 0);
            known->second = static_cast<std::uint32_t>(sink_.mesh.vertices.size());
            for (const Position& point : points_of(primitive, *attributes, place, weights, skin)) {
                const Position at = to_world(point);
                sink_.add_vertex({static_cast<float>(at[0]), static_cast<float>(at[1]), static_cast<float>(at[2])});
                sink_.tick_item();
            }
        }
        add_triangles(static_cast<Mode>(mode), indices_of(primitive, place, count), known->second, place);
    }

    /// Where the vertices of a primitive are, morphed and skinned.
    [[nodiscard]] std::vector<Position> points_of(const Json& primitive, const Json& attributes,
                                                  const std::string& place, const std::vector<double>& weights,
                                                  const Skin* skin) {
        const GltfValues& base = positions_of(document_.whole(attributes, "POSITION", place), place);
        std::vector<Position> points(base.count);
        for (std::size_t i = 0; i < points.size(); ++i)
            points[i] = {base.numbers[3 * i], base.numbers[3 * i + 1], base.numbers[3 * i + 2]};
        const Json* const targets = document_.find(primitive, "targets", Json::value_t::array, place);
        for (std::size_t i = 0; targets != nullptr && i < std::min(targets->size(), weights.size()); ++i) {
            const Json& target = (*targets)[i];
            const std::string where = place + '.' + gltf_place("targets", i);
            if (!target.is_object() || !target.contains("POSITION") || weights[i] == 0.0) continue;
            const GltfValues moves =
                read_accessor(document_, document_.whole(target, "POSITION", where), "VEC3", where);
            if (moves.count != points.size()) document_.fail(where, "it has another number of vertices");
            for (std::size_t k = 0; k < moves.numbers.size(); ++k)
                points[k / 3][k % 3] += weights[i] * moves.numbers[k];
        }
        if (skin != nullptr) apply(*skin, attributes, place, points);
        return points;
    }

    /// Instances of a mesh ask for the same accessor again: the last one is kept.
    [[nodiscard]] const GltfValues& positions_of(std::uint64_t accessor, const std::string& place) {
        if (!last_ || last_->first != accessor)
            last_.emplace(accessor, read_accessor(document_, accessor, "VEC3", place));
        return last_->second;
    }

    /// Linear blend skinning: a vertex is the weighted mean of where its joints put it.
    void apply(const Skin& skin, const Json& attributes, const std::string& place,
               std::vector<Position>& points) const {
        std::vector<Position> result(points.size(), Position{0.0, 0.0, 0.0});
        for (int set = 0; attributes.contains("JOINTS_" + std::to_string(set)); ++set) {
            const std::string joints_name = "JOINTS_" + std::to_string(set),
                              weights_name = "WEIGHTS_" + std::to_string(set);
            const GltfValues joints =
                read_accessor(document_, document_.whole(attributes, joints_name.c_str(), place), "VEC4", place);
            const GltfValues weights =
                read_accessor(document_, document_.whole(attributes, weights_name.c_str(), place), "VEC4", place);
            if (joints.count != points.size() || weights.count != points.size())
                document_.fail(place, joints_name + " or " + weights_name + " has another number of vertices");
            for (std::size_t k = 0; k < 4 * points.size(); ++k) {
                if (weights.numbers[k] == 0.0) continue;
                if (!(joints.numbers[k] >= 0.0 && joints.numbers[k] < static_cast<double>(skin.size())))
                    document_.fail(place + '.' + joints_name,
                                   "vertex " + std::to_string(k / 4) + ": the joint does not exist");
                const Position at = skin[static_cast<std::size_t>(joints.numbers[k])](points[k / 4]);
                for (std::size_t axis = 0; axis < 3; ++axis)
                    result[k / 4][axis] += weights.numbers[k] * at[axis];
            }
        }
        if (!attributes.contains("JOINTS_0")) document_.fail(place, "its node has a skin, but it has no JOINTS_0");
        points = std::move(result);
    }

    [[nodiscard]] std::vector<std::uint32_t> indices_of(const Json& primitive, const std::string& place,
                                                        std::size_t vertices) const {
        std::vector<std::uint32_t> result;
        if (!primitive.contains("indices")) {
            for (std::size_t i = 0; i < vertices; ++i)
                result.push_back(static_cast<std::uint32_t>(i));
            return result;
        }
        const std::uint64_t accessor = document_.whole(primitive, "indices", place);
        const GltfValues values = read_accessor(document_, accessor, "SCALAR", place + ".indices");
        result.reserve(values.count);
        for (std::size_t i = 0; i < values.count; ++i) {
            const double index = values.numbers[i];
            if (!(index >= 0.0 && index < static_cast<double>(vertices) && index == std::floor(index))) {
                document_.fail(place + ".indices", "element " + std::to_string(i) + ": vertex " + number_text(index) +
                                                       " does not exist; there are " + std::to_string(vertices));
            }
            result.push_back(static_cast<std::uint32_t>(index));
        }
        return result;
    }

    void add_triangles(Mode mode, std::vector<std::uint32_t> indices, std::uint32_t first, const std::string& place) {
        for (std::uint32_t& index : indices)
            index += first;
        if (sink_.mesh.triangles.size() + indices.size() > kMaxPrimitives)
            throw Error(ErrorCode::unsupported,
                        sink_.name() + ": too many triangles; the most are " + std::to_string(kMaxPrimitives));
        sink_.require_room(0, mode == Mode::triangles ? indices.size() / 3 : indices.size());
        if (mode == Mode::triangle_strip) return sink_.add_strip(indices);
        if (mode == Mode::triangles && indices.size() % 3 != 0) {
            document_.fail(place, std::to_string(indices.size()) + " indices are no triangles: the number must be a " +
                                      "multiple of three");
        }
        for (std::size_t i = 2; i < indices.size(); ++i) {
            if (mode == Mode::triangle_fan) {
                sink_.add_triangle(indices[i - 1], indices[i], indices[0]);
            } else if (i % 3 == 2) {
                sink_.add_triangle(indices[i - 2], indices[i - 1], indices[i]);
            }
            sink_.tick_item();
        }
    }

    GltfDocument document_;
    MeshSink& sink_;
    GltfNodes nodes_;
    std::set<std::uint64_t> meshes_;
    std::optional<std::pair<std::uint64_t, GltfValues>> last_;
};

}  // namespace

void read_gltf(std::string_view text, const std::filesystem::path& folder, MeshSink& sink) {
    GltfReader(text, folder, sink).read();
}

}  // namespace clbvh::io
