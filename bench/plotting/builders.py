"""Build time against what trees are worth."""
from .canvas import load_matplotlib, tidy
from .data import BadInput, find_builder, geometric_mean, kind_of, of_scenes, per_million, without_sweeps

KIND_COLOURS = {"device": "#2171b5", "host": "#fd8d3c", "peer": "#969696"}
KIND_LABELS = {"device": "OpenCL device", "host": "host", "peer": "Embree 3"}
LABEL_PLACES = [(6, 3, "left"), (6, -10, "left"), (-6, 3, "right"), (-6, -10, "right"), (6, 15, "left"),
                (6, -22, "left"), (-6, 15, "right"), (-6, -22, "right")]


COSTS = {"sah": "SAH cost", "binary_ns_per_ray": "time of rays, two children at a time,",
         "ns_per_ray": "time of rays, eight children at a time,"}


def collect_builders(results, cost, baseline, path):
    """Builder to (kind, milliseconds per million triangles, cost over the baseline's), geometric means over scenes."""
    points = {}
    for of_scene in of_scenes(results, None, path).values():
        unit = find_builder(of_scene, baseline, path).get(cost)
        if unit is None:
            raise BadInput(f"{path} has no {cost}; run clbvh bench with --rays")
        for result in of_scene:
            if result.get(cost) is None:
                continue  # a peer whose tree cannot be read
            times, costs = points.setdefault(result["builder"], (kind_of(result), [], []))[1:]
            times.append(per_million(result))
            costs.append(result[cost] / unit)
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


def draw_builders(results, arguments):
    results = without_sweeps(results, arguments.input)
    points = collect_builders(results, arguments.cost, arguments.baseline, arguments.input)
    points = {name: point for name, point in points.items() if name not in arguments.leave_out}
    if not points:
        raise BadInput(f"--leave-out leaves no builder of {arguments.input}")
    figure, axes = load_matplotlib().subplots(figsize=(8, 4.2))
    for kind, colour in KIND_COLOURS.items():
        chosen = [p for p in points.values() if p[0] == kind]
        if chosen:
            axes.scatter([p[1] for p in chosen], [p[2] for p in chosen], color=colour, label=KIND_LABELS[kind], s=36)
    line = [points[name] for name in arguments.line if name in points]
    axes.plot([p[1] for p in line], [p[2] for p in line], color="#41ab5d", zorder=0)
    axes.set_xscale("log")
    axes.set_xlabel("milliseconds per million triangles (lower is faster)")
    axes.set_ylabel(f"{COSTS[arguments.cost]} \nover {arguments.baseline}'s (lower is better)")
    axes.grid(True, which="both", alpha=0.25)
    tidy(axes)
    axes.legend(frameon=False, fontsize=8)
    figure.tight_layout()
    add_labels(figure, axes, points)
    return figure
