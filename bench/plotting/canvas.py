"""What figures share: matplotlib, colours, panels."""
from .data import BadInput, short_name


def load_matplotlib():
    try:
        import matplotlib
        matplotlib.use("Agg")
        import matplotlib.pyplot as plt
    except ImportError as error:
        raise BadInput("matplotlib is missing (Debian: python3-matplotlib)") from error
    return plt


def builder_colours(names):
    cycle = load_matplotlib().get_cmap("tab10" if len(names) <= 10 else "tab20").colors
    return {name: cycle[i % len(cycle)] for i, name in enumerate(names)}


def panels_of(scenes, heights, draw):
    """A figure with a panel of its own height for each scene, one above the other, and the panels."""
    figure, rows = load_matplotlib().subplots(len(scenes), 1, figsize=(8, 0.7 + sum(heights)), sharex=True,
                                              squeeze=False, gridspec_kw={"height_ratios": heights})
    for axes, (scene, of_scene) in zip(rows[:, 0], scenes.items()):
        draw(axes, of_scene)
        axes.invert_yaxis()
        axes.margins(x=0.12)
        millions = of_scene[0]["triangles"] / 1e6
        axes.set_title(f"{short_name(scene)}, {millions:.2f} M triangles", fontsize=10, loc="left")
        tidy(axes)
    return figure, rows[:, 0]


def tidy(axes):
    axes.spines[["top", "right"]].set_visible(False)
