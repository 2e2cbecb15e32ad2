"""The stages of device builders: their time, and the bytes that they move a second."""
from .canvas import panels_of
from .data import BadInput, median_ms, of_device, of_scenes, per_million, without_sweeps

STAGE_COLOURS = {"presplit": "#c7e9c0", "bounds": "#9ecae1", "morton": "#6baed6", "sort": "#2171b5",
                 "cluster": "#fd8d3c", "layout": "#756bb1", "root": "#756bb1", "download": "#bdbdbd", "collapse": "#74c476"}
OTHER_COLOUR = "#e6e6e6"
LEAST_SHARE = 0.01  # of a build's time


def stage_times(result):
    """Milliseconds per million triangles of each stage, and of what the build took beside them."""
    scale = 1e6 / result["triangles"]
    stages = {s["name"]: (s["device_ms"] if s["launches"] > 0 else s["host_ms"]) * scale for s in result["stages"]}
    return stages, max(0.0, per_million(result) - sum(stages.values()))


def draw_stages_of_scene(axes, results):
    names = [result["builder"] for result in results]
    parts = [stage_times(result) for result in results]
    used = [stage for stage in STAGE_COLOURS if any(stage in stages for stages, _ in parts)]
    left = [0.0] * len(results)
    for stage in used:
        widths = [stages.get(stage, 0.0) for stages, _ in parts]
        axes.barh(names, widths, left=left, color=STAGE_COLOURS[stage], label=stage)
        left = [a + b for a, b in zip(left, widths)]
    axes.barh(names, [other for _, other in parts], left=left, color=OTHER_COLOUR, label="launches, waits")
    for name, result in zip(names, results):
        axes.text(per_million(result), name, f" {per_million(result):.0f}", va="center")


def draw_stages(results, arguments):
    results = of_device(without_sweeps(results, arguments.input), arguments.input)
    scenes = of_scenes(results, arguments.scenes, arguments.input)
    heights = [0.5 + 0.27 * len(of_scene) for of_scene in scenes.values()]
    figure, panels = panels_of(scenes, heights, draw_stages_of_scene)
    panels[-1].set_xlabel("milliseconds per million triangles")
    handles, labels = panels[0].get_legend_handles_labels()
    room = 0.28 / figure.get_figheight()
    figure.legend(handles, labels, loc="lower center", ncol=len(labels), frameon=False, fontsize=8)
    figure.tight_layout(rect=(0, room, 1, 1))
    return figure


def stage_speeds(result):
    """(stage, GB/s) of the stages whose traffic is known, but for those that take no time worth a bar."""
    least = LEAST_SHARE * median_ms(result)
    return [(s["name"], s["gb_per_s"]) for s in result["stages"] if "gb_per_s" in s and s["device_ms"] >= least]


def draw_bandwidth_of_scene(axes, results):
    rows = [(result["builder"], stage, speed) for result in results for stage, speed in stage_speeds(result)]
    bars = axes.barh(range(len(rows)), [speed for _, _, speed in rows],
                     color=[STAGE_COLOURS.get(stage, OTHER_COLOUR) for _, stage, _ in rows])
    axes.bar_label(bars, labels=[f" {speed:.1f}" for _, _, speed in rows], fontsize=8)
    axes.set_yticks(range(len(rows)), [f"{builder}  {stage}" for builder, stage, _ in rows], fontsize=8)
    copy = results[0]["copy_gb_per_s"]["median"]
    axes.axvline(copy, color="black", linestyle="--", linewidth=1, label=f"copy, {copy:.1f} GB/s")
    axes.legend(edgecolor="none", fontsize=8, loc="lower right")


def draw_bandwidth(results, arguments):
    results = of_device(without_sweeps(results, arguments.input), arguments.input)
    results = [r for r in results if "copy_gb_per_s" in r and stage_speeds(r)]
    if not results:
        raise BadInput(f"{arguments.input} has no bytes moved, or no copy to compare with; run clbvh bench again with "
                       "this version, on a queue that profiles")
    scenes = of_scenes(results, arguments.scenes, arguments.input)
    heights = [0.6 + 0.2 * sum(len(stage_speeds(r)) for r in of_scene) for of_scene in scenes.values()]
    figure, panels = panels_of(scenes, heights, draw_bandwidth_of_scene)
    panels[-1].set_xlabel(f"GB/s, read and written; stages of at least {LEAST_SHARE:.0%} of the build")
    figure.tight_layout()
    return figure
