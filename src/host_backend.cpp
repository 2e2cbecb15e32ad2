#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>

#include "backend.hpp"
#include "host/host_build.hpp"

namespace clbvh {
namespace {

/// More threads than oneTBB may start make it print a warning, and change nothing.
int arena_size(std::uint32_t thread_count) {
    if (thread_count == 0) return tbb::task_arena::automatic;
    const std::size_t most = tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
    return static_cast<int>(std::min<std::size_t>(thread_count, most));
}

class HostBackend final : public Backend {
public:
    HostBackend(const BuilderRow& row, const BuildOptions& options)
        : algorithm_(row.host_algorithm), options_(options), arena_(arena_size(options.thread_count)) {}

    void upload(const Mesh& mesh, std::uint64_t active_count) override {
        mesh_ = mesh;
        active_count_ = active_count;
    }

    BuildStats run() override {
        const host::BoundAlgorithm algorithm = [this](host::HostBuild& build) { algorithm_(build, options_); };
        return arena_.execute([&] {
            return host::run_host_build(mesh_, active_count_, algorithm, options_.progress, scratch_, result_);
        });
    }

    Bvh download() const override { return result_; }
    Shape shape() const noexcept override { return Shape::automatic; }

private:
    host::HostAlgorithm algorithm_;
    const BuildOptions& options_;
    tbb::task_arena arena_;
    Mesh mesh_;
    std::uint64_t active_count_ = 0;
    host::Scratch scratch_;
    Bvh result_;
};

}  // namespace

std::unique_ptr<Backend> make_host_backend(const BuilderRow& row, const BuildOptions& options) {
    return std::make_unique<HostBackend>(row, options);
}

}  // namespace clbvh
