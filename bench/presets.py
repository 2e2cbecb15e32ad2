#!/usr/bin/env python3
"""Writes what `clbvh bench --builders presets,... --rays` measured as a page of tables.

    presets.py BENCH.json [GROUP=SCENE,SCENE...]... > PAGE.md

Each group becomes a table of geometric means over its scenes, relative to the preset `fast`; then every scene has its own.
"""
import sys

sys.dont_write_bytecode = True  # the sources need not be where one may write

from plotting.data import BadInput, geometric_mean, load_document, names_of, of_scenes, per_million, short_name  # noqa: E402
from plotting.pages import print_table  # noqa: E402

BASELINE = "fast"
VALUES = {"ms a million": per_million, "SAH": lambda r: r["sah"], "steps/ray": lambda r: r["steps_per_ray"],
          "binary": lambda r: r["binary_ns_per_ray"], "ns/ray": lambda r: r["ns_per_ray"]}


def is_traced(result):
    return result.get("sah") is not None and "ns_per_ray" in result


def mean_of_ratios(scenes, name, value):
    ratios = []
    for results in scenes:
        by_name = {r["builder"]: r for r in results}
        if BASELINE not in by_name:
            raise BadInput(f"the scene {short_name(results[0]['scene'])} lacks the preset {BASELINE}")
        if name in by_name:
            ratios.append(value(by_name[name]) / value(by_name[BASELINE]))
    return geometric_mean(ratios)


def print_group(title, scenes, names):
    print(f"## {title}\n")
    rows = [[f"`{name}`"] + [f"{mean_of_ratios(scenes, name, value):.3f}" for value in VALUES.values()]
            for name in names]
    print_table(["builder"] + [f"{column} over `{BASELINE}`" for column in VALUES], rows)


def print_scene(results):
    print(f"{short_name(results[0]['scene'])}, {results[0]['triangles']} triangles:\n")
    print_table(["builder", "ms"] + list(VALUES),
                [[f"`{r['builder']}`", f"{r['build_ms']['median']:.1f}"] +
                 [f"{value(r):.1f}" if column != "SAH" else f"{value(r):.2f}" for column, value in VALUES.items()]
                 for r in results])


def parse_groups(words, scenes):
    groups = {}
    for word in words:
        title, separator, names = word.partition("=")
        if not separator:
            raise BadInput(f"'{word}' is no group: GROUP=SCENE,SCENE")
        missing = [name for name in names.split(",") if name not in scenes]
        if missing:
            raise BadInput(f"the group {title} has {missing[0]}, which was not measured")
        groups[title] = [scenes[name] for name in names.split(",")]
    return groups


def main():
    if len(sys.argv) < 2 or sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    try:
        document = load_document(sys.argv[1])
        results = [r for r in document.get("results", []) if is_traced(r)]
        if not results:
            raise BadInput(f"{sys.argv[1]} holds no trees with rays; run clbvh bench with --rays and --json")
        scenes = {short_name(scene): found for scene, found in of_scenes(results, None, "").items()}
        groups = parse_groups(sys.argv[2:], scenes) or {"All scenes": list(scenes.values())}
        machine = document["machine"]
        print(f"# Presets\n\n[Presets](../presets.md) says what the columns mean.\n{machine.get('cpu', 'Unknown processor')}, "
              f"{machine.get('logical_cores', '?')} logical cores, {machine['compiler']}, {machine['date'][:10]}.\n")
        for title, of_group in groups.items():
            print_group(title, of_group, names_of(results))
        print("## Every scene\n")
        for found in scenes.values():
            print_scene(found)
    except BadInput as error:
        sys.exit(f"presets.py: error: {error}")
    except KeyError as error:
        sys.exit(f"presets.py: error: {sys.argv[1]} lacks {error}")


if __name__ == "__main__":
    main()
