#!/usr/bin/env python3
"""Writes how optimised trees compare, beside what the papers say of that, as a page of tables.

    optimizer_relations.py TABLE.json BENCH.json... > PAGE.md

TABLE.json is of `clbvh table`; the others are of `clbvh bench --builders sweep-sah`: one without --optimize, one with
--optimize rotate, one with --optimize anneal, over the same scenes.
"""
import sys

sys.dont_write_bytecode = True  # the sources need not be where one may write

from plotting.data import BadInput, load_document, of_scenes, short_name  # noqa: E402
from plotting.pages import mean_ratio, print_table, published  # noqa: E402

SWEEP = "sweep-sah"
STEPS = {"rotate": "hill climbing", "anneal": "annealing"}
OF_LBVH = ["bittner", "anneal", "treelet", "hclimb"]  # the order of their SAH costs in the paper, the lowest first


def load_benches(paths):
    """What was optimised by what, to scene to result."""
    benches = {}
    for path in paths:
        document = load_document(path)
        results = [r for r in document.get("results", []) if r["builder"] == SWEEP]
        if not results:
            raise BadInput(f"{path} has no {SWEEP}; run clbvh bench with --builders {SWEEP}")
        benches[document["options"]["optimizers"]] = {r["scene"]: r for r in results}
    for wanted in ["", *STEPS]:
        if wanted not in benches:
            raise BadInput(f"there is no file of clbvh bench {'--optimize ' + wanted if wanted else 'without --optimize'}")
    return benches


def part(before, after):
    return f"{100 * after / before:.1f} %" if before else "-"


def print_kensler(benches):
    print("## Rotations of sweep trees\n\nSAH cost, and what hill climbing and annealing leave of it.\nKensler 2008, "
          "table 1, has its costs in other units; the parts compare.\n")
    rows = []
    for scene, plain in benches[""].items():
        row = [short_name(scene), str(plain["triangles"]), f"{plain['sah']:.2f}"]
        for id in STEPS:
            after = benches[id].get(scene)
            row.append(f"{after['sah']:.2f} ({part(plain['sah'], after['sah'])})" if after else "-")
        rows.append(row)
    for paper in published()["kensler"]["scenes"]:
        rows.append([f"*{paper['scene']}*", f"*{paper['triangles']}*", f"*{paper['sah']:.1f}*"] +
                    [f"*{paper[id]:.1f} ({part(paper['sah'], paper[id])})*" for id in STEPS])
    print_table(["scene (*the paper's*)", "triangles", "sweep tree"] + list(STEPS.values()), rows)


def print_beside_sweep(document, scenes):
    print("## Optimised LBVHs beside sweep trees\n\nSAH cost of an optimised LBVH, as a part of BBVH's (`sweep-sah`) on "
          "the same scene.\n")
    titles = {r["builder"]: r["title"] for r in document["results"]}
    rows = []
    for scene, results in scenes.items():
        sah = {r["builder"]: r["sah"] for r in results}
        rows.append([short_name(scene)] + [part(sah["bbvh"], sah[id]) for id in OF_LBVH])
    for scene, parts in published()["aila"]["sah_over_bbvh"].items():
        rows.append([f"*{scene}*"] + [f"*{part(1, parts[id])}*" for id in OF_LBVH])
    print_table(["scene (*the paper's*)"] + [titles[id] for id in OF_LBVH], rows)


def print_order(document, scenes):
    titles = {r["builder"]: r["title"] for r in document["results"]}
    paper = published()["aila"]["relative_to_lbvh"]
    print("## The order on LBVHs\n\nMeans over the scenes of each cost over LBVH's; in brackets the paper's, over its 22 "
          "scenes.\n")
    rows = []
    for name, field in (("SAH", "sah"), ("EPO", "epo"), ("LCV", "lcv")):
        rows.append([name] + [f"{mean_ratio(scenes, id, field, 'lbvh')} ({paper[field][id]:.3f})" for id in OF_LBVH])
    print_table([""] + [titles[id] for id in OF_LBVH], rows)


def main():
    paths = sys.argv[1:]
    if len(paths) < 2 or paths[0].startswith("-"):
        sys.exit(__doc__)
    try:
        document = load_document(paths[0])
        if not document.get("results") or "anneal_passes" not in document:
            raise BadInput(f"{paths[0]} holds no table; run clbvh table with --json")
        benches = load_benches(paths[1:])
        scenes = of_scenes(document["results"], None, "")
        print("# What optimisers make of trees, beside what their papers say\n")
        print_kensler(benches)
        print_beside_sweep(document, scenes)
        print_order(document, scenes)
    except BadInput as error:
        sys.exit(f"optimizer_relations.py: error: {error}")
    except KeyError as error:
        sys.exit(f"optimizer_relations.py: error: {paths[0]} or another file lacks {error}")


if __name__ == "__main__":
    main()
