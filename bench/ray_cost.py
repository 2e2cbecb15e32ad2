#!/usr/bin/env python3
"""Writes what `clbvh metrics` measured as a page of tables.

    ray_cost.py METRICS.json > PAGE.md
"""
import sys

sys.dont_write_bytecode = True  # the sources need not be where one may write

from plotting.data import BadInput, load_document, names_of, of_scenes, short_name  # noqa: E402

MEASUREMENTS = {"binary_ns_per_ray": "Through the tree's own nodes, two children at a time (`binary`)",
                "ns_per_ray": "Eight children at a time (`ns/ray`)"}
BASELINE = "lbvh"  # as the paper's section 5 has it
RATIOS = {"SAH": "sah", "EPO": "epo", "LCV": "lcv", "steps/ray": "steps_per_ray", "binary": "binary_ns_per_ray",
          "ns/ray": "ns_per_ray"}
SCENE_COLUMNS = {"SAH": ("sah", 2), "EPO": ("epo", 2), "LCV": ("lcv", 2), "overlap": ("sibling_overlap", 2),
                 "depth": ("depth", 0), "steps/ray": ("steps_per_ray", 1), "tris/ray": ("triangles_per_ray", 1),
                 "ns/ray": ("ns_per_ray", 1), "binary": ("binary_ns_per_ray", 1)}


def print_table(header, rows):
    print(f"| {' | '.join(header)} |")
    print("|" + "---|" * len(header))
    for row in rows:
        print(f"| {' | '.join(row)} |")
    print()


def fit_cells(fits):
    both, all_three = fits["sah_epo"], fits["sah_epo_lcv"]
    return [f"{fits['sah']['correlation']:.3f}", f"{both['correlation']:.3f}", f"{both['alpha']:.2f}",
            f"{all_three['correlation']:.3f}", f"{all_three['alpha']:.2f}", f"{all_three['beta']:.2f}"]


def pool_rows(pool):
    fits = [pool[name] for name in ("sah", "sah_epo", "sah_epo_lcv")]
    rows = []
    for title, key in (("mean", "mean"), ("least", "minimum")):
        sah, both, all_three = (f"**{fit[key]:.3f}**" for fit in fits)
        rows.append([f"**{title}**", sah, both, "", all_three, "", ""])
    shared = {name: pool[name]["shared"] for name in ("sah", "sah_epo", "sah_epo_lcv")}
    return rows + [["**weights shared**"] + fit_cells(shared)]


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


def mean_ratio(scenes, builder, field):
    """Over the scenes where both ran, and the baseline's value is not 0; nothing where there are none."""
    ratios = []
    for results in scenes.values():
        values = {r["builder"]: r[field] for r in results}
        if values.get(BASELINE) and builder in values:
            ratios.append(values[builder] / values[BASELINE])
    return f"{sum(ratios) / len(ratios):.3f}" if ratios else "-"


def print_builders(results, scenes):
    print(f"## Builders\n\nMeans over the scenes of each value over `{BASELINE}`'s.\n")
    print_table(["builder"] + list(RATIOS),
                [[f"`{name}`"] + [mean_ratio(scenes, name, field) for field in RATIOS.values()]
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
    print(f"[Metrics](../metrics.md) says what the columns mean. Leaves {leaves}; scenes turned by "
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
