"""What the JSON of clbvh holds."""
import json
import math


class BadInput(Exception):
    """What is wrong with the input, for people."""


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
