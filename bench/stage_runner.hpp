#pragma once

#include <benchmark/benchmark.h>

#include <cstdint>
#include <functional>

#include "clbvh/core/mesh.hpp"
#include "clbvh/device/context.hpp"
#include "clbvh/options.hpp"
#include "device/build/build_buffers.hpp"
#include "device/opencl/launcher.hpp"

namespace clbvh::bench {

/// Input of a stage: a mesh of a generated scene on the device, and the memory of its build.
class StageRunner {
public:
    using Step = std::function<void(StageRunner&, device::Launcher&)>;

    StageRunner(const BuildOptions& options, std::uint32_t triangles);

    /// Launches `prepare`, which is not measured, and then `measured`, for each iteration of `state`; takes the time of
    /// the latter's kernels on the device, and reports elements and bytes per second.
    void run(benchmark::State& state, const Step& prepare, const Step& measured);

    [[nodiscard]] device::Session& session() { return context_.session(); }
    [[nodiscard]] const device::BuildSettings& settings() const { return settings_; }
    [[nodiscard]] const device::BuildBuffers& buffers() const { return memory_.buffers(); }
    [[nodiscard]] const device::DeviceMesh& mesh() const { return mesh_; }
    [[nodiscard]] std::uint32_t size() const { return mesh_.primitive_count; }

private:
    Context context_;
    device::BuildSettings settings_;
    device::OwnMemory memory_;
    device::DeviceMesh mesh_;
};

}  // namespace clbvh::bench
