"""Tables in Markdown, and what the papers say."""
import json
import pathlib


def print_table(header, rows):
    print(f"| {' | '.join(header)} |")
    print("|" + "---|" * len(header))
    for row in rows:
        print(f"| {' | '.join(row)} |")
    print()


def fit_cells(fits):
    """Of one scene: SAH, SAH+EPO, alpha, SAH+EPO+LCV, alpha, beta."""
    both, all_three = fits["sah_epo"], fits["sah_epo_lcv"]
    return [f"{fits['sah']['correlation']:.3f}", f"{both['correlation']:.3f}", f"{both['alpha']:.2f}",
            f"{all_three['correlation']:.3f}", f"{all_three['alpha']:.2f}", f"{all_three['beta']:.2f}"]


def pool_rows(pool):
    """Over several scenes, in the same columns, behind a column of titles."""
    fits = [pool[name] for name in ("sah", "sah_epo", "sah_epo_lcv")]
    rows = []
    for title, key in (("mean", "mean"), ("least", "minimum")):
        sah, both, all_three = (f"**{fit[key]:.3f}**" for fit in fits)
        rows.append([f"**{title}**", sah, both, "", all_three, "", ""])
    if "shared" not in pool["sah"]:  # scenes that were measured one at a time
        return rows
    shared = {name: pool[name]["shared"] for name in ("sah", "sah_epo", "sah_epo_lcv")}
    return rows + [["**weights shared**"] + fit_cells(shared)]


def mean_ratio(scenes, builder, field, baseline):
    """Over the scenes where both ran, and the baseline's value is not 0; nothing where there are none."""
    ratios = []
    for results in scenes.values():
        values = {r["builder"]: r[field] for r in results}
        if values.get(baseline) and builder in values:
            ratios.append(values[builder] / values[baseline])
    return f"{sum(ratios) / len(ratios):.3f}" if ratios else "-"


def published():
    """What is compared with, by paper."""
    path = pathlib.Path(__file__).resolve().parent.parent / "published.json"
    return json.loads(path.read_text(encoding="utf-8"))
