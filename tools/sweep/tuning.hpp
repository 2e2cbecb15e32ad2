#pragma once

#include <clbvh/device/context.hpp>
#include <clbvh/device/profile.hpp>
#include <clbvh/options.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cli/progress_bar.hpp"
#include "cli/scene_arguments.hpp"
#include "measure/sample.hpp"

namespace clbvh::tool {

/// An option that lays work out and never changes the tree, the builder that it matters most to, and what to try.
struct Knob {
    std::string_view option;  ///< The name in BuildOptions.
    std::string_view builder;
    std::vector<std::uint32_t> values;  ///< The first is 0: the library's own choice.
    void (*set)(BuildOptions& options, std::uint32_t value);
    void (*keep)(Profile& profile, std::uint32_t value);
};

/// The time that builds take with one value of a knob.
struct Trial {
    std::uint32_t value;
    std::vector<Sample> build_ms;  ///< One a scene.
    double relative = 1.0;         ///< Geometric mean over the scenes, relative to the library's own choice.
    bool chosen = false;
};

/// All trials of a knob. Values that the device cannot serve are left out.
struct TunedKnob {
    Knob knob;
    std::vector<Trial> trials;
};

struct TuneSettings {
    std::vector<std::string> scenes;
    std::uint32_t runs = 9;  ///< Timed runs of each value.
    SceneArguments loading{};
};

/// The knobs that mean something on this device.
[[nodiscard]] std::vector<Knob> knobs_of(const Context& context);

/// How a value is written: "auto", a number or a shape.
[[nodiscard]] std::string value_text(const Knob& knob, std::uint32_t value);

/// Tries all values of `knob` over all scenes in interleaved rounds. The fastest is chosen where it beats the library's
/// own choice by more than noise. `options` hold what was chosen for knobs before. Throws Error(cancelled) after a
/// Ctrl-C.
[[nodiscard]] TunedKnob tune_knob(const Knob& knob, const TuneSettings& settings, const Context& context,
                                  const BuildOptions& options, ProgressBar& bar);

/// The value that was chosen, 0 for the library's own.
[[nodiscard]] std::uint32_t chosen_value(const TunedKnob& tuned);

/// What the self-test of the device found, in words.
[[nodiscard]] std::string hand_over_report(HandOver hand_over);

/// The table of one knob.
[[nodiscard]] std::string tuning_report(const TunedKnob& tuned, const TuneSettings& settings);

}  // namespace clbvh::tool
