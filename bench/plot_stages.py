#!/usr/bin/env python3
"""Draws where the builders' time goes: stacked bars of device time per stage, from the JSON of `clbvh bench`.

usage: plot_stages.py BENCH.json OUTPUT.png [SCENE...]      (needs python3-matplotlib)
"""
import json
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

STAGE_COLOURS = {"bounds": "#9ecae1", "morton": "#6baed6", "sort": "#2171b5", "cluster": "#fd8d3c", "layout": "#756bb1"}
OTHER_COLOUR = "#d9d9d9"


def milliseconds_per_million(result):
    """Device time of each stage, then what the build took beside it (launches, read-backs)."""
    scale = 1e6 / result["triangles"]
    stages = {stage["name"]: stage["device_ms"] * scale for stage in result["stages"]}
    total = result["build_ms"]["median"] * scale
    return stages, max(0.0, total - sum(stages.values()))


def draw_scene(axes, scene, results):
    names = [result["builder"] for result in results]
    parts = [milliseconds_per_million(result) for result in results]
    left = [0.0] * len(results)
    for stage, colour in STAGE_COLOURS.items():
        widths = [stages.get(stage, 0.0) for stages, _ in parts]
        axes.barh(names, widths, left=left, color=colour, label=stage)
        left = [a + b for a, b in zip(left, widths)]
    axes.barh(names, [other for _, other in parts], left=left, color=OTHER_COLOUR, label="launches, read-backs")
    for name, (stages, other) in zip(names, parts):
        total = sum(stages.values()) + other
        axes.text(total, name, f" {total:.0f}", va="center")
    axes.invert_yaxis()
    axes.margins(x=0.1)
    axes.set_title(f"{scene}, {results[0]['triangles'] / 1e6:.2f} M triangles", fontsize=10, loc="left")
    axes.spines[["top", "right"]].set_visible(False)


def main():
    if len(sys.argv) < 3 or sys.argv[1] in ("-h", "--help"):
        sys.exit(__doc__)
    with open(sys.argv[1], encoding="utf-8") as file:
        bench = json.load(file)
    wanted = sys.argv[3:] or list(dict.fromkeys(result["scene"] for result in bench["results"]))
    figure, rows = plt.subplots(len(wanted), 1, figsize=(8, 0.6 + 1.5 * len(wanted)), sharex=True, squeeze=False)
    for axes, scene in zip(rows[:, 0], wanted):
        results = [result for result in bench["results"] if result["scene"] == scene]
        if not results:
            sys.exit(f"{sys.argv[1]} has no scene '{scene}'")
        draw_scene(axes, scene, results)
    rows[-1, 0].set_xlabel("milliseconds per million triangles")
    handles, labels = rows[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncol=len(labels), frameon=False, fontsize=8)
    figure.tight_layout(rect=(0, 0.04, 1, 1))
    figure.savefig(sys.argv[2], dpi=130)


if __name__ == "__main__":
    main()
