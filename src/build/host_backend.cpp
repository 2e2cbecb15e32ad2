#include <tbb/task_arena.h>

#include "build/backend.hpp"
#include "host/build/host_build.hpp"

namespace clbvh {
namespace {

class HostBackend final : public Backend {
public:
    HostBackend(const BuilderRow& row, const BuildOptions& options, tbb::task_arena& arena)
        : algorithm_(row.host_algorithm), options_(options), arena_(arena) {}

    void upload(const Mesh& mesh, std::uint64_t active_count) override {
        mesh_ = mesh;
        boxes_ = &mesh_;
        triangles_ = &mesh_;
        active_count_ = active_count;
    }

    void upload_parts(const Mesh& boxes, const Mesh& triangles) override {
        boxes_ = &boxes;
        triangles_ = &triangles;
        active_count_ = boxes.triangles.size();
    }

    BuildStats run() override {
        const host::BoundAlgorithm algorithm = [this](host::HostBuild& build) { algorithm_(build, options_); };
        return arena_.execute([&] {
            return host::run_host_build({*boxes_, *triangles_, active_count_}, algorithm, options_.progress, scratch_,
                                        result_);
        });
    }

    Bvh download() const override { return result_; }
    Bvh& tree() override { return result_; }
    bool is_remote() const noexcept override { return false; }
    Shape shape() const noexcept override { return Shape::automatic; }

private:
    HostAlgorithm algorithm_;
    const BuildOptions& options_;
    tbb::task_arena& arena_;
    Mesh mesh_;
    const Mesh* boxes_ = nullptr;
    const Mesh* triangles_ = nullptr;
    std::uint64_t active_count_ = 0;
    Scratch scratch_;
    Bvh result_;
};

}  // namespace

std::unique_ptr<Backend> make_host_backend(const BuilderRow& row, const BuildOptions& options, tbb::task_arena& arena) {
    return std::make_unique<HostBackend>(row, options, arena);
}

}  // namespace clbvh
