#include "io/read/gltf_accessor.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <string_view>
#include <utility>

#include "io/read/words.hpp"

namespace clbvh::io {
namespace {

using Json = GltfDocument::Json;

/// How a component is stored; the values are those of the format.
enum class Component : std::uint64_t { int8 = 5120, uint8, int16, uint16, uint32 = 5125, float32 };

std::size_t size_of(Component component) {
    switch (component) {
        case Component::int8:
        case Component::uint8: return 1;
        case Component::int16:
        case Component::uint16: return 2;
        case Component::uint32:
        case Component::float32: return 4;
    }
    return 0;
}

template <typename T>
double load(const char* from, double most) {
    T value;
    std::array<char, sizeof(T)> bytes{};
    std::memcpy(bytes.data(), from, sizeof(T));
    if constexpr (std::endian::native == std::endian::big) std::ranges::reverse(bytes);
    std::memcpy(&value, bytes.data(), sizeof(T));
    return most > 0.0 ? std::max(static_cast<double>(value) / most, -1.0) : static_cast<double>(value);
}

double load(Component component, const char* from, bool is_normalized) {
    switch (component) {
        case Component::int8: return load<std::int8_t>(from, is_normalized ? 127.0 : 0.0);
        case Component::uint8: return load<std::uint8_t>(from, is_normalized ? 255.0 : 0.0);
        case Component::int16: return load<std::int16_t>(from, is_normalized ? 32767.0 : 0.0);
        case Component::uint16: return load<std::uint16_t>(from, is_normalized ? 65535.0 : 0.0);
        case Component::uint32: return load<std::uint32_t>(from, 0.0);
        case Component::float32: return load<float>(from, 0.0);
    }
    return 0.0;
}

class AccessorReader {
public:
    AccessorReader(const GltfDocument& document, std::uint64_t index, const char* type, const std::string& from)
        : document_(document),
          accessor_(document.element("accessors", index, from)),
          place_(gltf_place("accessors", index)) {
        const Json* const given = document.find(accessor_, "type", Json::value_t::string, place_);
        if (given == nullptr || *given != type) {
            document.fail(from,
                          place_ + " is of type " + (given != nullptr ? given->dump() : "none") + ", not " + type);
        }
        constexpr std::array<std::pair<std::string_view, std::size_t>, 4> kTypes{
            {{"SCALAR", 1}, {"VEC3", 3}, {"VEC4", 4}, {"MAT4", 16}}};
        const auto* const found =
            std::ranges::find(kTypes, std::string_view(type), &std::pair<std::string_view, std::size_t>::first);
        values_.components = found->second;
        component_ = component(document.whole(accessor_, "componentType", place_), place_);
        const auto normalized = accessor_.find("normalized");
        is_normalized_ = normalized != accessor_.end() && normalized->is_boolean() && normalized->get<bool>();
        values_.count = document.whole(accessor_, "count", place_);
    }

    GltfValues read() {
        const Json* const sparse = document_.find(accessor_, "sparse", Json::value_t::object, place_);
        if (accessor_.contains("bufferView")) {
            read_base();
        } else if (sparse != nullptr) {
            fill_with_zeros();
        } else {
            document_.fail(place_, "it has no bufferView: are its values left to an extension?");
        }
        if (sparse != nullptr) replace(*sparse);
        return std::move(values_);
    }

private:
    [[nodiscard]] Component component(std::uint64_t value, const std::string& place) const {
        const auto component = static_cast<Component>(value);
        if (size_of(component) == 0) document_.fail(place + ".componentType", std::to_string(value) + " is none");
        return component;
    }

