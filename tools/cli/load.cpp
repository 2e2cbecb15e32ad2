#include "cli/load.hpp"

#include "cli/interrupt.hpp"

namespace clbvh::tool {

Mesh load_cancellably(const std::string& scene, LoadReport* report) {
    return load_scene(scene, {[](const Progress&) { return !interrupted(); }, report});
}

Mesh load_with_progress(const std::string& scene, ProgressBar& bar, LoadReport* report) {
    const std::string label = "loading " + scene;
    bar.show_now(0.0, label);
    return load_scene(scene, {[&](const Progress& progress) {
                                  bar.show(progress.fraction, label);
                                  return !interrupted();
                              },
                              report});
}

}  // namespace clbvh::tool
