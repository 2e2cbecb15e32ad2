#!/usr/bin/env python3
"""Joins what `clbvh table` or `clbvh metrics` wrote of different scenes, measured one at a time, on one machine.

    join_tables.py A.json B.json... > ALL.json

Means and least values of correlations are over all scenes; weights that all scenes share need one run over all of them.
"""
import json
import sys

sys.dont_write_bytecode = True  # the sources need not be where one may write

from plotting.data import BadInput, load_document  # noqa: E402

FITS = ("sah", "sah_epo", "sah_epo_lcv")
SAME = ("options", "rotate_degrees", "anneal_passes")


def made_on(document):
    """The processor and the device: times on others do not go into one mean."""
    device = document.get("device")
    return (document.get("machine", {}).get("cpu", "an unknown processor"), device["name"] if device else "no device")


def require_alike(documents, paths):
    for document, path in zip(documents, paths):
        if not document.get("results") or "correlation" not in document:
            raise BadInput(f"{path} holds neither a table nor metrics")
        if "incomplete" in document:
            raise BadInput(f"{path} is incomplete ({document['incomplete']}): measure it again")
        if made_on(document) != made_on(documents[0]):
            raise BadInput(f"{path} was measured on {' and '.join(made_on(document))}, "
                           f"{paths[0]} on {' and '.join(made_on(documents[0]))}")
        if any(document.get(name) != documents[0].get(name) for name in SAME):
            raise BadInput(f"{path} was measured with other options than {paths[0]}")
    scenes = [scene for document in documents for scene in {r["scene"] for r in document["results"]}]
    for scene in scenes:
        if scenes.count(scene) > 1:
            raise BadInput(f"{scene} is in more than one of the files")


def pool(measurement, fits):
    correlations = {name: [fit[name]["correlation"] for fit in fits] for name in FITS}
    return {"measurement": measurement, "scenes": len(fits),
            **{name: {"mean": sum(values) / len(values), "minimum": min(values)}
               for name, values in correlations.items()}}


def join(documents):
    joined = dict(documents[0])
    joined["results"] = [result for document in documents for result in document["results"]]
    scenes = [fits for document in documents for fits in document["correlation"]["scenes"]]
    by_measurement = {}
    for fits in scenes:
        by_measurement.setdefault(fits["measurement"], []).append(fits)
    joined["correlation"] = {"scenes": scenes, "pooled": [pool(*item) for item in by_measurement.items()]}
    return joined


def main():
    paths = sys.argv[1:]
    if len(paths) < 2 or paths[0].startswith("-"):
        sys.exit(__doc__)
    try:
        documents = [load_document(path) for path in paths]
        require_alike(documents, paths)
        print(json.dumps(join(documents), indent=2))
    except BadInput as error:
        sys.exit(f"join_tables.py: error: {error}")


if __name__ == "__main__":
    main()
