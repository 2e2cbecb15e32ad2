#!/usr/bin/env python3
"""Draws figures from the JSON of `clbvh bench`.

    plot.py builders  BENCH.json OUT.png   build time against tree quality, one dot a builder
    plot.py stages    BENCH.json OUT.png   where device builders' time goes, a stacked bar a builder
    plot.py speed     BENCH.json OUT.png   build speed relative to one builder, scene by scene
    plot.py bandwidth BENCH.json OUT.png   what stages move a second, beside a copy
    plot.py sweep     SWEEP.json OUT.png   time, and what trees are worth, over `bench --sweep ...`

Needs matplotlib (Debian: python3-matplotlib). `plot.py FIGURE --help` lists a figure's options.
"""
import argparse
import json
import math
import sys

KIND_COLOURS = {"device": "#2171b5", "host": "#fd8d3c", "peer": "#969696"}
KIND_LABELS = {"device": "OpenCL device", "host": "host", "peer": "Embree 3"}
STAGE_COLOURS = {"presplit": "#c7e9c0", "bounds": "#9ecae1", "morton": "#6baed6", "sort": "#2171b5",
                 "cluster": "#fd8d3c", "layout": "#756bb1", "download": "#bdbdbd", "collapse": "#74c476"}
OTHER_COLOUR = "#e6e6e6"
LEAST_SHARE = 0.01  # of a build's time
SWEEP_AXES = {"radius": "search radius", "size": "triangles", "chunk": "chunk, in clusters",
              "threshold": "clusters below which one work group finishes the tree"}
LABEL_PLACES = [(6, 3, "left"), (6, -10, "left"), (-6, 3, "right"), (-6, -10, "right"), (6, 15, "left"),
                (6, -22, "left"), (-6, 15, "right"), (-6, -22, "right")]


class BadInput(Exception):
    """What is wrong with the input, for people."""


# What the JSON holds ------------------------------------------------------------------------------------------------

def load_document(path):
    try:
        with open(path, encoding="utf-8") as file:
            document = json.load(file)
    except OSError as error:
        raise BadInput(f"cannot read {path}: {error.strerror}") from error
    except ValueError as error:
        raise BadInput(f"{path} is no JSON: {error}") from error
    return document if isinstance(document, dict) else {}


def choose_part(document, part, path):
    """One document of several that a file holds under names of their own."""
    parts = [name for name, inner in document.items() if isinstance(inner, dict) and "results" in inner]
    if part is None and "results" in document:
        return document
    if part in parts:
        return document[part]
    if not parts:
        raise BadInput(f"{path} has no {'results' if part is None else 'parts'}: is it the JSON of clbvh bench?")
    raise BadInput(f"{path} has {', '.join(parts)}; choose one with --part")


def load(path, part):
    results = choose_part(load_document(path), part, path)["results"]
    if not results:
        raise BadInput(f"{path} holds no results")
    return results


def without_sweeps(results, path):
    plain = [r for r in results if "sweep" not in r]
    if not plain:
        raise BadInput(f"{path} holds a sweep; draw it with: plot.py sweep")
    return plain


def of_device(results, path):
    chosen = [r for r in results if r["kind"] == "device"]
    if not chosen:
        raise BadInput(f"{path} has no device builder; run clbvh bench with --builders device")
    return chosen


def of_scenes(results, wanted, path):
    """Scene to its results, in the file's order or as wanted."""
    scenes = {}
    for result in results:
        scenes.setdefault(result["scene"], []).append(result)
    for scene in wanted or []:
        if scene not in scenes:
            raise BadInput(f"{path} has no scene '{scene}'; it has {', '.join(scenes)}")
    return {scene: scenes[scene] for scene in wanted} if wanted else scenes


def find_builder(results, name, path):
    """The result of the builder among those of one scene."""
    for result in results:
        if result["builder"] == name:
            return result
    raise BadInput(f"{path} has no {name} on {results[0]['scene']}; choose another with --baseline")


def geometric_mean(values):
    return math.exp(sum(map(math.log, values)) / len(values))


def kind_of(result):
    return "peer" if result.get("peer") else result["kind"]


def median_ms(result):
    return result["build_ms"]["median"]


