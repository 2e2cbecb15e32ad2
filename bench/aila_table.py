#!/usr/bin/env python3
"""Writes what `clbvh table` measured as a page of tables, beside what the paper's tables say.

    aila_table.py TABLE.json [TURNED.json] > PAGE.md

TURNED.json is of the same scenes with --rotate.
"""
import sys

sys.dont_write_bytecode = True  # the sources need not be where one may write

from plotting.data import BadInput, load_document, of_scenes, short_name  # noqa: E402
from plotting.pages import fit_cells, mean_ratio, pool_rows, print_table, published  # noqa: E402

BASELINE = "lbvh"
MEASURES = {"cost_per_ray": "cost/ray", "binary_ns_per_ray": "ns/ray, host, binary", "ns_per_ray": "ns/ray, host",
            "device_binary_ns_per_ray": "ns/ray, device, binary", "device_ns_per_ray": "ns/ray, device"}
TREE_ROWS = {"SAH": ("sah", 2), "EPO": ("epo", 2), "LCV": ("lcv", 2)}
# Which row of the paper's stands below which of ours: its scalar rays are traced one at a time, as the host's are.
COMPARED = {"sah": "sah", "epo": "epo", "lcv": "lcv", "binary_ns_per_ray": "ns_per_ray scalar"}


def measured(document):
    return {field: title for field, title in MEASURES.items() if all(field in r for r in document["results"])}


def columns_of(results):
    """Ids to titles, in the order of the file."""
    return {r["builder"]: r["title"] for r in results}


def print_head(document):
    machine, options = document["machine"], document["options"]
    device = document["device"]
    print("# Nine builders, as in table 1 of Aila, Karras and Laine 2013\n")
    print("[The table](../table.md) says which builder is which, and what the rows are.\nLeaves of up to "
          f"{options['max_leaf_size']} but for LBVH's; annealing of {document['anneal_passes']} passes; scenes turned by "
          f"{document['rotate_degrees']:g} degrees; {machine.get('cpu', 'unknown processor')}, "
          f"{machine.get('logical_cores', '?')} logical cores; device: {device['name'] if device else 'none'}; "
          f"{machine['compiler']}, {machine['date'][:10]}.\n")


def print_relations(document, scenes):
    """Means over the scenes, relative to LBVH, and the paper's below them."""
    columns = columns_of(document["results"])
    paper = published()["aila"]["relative_to_lbvh"]
    fields = {**{field: title for title, (field, _) in TREE_ROWS.items()},
              **measured(document)}
    rows = []
    for field, title in fields.items():
        rows.append([title] + [mean_ratio(scenes, id, field, BASELINE) for id in columns])
        if field in COMPARED:
            theirs = paper[COMPARED[field]]
            title = "*paper, scalar*" if "ns_per_ray" in field else "*paper*"
            rows.append([title] + [f"*{theirs[id]:.3f}*" for id in columns])
    rows.append(["*paper, SIMD*"] + [f"*{paper['ns_per_ray SIMD'][id]:.3f}*" for id in columns])
    print(f"## Beside the paper\n\nMeans over {len(scenes)} scenes of each value over LBVH's, and below them those of "
          "the paper's 22 scenes (its tables 1 and 3, on a GTX680).\n"
          "Its SIMD rays, 32 together on a GPU, have no row here that compares with them.\n")
    print_table([""] + list(columns.values()), rows)


def print_correlations(document):
    correlation, paper = document["correlation"], published()["aila"]["correlation"]
    print("## Correlations\n")
    for name, numbers in paper.items():
        print(f"The paper's, {name}: means of {', '.join(f'{x:.3f}' for x in numbers['mean'])}; least values of "
              f"{', '.join(f'{x:.3f}' for x in numbers['minimum'])}.\n")
    for field, title in measured(document).items():
        rows = [[short_name(fits["scene"])] + fit_cells(fits)
                for fits in correlation["scenes"] if fits["measurement"] == field]
        for pool in correlation["pooled"]:
            if pool["measurement"] == field:
                rows += pool_rows(pool)
        print(f"With {title}:\n")
        print_table(["scene", "SAH", "SAH+EPO", "alpha", "SAH+EPO+LCV", "alpha", "beta"], rows)


