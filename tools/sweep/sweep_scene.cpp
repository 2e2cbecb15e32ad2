#include "sweep/sweep_scene.hpp"

#include <list>
#include <memory>
#include <optional>

#include "cli/interrupt.hpp"
#include "measure/copy_contestant.hpp"
#include "measure/rounds.hpp"
#include "measure/sort_contestant.hpp"
#include "sweep/sweep_contestant.hpp"

namespace clbvh::tool {
namespace {

/// A mesh of the sweep, and the sort of as many keys.
struct SizedMesh {
    SizedMesh(const SceneArguments& loading, std::string name_of_scene, ProgressBar& bar)
        : scene(std::move(name_of_scene)), mesh(load(loading, scene, bar)), sort(mesh.triangles.size()) {}

    static Mesh load(const SceneArguments& loading, const std::string& scene, ProgressBar& bar) {
        throw_if_interrupted();
        bar.show(0.0, "loading " + scene);
        return loading.load(scene);
    }

    std::string scene;
    Mesh mesh;
    SortContestant sort;
};

/// All contestants of one sweep over one scene.
class SweepField {
public:
    SweepField(const BenchSettings& settings, const Sweep& sweep, const std::vector<std::uint32_t>& values,
               const std::string& scene, ProgressBar& bar)
        : settings_(settings), progress_(scene, bar) {
        const bool sizes = sweep.values.empty();
        for (const std::uint32_t value : values) {
            if (sizes || meshes_.empty())
                meshes_.emplace_back(settings.loading, sizes ? with_count(scene, value) : scene, bar);
        }
        for (const std::string& id : settings.builders) {
            auto mesh = meshes_.begin();
            for (const std::uint32_t value : values) {
                add(sweep, id, value, *mesh);
                if (sizes) ++mesh;
            }
        }
        if (settings.context) copy_.emplace(*settings.context);
    }

    std::vector<BuildResult> run() {
        std::vector<Contestant*> contestants;
        for (const Entry& entry : entries_)
            contestants.push_back(entry.contestant.get());
        for (SizedMesh& mesh : meshes_)
            contestants.push_back(&mesh.sort);
        if (copy_) contestants.push_back(&*copy_);
        run_rounds(contestants, settings_.runs, progress_);
        return results();
    }

private:
    struct Entry {
        std::unique_ptr<SweepContestant> contestant;
        const SortContestant* sort;
    };

    void add(const Sweep& sweep, const std::string& id, std::uint32_t value, const SizedMesh& mesh) {
        SweepContestant::Point point{id, mesh.scene, &mesh.mesh, {std::string(sweep.what), value}, settings_.options};
        set_swept(sweep, point.options, value);
        point.options.progress = [this](const Progress& build) {
            progress_.show(build.fraction);
            return !interrupted();
        };
        entries_.push_back(
            {std::make_unique<SweepContestant>(std::move(point), settings_.context, settings_.validated), &mesh.sort});
    }

    [[nodiscard]] std::vector<BuildResult> results() const {
        std::vector<BuildResult> list;
        for (const Entry& entry : entries_) {
            BuildResult& result = list.emplace_back(entry.contestant->result());
            result.native_sort_ms = entry.sort->milliseconds();
            if (copy_ && result.kind == BuilderKind::device) result.copy_gb_per_s = copy_->gb_per_s();
        }
        return list;
    }

    const BenchSettings& settings_;
    RoundsProgress progress_;
    std::list<SizedMesh> meshes_;  // contestants point into it
    std::vector<Entry> entries_;
    std::optional<CopyContestant> copy_;
};

}  // namespace

std::vector<BuildResult> sweep_scene(const BenchSettings& settings, const Sweep& sweep,
                                     const std::vector<std::uint32_t>& values, const std::string& scene,
                                     ProgressBar& bar) {
    return SweepField(settings, sweep, values, scene, bar).run();
}

}  // namespace clbvh::tool