def per_million(result):
    """Milliseconds per million triangles."""
    return median_ms(result) * 1e6 / result["triangles"]


def short_name(scene):
    """Of a path the file's name without its ending."""
    return scene if scene.startswith("gen:") else scene.rsplit("/", 1)[-1].rsplit(".", 1)[0]


def names_of(results):
    return list(dict.fromkeys(r["builder"] for r in results))


def load_matplotlib():
    try:
        import matplotlib
        matplotlib.use("Agg")
        import matplotlib.pyplot as plt
    except ImportError as error:
        raise BadInput("matplotlib is missing (Debian: python3-matplotlib)") from error
    return plt


def builder_colours(names):
    cycle = load_matplotlib().get_cmap("tab10" if len(names) <= 10 else "tab20").colors
    return {name: cycle[i % len(cycle)] for i, name in enumerate(names)}


def panels_of(scenes, heights, draw):
    """A figure with a panel of its own height for each scene, one above the other, and the panels."""
    figure, rows = load_matplotlib().subplots(len(scenes), 1, figsize=(8, 0.7 + sum(heights)), sharex=True,
                                              squeeze=False, gridspec_kw={"height_ratios": heights})
    for axes, (scene, of_scene) in zip(rows[:, 0], scenes.items()):
        draw(axes, of_scene)
        axes.invert_yaxis()
        axes.margins(x=0.12)
        millions = of_scene[0]["triangles"] / 1e6
        axes.set_title(f"{short_name(scene)}, {millions:.2f} M triangles", fontsize=10, loc="left")
        tidy(axes)
    return figure, rows[:, 0]


def tidy(axes):
    axes.spines[["top", "right"]].set_visible(False)


# builders -----------------------------------------------------------------------------------------------------------

def collect_builders(results, baseline, path):
    """Builder to (kind, milliseconds per million triangles, SAH over the baseline's), geometric means over scenes."""
    points = {}
    for of_scene in of_scenes(results, None, path).values():
        unit = find_builder(of_scene, baseline, path)["sah"]
        for result in of_scene:
            if result.get("sah") is None:
                continue  # a peer whose tree cannot be read
            times, costs = points.setdefault(result["builder"], (kind_of(result), [], []))[1:]
            times.append(per_million(result))
            costs.append(result["sah"] / unit)
    return {name: (kind, geometric_mean(t), geometric_mean(c)) for name, (kind, t, c) in points.items()}


def add_labels(figure, axes, points):
    """A name beside each dot, where no other name is."""
    renderer = figure.canvas.get_renderer()
    taken = []
    for name, (_, time, cost) in sorted(points.items(), key=lambda point: point[1][1]):
        for x, y, side in LABEL_PLACES:
            label = axes.annotate(name, (time, cost), xytext=(x, y), textcoords="offset points", ha=side, fontsize=8)
            box = label.get_window_extent(renderer)
            if not any(box.overlaps(other) for other in taken) and box.x1 < axes.bbox.x1:
                break
            if (x, y, side) != LABEL_PLACES[-1]:
                label.remove()
        taken.append(box)


def draw_builders(results, arguments):
    results = without_sweeps(results, arguments.input)
    points = collect_builders(results, arguments.baseline, arguments.input)
    points = {name: point for name, point in points.items() if name not in arguments.leave_out}
    if not points:
        raise BadInput(f"--leave-out leaves no builder of {arguments.input}")
    figure, axes = load_matplotlib().subplots(figsize=(8, 4.2))
    for kind, colour in KIND_COLOURS.items():
        chosen = [p for p in points.values() if p[0] == kind]
        if chosen:
            axes.scatter([p[1] for p in chosen], [p[2] for p in chosen], color=colour, label=KIND_LABELS[kind], s=36)
    axes.set_xscale("log")
    axes.set_xlabel("milliseconds per million triangles (lower is faster)")
    axes.set_ylabel(f"SAH cost over {arguments.baseline}'s (lower is better)")
    axes.grid(True, which="both", alpha=0.25)
    tidy(axes)
    axes.legend(frameon=False, fontsize=8)
    figure.tight_layout()
    add_labels(figure, axes, points)
    return figure


# stages -------------------------------------------------------------------------------------------------------------

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