def mean_rise(scenes, turned, builder, field):
    """Over the scenes where the value is not 0 before, in percent; nothing where there are none."""
    rises = []
    for scene, results in scenes.items():
        before, after = ({r["builder"]: r[field] for r in of}[builder] for of in (results, turned[scene]))
        if before:
            rises.append(100 * (after / before - 1))
    return f"{sum(rises) / len(rises):+.0f} %" if rises else "-"


def print_turned(document, scenes, turned):
    """Only of what is the same on every machine."""
    columns = columns_of(document["results"])
    of_turned = of_scenes(turned["results"], list(scenes), "the file of turned scenes")
    print(f"## Turned by {turned['rotate_degrees']:g} degrees\n\nMean rise over the scenes.\nThe paper "
          "(section 4.4, 45 degrees): SAH by less than 10 % for SBVH and STreelet and by 50 % for the others; EPO by 290 %;\n"
          "time by 90 % for SBVH and STreelet, 250 % for Agglo and some 180 % for the rest.\n")
    print_table([""] + list(columns.values()),
                [[title] + [mean_rise(scenes, of_turned, id, field) for id in columns]
                 for title, field in (("SAH", "sah"), ("EPO", "epo"), ("cost/ray", "cost_per_ray"))])


def milliseconds(value):
    return f"{value:.1f}" if value < 100 else f"{value:.0f}"


def print_scene(document, scene, results):
    fits = {f["measurement"]: fit_cells(f) for f in document["correlation"]["scenes"] if f["scene"] == scene}
    print(f"### {short_name(scene)}\n\n{results[0]['triangles']} triangles, {results[0]['ray_count']} "
          f"{results[0]['rays']} rays\n")
    rows = []
    for field, title in measured(document).items():
        sah, both, alpha, all_three, alpha_of_three, beta = fits.get(field, [""] * 6)
        cells = [sah, f"{both} ({alpha})", f"{all_three} ({alpha_of_three}, {beta})"] if field in fits else [""] * 3
        rows.append([title] + [f"{r[field]:.1f}" for r in results] + cells)
    for title, (field, digits) in TREE_ROWS.items():
        rows.append([title] + [f"{r[field]:.{digits}f}" for r in results] + [""] * 3)
    rows.append(["build ms"] + [milliseconds(r["build_ms"]) for r in results] + [""] * 3)
    print_table([""] + [r["title"] for r in results] + ["SAH", "SAH+EPO (alpha)", "SAH+EPO+LCV (alpha, beta)"], rows)


def print_page(document, turned):
    scenes = of_scenes(document["results"], None, "")
    print_head(document)
    print_relations(document, scenes)
    if turned:
        print_turned(document, scenes, turned)
    print_correlations(document)
    print("## Scenes\n")
    for scene, results in scenes.items():
        print_scene(document, scene, results)


def load_table(path):
    document = load_document(path)
    if not document.get("results") or "anneal_passes" not in document:
        raise BadInput(f"{path} holds no table; run clbvh table with --json")
    return document


def main():
    paths = sys.argv[1:]
    if len(paths) not in (1, 2) or paths[0].startswith("-"):
        sys.exit(__doc__)
    try:
        documents = [load_table(path) for path in paths]
        print_page(documents[0], documents[1] if len(documents) > 1 else None)
    except BadInput as error:
        sys.exit(f"aila_table.py: error: {error}")
    except KeyError as error:
        sys.exit(f"aila_table.py: error: {' or '.join(paths)} lacks {error}")


if __name__ == "__main__":
    main()
