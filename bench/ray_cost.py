#!/usr/bin/env python3
"""Writes what `clbvh metrics` measured as a page of tables.

    ray_cost.py METRICS.json > PAGE.md
"""
import sys

sys.dont_write_bytecode = True  # the sources need not be where one may write

from plotting.data import BadInput, load_document, names_of, of_scenes, short_name  # noqa: E402
from plotting.pages import fit_cells, mean_ratio, pool_rows, print_table  # noqa: E402

MEASUREMENTS = {"binary_ns_per_ray": "Through the tree's own nodes, two children at a time (`binary`)",
                "ns_per_ray": "Eight children at a time (`ns/ray`)"}
BASELINE = "lbvh"  # as the paper's section 5 has it
RATIOS = {"SAH": "sah", "EPO": "epo", "LCV": "lcv", "steps/ray": "steps_per_ray", "binary": "binary_ns_per_ray",
          "ns/ray": "ns_per_ray"}
SCENE_COLUMNS = {"SAH": ("sah", 2), "EPO": ("epo", 2), "LCV": ("lcv", 2), "overlap": ("sibling_overlap", 2),
                 "depth": ("depth", 0), "steps/ray": ("steps_per_ray", 1), "tris/ray": ("triangles_per_ray", 1),
                 "ns/ray": ("ns_per_ray", 1), "binary": ("binary_ns_per_ray", 1)}


def print_correlations(correlation):
    print("## Correlations with the cost of rays\n")
    for measurement, title in MEASUREMENTS.items():
        rows = [[short_name(fits["scene"])] + fit_cells(fits)
                for fits in correlation["scenes"] if fits["measurement"] == measurement]
        for pool in correlation["pooled"]:
            if pool["measurement"] == measurement:
                rows += pool_rows(pool)
        print(f"{title}:\n")
        print_table(["scene", "SAH", "SAH+EPO", "alpha", "SAH+EPO+LCV", "alpha", "beta"], rows)


def print_builders(results, scenes):
    print(f"## Builders\n\nMeans over the scenes of each value over `{BASELINE}`'s.\n")
    print_table(["builder"] + list(RATIOS),
                [[f"`{name}`"] + [mean_ratio(scenes, name, field, BASELINE) for field in RATIOS.values()]
                 for name in names_of(results)])


def print_scenes(scenes):
    print("## Scenes\n")
    for scene, results in scenes.items():
        print(f"{short_name(scene)}: {results[0]['triangles']} triangles, {results[0]['ray_count']} "
              f"{results[0]['rays']} rays\n")
        print_table(["builder"] + list(SCENE_COLUMNS),
                    [[f"`{r['builder']}`"] + [f"{r[field]:.{digits}f}" for field, digits in SCENE_COLUMNS.values()]
                     for r in results])


def print_page(document):
    machine, options, results = document["machine"], document["options"], document["results"]
    scenes = of_scenes(results, None, "")
    print("# What rays cost, and what predicts it\n")
    leaves = f"merged up to {options['max_leaf_size']}" if options["max_leaf_size"] else "as builders make them"
    print(f"[Metrics](../metrics.md) says what the columns mean.\nLeaves {leaves}; scenes turned by "
          f"{document['rotate_degrees']:g} degrees; {machine.get('cpu', 'unknown processor')}, "
          f"{machine.get('logical_cores', '?')} logical cores, {machine['compiler']}, {machine['date'][:10]}.\n")
    print_correlations(document["correlation"])
    print_builders(results, scenes)
    print_scenes(scenes)


def main():
    if len(sys.argv) != 2 or sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    try:
        document = load_document(sys.argv[1])
        if not document.get("correlation") or not document.get("results"):
            raise BadInput(f"{sys.argv[1]} holds no metrics; run clbvh metrics with --json")
        print_page(document)
    except BadInput as error:
        sys.exit(f"ray_cost.py: error: {error}")
    except KeyError as error:
        sys.exit(f"ray_cost.py: error: {sys.argv[1]} lacks {error}")


if __name__ == "__main__":
    main()
