#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "clbvh/core/mesh.hpp"
#include "clbvh/options.hpp"
#include "device/build/device_algorithm.hpp"

namespace clbvh::test {

inline constexpr std::array kBothShapes{Shape::group, Shape::lane};

/// What is behind the device builder of this id.
[[nodiscard]] const device::DeviceAlgorithm& algorithm_of(std::string_view id);

/// `options` made definite for the shared device, for builders that search chunks.
[[nodiscard]] device::BuildSettings settings_of(const BuildOptions& options);

/// The same, but with as much work to fill as the largest device has.
[[nodiscard]] device::BuildSettings large_device_settings(const BuildOptions& options);

/// The same, but for a device whose work groups hold no more than this.
[[nodiscard]] device::BuildSettings small_group_settings(const BuildOptions& options, std::size_t largest_group);

/// What one stage needs to run by itself: settings, memory for some primitives, and a launcher in a stage "test".
/// Runs on the context that all tests share.
struct StageBench {
    /// `algorithm` is the one whose memory is laid out and reserved; without one, that of builders over sorted boxes.
    StageBench(const device::BuildSettings& settings, std::size_t primitives,
               const device::DeviceAlgorithm* algorithm = nullptr, ProgressCallback progress = {});
    StageBench(const BuildOptions& options, std::size_t primitives);

    device::Session& session;
    device::BuildSettings settings;
    device::OwnMemory memory;
    const device::BuildBuffers& buffers;  ///< primitive_count holds the primitives
    ProgressCallback progress;
    device::Launcher launcher;
};

[[nodiscard]] device::DeviceMesh upload_mesh(const device::Session& session, const Mesh& mesh);

void write_bytes(const cl::Buffer& buffer, const void* data, std::size_t bytes);
void read_bytes(const cl::Buffer& buffer, void* data, std::size_t bytes);

/// Fills all of `buffer` with this byte.
void fill_bytes(const cl::Buffer& buffer, std::uint8_t value);

template <typename T>
void write(const cl::Buffer& buffer, const std::vector<T>& values) {
    write_bytes(buffer, values.data(), values.size() * sizeof(T));
}

/// The first `count` values of `buffer`, when all that was launched is done.
template <typename T>
[[nodiscard]] std::vector<T> read(const cl::Buffer& buffer, std::size_t count) {
    std::vector<T> values(count);
    read_bytes(buffer, values.data(), count * sizeof(T));
    return values;
}

[[nodiscard]] bool is_same_bits(const Aabb& a, const Aabb& b);

}  // namespace clbvh::test
