#!/usr/bin/env python3
"""Draws what a tree costs against what it is worth: build time and SAH of every builder, from the JSON of `clbvh bench`.

usage: plot_builders.py BENCH.json OUTPUT.png      (needs python3-matplotlib)

One dot a builder: geometric means over the scenes of milliseconds per million triangles, and of SAH relative to binned-sah.
"""
import json
import math
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

COLOURS = {"device": "#2171b5", "host": "#fd8d3c", "peer": "#969696"}
LABELS = {"device": "OpenCL device (the same two cores)", "host": "host", "peer": "Embree 3"}
LEFT_OUT = {"median"}  # far above everything else
LABEL_PLACES = [(6, 3, "left"), (6, -10, "left"), (-6, 3, "right"), (-6, -10, "right"), (6, 15, "left"), (6, -22, "left"),
                (-6, 15, "right"), (-6, -22, "right")]


def geometric_mean(values):
    return math.exp(sum(map(math.log, values)) / len(values))


def kind_of(result):
    return "peer" if result.get("peer") else result["kind"]


def collect(results):
    """Builder to (kind, milliseconds per million triangles, SAH over binned-sah's)."""
    baseline = {r["scene"]: r["sah"] for r in results if r["builder"] == "binned-sah"}
    points = {}
    for result in results:
        times, costs = points.setdefault(result["builder"], (kind_of(result), [], []))[1:]
        times.append(result["build_ms"]["median"] * 1e6 / result["triangles"])
        costs.append(result["sah"] / baseline[result["scene"]])
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


def main():
    if len(sys.argv) != 3 or sys.argv[1] in ("-h", "--help"):
        sys.exit(__doc__)
    with open(sys.argv[1], encoding="utf-8") as file:
        points = collect(json.load(file)["results"])
    figure, axes = plt.subplots(figsize=(8, 4.2))
    for kind, colour in COLOURS.items():
        chosen = {n: p for n, p in points.items() if p[0] == kind and n not in LEFT_OUT}
        times, costs = [p[1] for p in chosen.values()], [p[2] for p in chosen.values()]
        axes.scatter(times, costs, color=colour, label=LABELS[kind], s=36)
    axes.set_xscale("log")
    axes.set_xlabel("milliseconds per million triangles (lower is faster)")
    axes.set_ylabel("SAH cost over binned-sah's (lower is better)")
    axes.grid(True, which="both", alpha=0.25)
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False, fontsize=8)
    figure.tight_layout()
    add_labels(figure, axes, {name: point for name, point in points.items() if name not in LEFT_OUT})
    figure.savefig(sys.argv[2], dpi=130)


if __name__ == "__main__":
    main()
