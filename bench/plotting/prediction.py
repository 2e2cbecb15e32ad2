"""What SAH, and SAH with EPO, predict of rays, beside what the rays cost. After Aila, Karras, Laine 2013, figure 1."""
from .canvas import load_matplotlib, tidy
from .data import BadInput, of_scenes, short_name

MEASUREMENTS = {"binary_ns_per_ray": "ns/ray, two children at a time", "ns_per_ray": "ns/ray"}
FEWEST_TREES = 4  # as clbvh metrics has it: fewer lie on a line too easily
PREDICTIONS = {"SAH": ("#969696", "s"), "SAH+EPO": ("#2171b5", "o")}
MEASURED_COLOUR = "#fd8d3c"


def choose_measurement(results, wanted, path):
    for name in [wanted] if wanted else MEASUREMENTS:
        if all(name in r and "epo" in r for r in results):
            return name
    raise BadInput(f"{path} has no EPO, or rays that were not measured so; draw what clbvh metrics wrote")


def mean(values):
    return sum(values) / len(values)


def covariance(x, y):
    return mean([a * b for a, b in zip(x, y)]) - mean(x) * mean(y)


def correlation(x, y):
    scale = (covariance(x, x) * covariance(y, y)) ** 0.5
    return covariance(x, y) / scale if scale > 0 else 0.0


def on_scale_of(measured, metric):
    """The metric along the straight line that fits the measurements best."""
    variance = covariance(metric, metric)
    slope = covariance(metric, measured) / variance if variance > 0 else 0.0
    return [mean(measured) + slope * (value - mean(metric)) for value in metric]


def best_alpha(sah, epo, measured):
    """To the hundredth, as the paper has it."""
    def quality(alpha):
        return correlation([(1 - alpha) * s + alpha * e for s, e in zip(sah, epo)], measured)
    return max((i / 100 for i in range(101)), key=quality)


def predictions_of(results, measured):
    """Name of a prediction to its values, in ns/ray, and to a text about it."""
    sah = [r["sah"] for r in results]
    epo = [r["epo"] for r in results]
    alpha = best_alpha(sah, epo, measured)
    both = [(1 - alpha) * s + alpha * e for s, e in zip(sah, epo)]
    return {"SAH": (on_scale_of(measured, sah), f"SAH: {correlation(sah, measured):.3f}"),
            "SAH+EPO": (on_scale_of(measured, both),
                        f"SAH+EPO: {correlation(both, measured):.3f}, alpha {alpha:.2f}")}


def draw_by_builder(axes, names, measured, predictions):
    axes.bar(range(len(names)), measured, color=MEASURED_COLOUR, alpha=0.45, width=0.75, label="measured")
    for name, (values, _) in predictions.items():
        colour, marker = PREDICTIONS[name]
        axes.plot(range(len(names)), values, color=colour, marker=marker, markersize=4, linewidth=1, label=name)
    axes.set_xticks(range(len(names)), names, rotation=90, fontsize=7)
    axes.set_ylim(0, 1.1 * max(measured))
    tidy(axes)


def draw_against_measured(axes, measured, predictions):
    """Dots on the diagonal are predicted right."""
    for name, (values, text) in predictions.items():
        colour, marker = PREDICTIONS[name]
        axes.scatter(measured, values, color=colour, marker=marker, s=16, label=text)
    ends = [min(measured), max(measured)]
    room = 0.08 * (ends[1] - ends[0])
    ends = [ends[0] - room, ends[1] + room]
    axes.plot(ends, ends, color="black", linewidth=0.8)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel("measured")
    axes.legend(frameon=False, fontsize=7, loc="upper left")
    tidy(axes)


def draw_predict(results, arguments):
    measurement = choose_measurement(results, arguments.measurement, arguments.input)
    scenes = of_scenes(results, arguments.scenes, arguments.input)
    figure, panels = load_matplotlib().subplots(2, len(scenes), figsize=(max(4.5, 3.1 * len(scenes)), 6.4),
                                                squeeze=False)
    for (above, below), (scene, of_scene) in zip(panels.T, scenes.items()):
        chosen = [r for r in of_scene if r["builder"] not in arguments.leave_out]
        if len(chosen) < FEWEST_TREES:
            raise BadInput(f"{arguments.input} has {len(chosen)} builders to show on {scene}; predictions need "
                           f"{FEWEST_TREES}")
        measured = [r[measurement] for r in chosen]
        predictions = predictions_of(chosen, measured)
        draw_by_builder(above, [r["builder"] for r in chosen], measured, predictions)
        above.set_title(short_name(scene), fontsize=10)
        draw_against_measured(below, measured, predictions)
    panels[0][0].set_ylabel(MEASUREMENTS[measurement])
    panels[1][0].set_ylabel("predicted")
    handles, labels = panels[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="upper center", ncol=3, frameon=False, fontsize=8)
    figure.tight_layout(rect=(0, 0, 1, 0.96))
    return figure