    /// The bytes of `count` elements of that size in a buffer view, from `offset` in it; `stride` becomes the bytes
    /// from one to the next.
    [[nodiscard]] const char* elements(std::uint64_t view, std::uint64_t offset, std::uint64_t count, std::size_t bytes,
                                       const std::string& place, std::size_t& stride) const {
        const GltfDocument::Bytes found = document_.view(view, place);
        stride = found.stride != 0 ? found.stride : bytes;
        if (stride < bytes) {
            document_.fail(place, gltf_place("bufferViews", view) + ".byteStride is " + std::to_string(stride) +
                                      ", less than the " + std::to_string(bytes) + " bytes of an element");
        }
        if (count == 0) return found.bytes.data();
        const std::uint64_t size = found.bytes.size();
        if (offset > size || bytes > size - offset || (count - 1) > (size - offset - bytes) / stride) {
            document_.fail(place, std::to_string(count) + " elements from byte " + std::to_string(offset) +
                                      " do not fit into bufferViews[" + std::to_string(view) + "], which has " +
                                      std::to_string(size) + " bytes");
        }
        return found.bytes.data() + offset;
    }

    void read_base() {
        const std::size_t bytes = values_.components * size_of(component_);
        std::size_t stride = 0;
        const char* const first =
            elements(document_.whole(accessor_, "bufferView", place_),
                     document_.whole(accessor_, "byteOffset", place_, 0), values_.count, bytes, place_, stride);
        values_.numbers.reserve(values_.count * values_.components);
        for (std::size_t i = 0; i < values_.count; ++i) {
            for (std::size_t c = 0; c < values_.components; ++c)
                values_.numbers.push_back(number(first + i * stride, c));
        }
    }
    [[nodiscard]] double number(const char* element, std::size_t c) const {
        return load(component_, element + c * size_of(component_), is_normalized_);
    }

    /// Nothing in the file has to be as large as that: the count is bounded by what there is.
    void fill_with_zeros() {
        if (values_.count > document_.bytes()) {
            document_.fail(place_ + ".count", std::to_string(values_.count) + " elements, more than the buffers have " +
                                                  "bytes, and no bufferView");
        }
        values_.numbers.assign(values_.count * values_.components, 0.0);
    }

    void replace(const Json& sparse) {
        const std::string place = place_ + ".sparse";
        const std::uint64_t count = document_.whole(sparse, "count", place);
        const Json* const indices = document_.find(sparse, "indices", Json::value_t::object, place);
        const Json* const values = document_.find(sparse, "values", Json::value_t::object, place);
        if (indices == nullptr || values == nullptr) document_.fail(place, "\"indices\" or \"values\" is missing");
        const Component type =
            component(document_.whole(*indices, "componentType", place + ".indices"), place + ".indices");
        std::size_t index_stride = 0, value_stride = 0;
        const char* const index_begin = elements(document_.whole(*indices, "bufferView", place + ".indices"),
                                                 document_.whole(*indices, "byteOffset", place, 0), count,
                                                 size_of(type), place + ".indices", index_stride);
        const char* const value_begin = elements(
            document_.whole(*values, "bufferView", place + ".values"), document_.whole(*values, "byteOffset", place, 0),
            count, values_.components * size_of(component_), place + ".values", value_stride);
        for (std::uint64_t i = 0; i < count; ++i) {
            const double index = load(type, index_begin + i * index_stride, false);
            if (!(index >= 0.0 && index < static_cast<double>(values_.count) && index == std::floor(index))) {
                document_.fail(place + ".indices", "element " + number_text(index) + " does not exist; there are " +
                                                       std::to_string(values_.count));
            }
            for (std::size_t c = 0; c < values_.components; ++c) {
                values_.numbers[static_cast<std::size_t>(index) * values_.components + c] =
                    number(value_begin + i * value_stride, c);
            }
        }
    }

    const GltfDocument& document_;
    const Json& accessor_;
    std::string place_;
    Component component_{};
    bool is_normalized_ = false;
    GltfValues values_;
};

}  // namespace

GltfValues read_accessor(const GltfDocument& document, std::uint64_t index, const char* type, const std::string& from) {
    return AccessorReader(document, index, type, from).read();
}

}  // namespace clbvh::io
