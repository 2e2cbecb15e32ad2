"""Speeds of builds and of rays, relative to one builder's, scene by scene."""
import math

from .canvas import builder_colours, load_matplotlib, tidy
from .data import BadInput, find_builder, geometric_mean, median_ms, names_of, of_scenes, short_name, without_sweeps


def relative_speeds(scenes, names, cost_of, arguments):
    """Builder to its speed over the baseline's in each scene, NaN where it did not run, and then the geometric mean."""
    speeds = {name: [] for name in names}
    for of_scene in scenes.values():
        unit = cost_of(find_builder(of_scene, arguments.baseline, arguments.input))
        times = {r["builder"]: cost_of(r) for r in of_scene}
        for name in names:
            speeds[name].append(unit / times[name] if name in times else math.nan)
    for values in speeds.values():
        known = [v for v in values if not math.isnan(v)]
        values.append(geometric_mean(known))
    return speeds


def draw_bars(results, cost_of, what, arguments):
    """A group of bars for each scene and for their geometric mean, a bar for each builder."""
    scenes = of_scenes(results, arguments.scenes, arguments.input)
    names = [n for n in names_of([r for of_scene in scenes.values() for r in of_scene])
             if n not in arguments.leave_out]
    if not names:
        raise BadInput(f"--leave-out leaves no builder of {arguments.input}")
    speeds = relative_speeds(scenes, names, cost_of, arguments)
    groups = [short_name(scene) for scene in scenes] + ["mean"]
    colours = builder_colours(names)
    figure, axes = load_matplotlib().subplots(figsize=(min(14, max(8, 1.5 + 0.16 * len(groups) * len(names))), 4.6))
    width = 0.8 / len(names)
    for i, name in enumerate(names):
        places = [g + (i - (len(names) - 1) / 2) * width for g in range(len(groups))]
        axes.bar(places, speeds[name], width, color=colours[name], label=name)
        axes.text(places[-1], speeds[name][-1], f"{speeds[name][-1]:.2f}", rotation=90, ha="center", va="bottom",
                  fontsize=7)
    axes.axhline(1.0, color="black", linewidth=0.7)
    slant = {"rotation": 20, "ha": "right"} if len(groups) > 4 else {}
    axes.set_xticks(range(len(groups)), groups, **slant)
    axes.set_ylabel(f"{what} over {arguments.baseline}'s")
    axes.grid(True, axis="y", alpha=0.25)
    axes.margins(y=0.12)
    tidy(axes)
    columns = min(int(figure.get_figwidth() / 1.5), len(names))
    figure.legend(*axes.get_legend_handles_labels(), loc="upper center", ncol=columns, frameon=False, fontsize=8)
    figure.tight_layout(rect=(0, 0, 1, 1 - 0.05 * math.ceil(len(names) / columns)))
    return figure


def draw_speed(results, arguments):
    return draw_bars(without_sweeps(results, arguments.input), median_ms, "build speed", arguments)


def draw_rays(results, arguments):
    """After Benthin et al. 2022, figure 5."""
    results = [r for r in without_sweeps(results, arguments.input) if "ns_per_ray" in r]
    if not results:
        raise BadInput(f"{arguments.input} has no rays; run clbvh trace, clbvh metrics or clbvh bench --rays")
    kinds = list(dict.fromkeys(r.get("rays", "diffuse") for r in results))
    kind = arguments.rays or kinds[0]
    if kind not in kinds:
        raise BadInput(f"{arguments.input} has no {kind} rays; it has {', '.join(kinds)}")
    chosen = [r for r in results if r.get("rays", "diffuse") == kind]
    return draw_bars(chosen, lambda r: r["ns_per_ray"], f"speed of {kind} rays", arguments)