# speed --------------------------------------------------------------------------------------------------------------

def relative_speeds(scenes, names, baseline, path):
    """Builder to its speed over the baseline's in each scene, NaN where it did not run, and then the geometric mean."""
    speeds = {name: [] for name in names}
    for of_scene in scenes.values():
        unit = median_ms(find_builder(of_scene, baseline, path))
        times = {r["builder"]: median_ms(r) for r in of_scene}
        for name in names:
            speeds[name].append(unit / times[name] if name in times else math.nan)
    for values in speeds.values():
        known = [v for v in values if not math.isnan(v)]
        values.append(geometric_mean(known))
    return speeds


def draw_speed(results, arguments):
    results = without_sweeps(results, arguments.input)
    scenes = of_scenes(results, arguments.scenes, arguments.input)
    names = [n for n in names_of(results) if n not in arguments.leave_out]
    speeds = relative_speeds(scenes, names, arguments.baseline, arguments.input)
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
    axes.set_ylabel(f"build speed over {arguments.baseline}'s")
    axes.grid(True, axis="y", alpha=0.25)
    axes.margins(y=0.12)
    tidy(axes)
    columns = min(int(figure.get_figwidth() / 1.5), len(names))
    figure.legend(*axes.get_legend_handles_labels(), loc="upper center", ncol=columns, frameon=False, fontsize=8)
    figure.tight_layout(rect=(0, 0, 1, 1 - 0.05 * math.ceil(len(names) / columns)))
    return figure


# bandwidth ----------------------------------------------------------------------------------------------------------

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


# sweep --------------------------------------------------------------------------------------------------------------

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


# The command line ---------------------------------------------------------------------------------------------------

def word_list(text):
    return [word.strip() for word in text.split(",") if word.strip()]


def parse_arguments():
    parser = argparse.ArgumentParser(prog="plot.py", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    figures = parser.add_subparsers(dest="figure", metavar="FIGURE", required=True)

    def add(name, draw, text):
        figure = figures.add_parser(name, help=text, description=text)
        figure.add_argument("input", metavar="BENCH.json", help="what clbvh bench --json wrote")
        figure.add_argument("output", metavar="OUT.png", help="the figure; its ending chooses png, svg or pdf")
        figure.add_argument("--part", metavar="NAME", help="the document of that name, where the file holds several")
        figure.set_defaults(draw=draw)
        return figure

    def add_scenes(figure):
        figure.add_argument("--scenes", type=word_list, metavar="A,B", help="only these scenes, in this order")

    def add_leave_out(figure, default):
        figure.add_argument("--leave-out", type=word_list, default=default, metavar="A,B",
                            help=f"builders that are not shown; default: {', '.join(default) or 'none'}")

    builders = add("builders", draw_builders, "Build time against SAH cost: geometric means over the scenes.")
    builders.add_argument("--baseline", default="binned-sah", metavar="ID",
                          help="SAH is relative to it; default: %(default)s")
    add_leave_out(builders, ["median"])
    add_scenes(add("stages", draw_stages, "Time of each stage of the device builders, scene by scene."))
    speed = add("speed", draw_speed, "Build speed relative to one builder, scene by scene.")
    speed.add_argument("--baseline", default="ploc", metavar="ID", help="the builder that is 1; default: %(default)s")
    add_leave_out(speed, [])
    add_scenes(speed)
    add_scenes(add("bandwidth", draw_bandwidth, "Bytes that stages move a second, beside a copy on the same device."))
    add("sweep", draw_sweep, "Time and SAH cost over the values of clbvh bench --sweep; means over the scenes.")
    return parser.parse_args()


def main():
    arguments = parse_arguments()
    try:
        results = load(arguments.input, arguments.part)
        figure = arguments.draw(results, arguments)
        try:
            figure.savefig(arguments.output, dpi=130)
        except (OSError, ValueError) as error:
            raise BadInput(f"cannot write {arguments.output}: {error}") from error
    except BadInput as error:
        sys.exit(f"plot.py: error: {error}")
    except KeyError as error:
        sys.exit(f"plot.py: error: {arguments.input} lacks {error}, which this figure needs")


if __name__ == "__main__":
    main()
