"""Time, and what trees are worth, over the values of one option."""
import math

from .canvas import builder_colours, load_matplotlib, tidy
from .data import BadInput, geometric_mean, per_million

SWEEP_AXES = {"radius": "search radius", "size": "triangles", "chunk": "chunk, in clusters",
              "threshold": "clusters below which one work group finishes the tree"}


def collect_sweep(results, what, value_of):
    """Builder to its values and, for each, the geometric mean over scenes of value_of(result)."""
    points = {}
    for result in results:
        if result["sweep"]["what"] == what:
            points.setdefault(result["builder"], {}).setdefault(result["sweep"]["value"], []).append(value_of(result))
    return {name: {x: geometric_mean(y) for x, y in sorted(of_builder.items())} for name, of_builder in points.items()}


def draw_lines(axes, lines, label):
    colours = builder_colours(list(lines))
    for name, points in lines.items():
        axes.plot(list(points), list(points.values()), marker="o", markersize=4, color=colours[name], label=name)
    axes.set_xscale("log", base=10 if max(max(p) for p in lines.values()) > 1e5 else 2)
    axes.set_ylabel(label)
    axes.grid(True, which="major", alpha=0.25)
    tidy(axes)


def begin_at_zero(axes):
    axes.set_ylim(0, 1.05 * axes.get_ylim()[1])


def draw_size_sweep(figure, results):
    """One panel: nanoseconds per triangle, the native sort's beside the builders'."""
    axes = figure.subplots()
    draw_lines(axes, collect_sweep(results, "size", per_million), "nanoseconds per triangle")
    sorts = {}
    for result in results:
        if "native_sort_ms" in result:
            sorts.setdefault(result["sweep"]["value"], []).append(
                result["native_sort_ms"]["median"] * 1e6 / result["triangles"])
    if sorts:
        sorts = {x: geometric_mean(y) for x, y in sorted(sorts.items())}
        axes.plot(list(sorts), list(sorts.values()), color="black", linestyle="--", linewidth=1, label="native sort")
    axes.set_xscale("log")
    begin_at_zero(axes)
    return axes


def draw_option_sweep(figure, results, what):
    """Two panels, time and SAH, where the swept option changes trees; else time alone."""
    best = {}
    for result in results:
        if result.get("sah") is not None:
            best[result["scene"]] = min(result["sah"], best.get(result["scene"], math.inf))
    costs = collect_sweep(results, what, lambda r: r["sah"] / best[r["scene"]]) if len(best) > 0 else {}
    changes_trees = any(max(p.values()) / min(p.values()) > 1.0005 for p in costs.values())
    panels = figure.subplots(1, 2 if changes_trees else 1, squeeze=False)[0]
    draw_lines(panels[0], collect_sweep(results, what, per_million), "milliseconds per million triangles")
    begin_at_zero(panels[0])
    if changes_trees:
        draw_lines(panels[1], costs, "SAH cost over the best one's")
        panels[1].set_xlabel(SWEEP_AXES.get(what, what))
    values = sorted({r["sweep"]["value"] for r in results})
    for axes in panels:
        axes.set_xticks(values, [str(v) for v in values], fontsize=8)
        axes.minorticks_off()
    return panels[0]


def draw_sweep(results, arguments):
    swept = [r for r in results if "sweep" in r]
    if not swept:
        raise BadInput(f"{arguments.input} holds no sweep; run clbvh bench with --sweep")
    kinds = list(dict.fromkeys(r["sweep"]["what"] for r in swept))
    if len(kinds) > 1:
        raise BadInput(f"{arguments.input} holds several sweeps: {', '.join(kinds)}")
    what = kinds[0]
    figure = load_matplotlib().figure(figsize=(9, 3.8))
    axes = draw_size_sweep(figure, swept) if what == "size" else draw_option_sweep(figure, swept, what)
    axes.set_xlabel(SWEEP_AXES.get(what, what))
    axes.legend(frameon=False, fontsize=8)
    figure.tight_layout()
    return figure
