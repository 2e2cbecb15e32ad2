#include <tbb/task_arena.h>

#include "build/backend.hpp"
#include "core/own_group.hpp"
#include "host/build/host_build.hpp"

namespace clbvh {
namespace {

class HostBackend final : public Backend {
public:
    HostBackend(const BuilderRow& row, const BuildOptions& options, tbb::task_arena& arena)
        : algorithm_(row.host_algorithm), options_(options), arena_(arena) {}

    void upload(const Input& input) override { input_ = {input.primitives, input.active_count, input.cut}; }
    void release_input() override { input_ = {}; }

    BuildStats run() override {
        const host::BoundAlgorithm algorithm = [this](host::HostBuild& build) { algorithm_(build, options_); };
        return execute_in(
            arena_, [&] { return host::run_host_build(input_, algorithm, options_.progress, scratch_, result_); });
    }

    void with_tree(const std::function<void(const layout::TreeView&)>& read) override {
        read(layout::view_of(result_));
    }
    Bvh download() const override { return result_; }
    Bvh& tree() override { return result_; }
    bool is_remote() const noexcept override { return false; }
    Shape shape() const noexcept override { return Shape::automatic; }

private:
    HostAlgorithm algorithm_;
    const BuildOptions& options_;
    tbb::task_arena& arena_;
    host::HostInput input_;
    Scratch scratch_;
    Bvh result_;
};

}  // namespace

std::unique_ptr<Backend> make_host_backend(const BuilderRow& row, const BuildOptions& options, tbb::task_arena& arena) {
    return std::make_unique<HostBackend>(row, options, arena);
}

}  // namespace clbvh
