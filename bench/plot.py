#!/usr/bin/env python3
"""Draws figures from the JSON of `clbvh bench`, `clbvh trace` and `clbvh metrics`.

    plot.py builders  BENCH.json OUT.png   build time against tree quality, one dot a builder
    plot.py stages    BENCH.json OUT.png   where device builders' time goes, a stacked bar a builder
    plot.py speed     BENCH.json OUT.png   build speed relative to one builder, scene by scene
    plot.py bandwidth BENCH.json OUT.png   what stages move a second, beside a copy
    plot.py sweep     SWEEP.json OUT.png   time, and what trees are worth, over `bench --sweep ...`
    plot.py rays      TRACE.json OUT.png   speed of rays relative to one builder, scene by scene
    plot.py predict   METRICS.json OUT.png what SAH, and SAH with EPO, predict of rays beside what they cost

Needs matplotlib (Debian: python3-matplotlib). `plot.py FIGURE --help` lists a figure's options.
"""
import argparse
import sys

sys.dont_write_bytecode = True  # the sources need not be where one may write

from plotting.builders import COSTS, draw_builders  # noqa: E402
from plotting.data import BadInput, load  # noqa: E402
from plotting.prediction import draw_predict  # noqa: E402
from plotting.speeds import draw_rays, draw_speed  # noqa: E402
from plotting.stages import draw_bandwidth, draw_stages  # noqa: E402
from plotting.sweeps import draw_sweep  # noqa: E402


def word_list(text):
    return [word.strip() for word in text.split(",") if word.strip()]


def parse_arguments():
    parser = argparse.ArgumentParser(prog="plot.py", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    figures = parser.add_subparsers(dest="figure", metavar="FIGURE", required=True)

    def add(name, draw, text):
        figure = figures.add_parser(name, help=text, description=text)
        figure.add_argument("input", metavar="BENCH.json", help="what clbvh wrote with --json")
        figure.add_argument("output", metavar="OUT.png", help="the figure; its ending chooses png, svg or pdf")
        figure.add_argument("--part", metavar="NAME", help="the document of that name, where the file holds several")
        figure.set_defaults(draw=draw)
        return figure

    def add_scenes(figure):
        figure.add_argument("--scenes", type=word_list, metavar="A,B", help="only these scenes, in this order")

    def add_leave_out(figure, default):
        figure.add_argument("--leave-out", type=word_list, default=default, metavar="A,B",
                            help=f"builders that are not shown; default: {', '.join(default) or 'none'}")

    builders = add("builders", draw_builders, "Build time against SAH cost: geometric means over the scenes.")
    builders.add_argument("--baseline", default="binned-sah", metavar="ID",
                          help="costs are relative to it; default: %(default)s")
    builders.add_argument("--cost", default="sah", choices=COSTS, help="what is drawn; default: %(default)s")
    builders.add_argument("--line", type=word_list, default=[], metavar="A,B", help="builders that a line joins")
    add_leave_out(builders, ["median"])
    add_scenes(add("stages", draw_stages, "Time of each stage of the device builders, scene by scene."))
    speed = add("speed", draw_speed, "Build speed relative to one builder, scene by scene.")
    speed.add_argument("--baseline", default="ploc", metavar="ID", help="the builder that is 1; default: %(default)s")
    add_leave_out(speed, [])
    add_scenes(speed)
    add_scenes(add("bandwidth", draw_bandwidth, "Bytes that stages move a second, beside a copy on the same device."))
    rays = add("rays", draw_rays, "Speed of rays relative to one builder's trees, scene by scene.")
    rays.add_argument("--baseline", default="binned-sah", metavar="ID",
                      help="the builder that is 1; default: %(default)s")
    rays.add_argument("--rays", metavar="KIND", help="the kind of rays, where the file holds several")
    add_leave_out(rays, [])
    add_scenes(rays)
    predict = add("predict", draw_predict, "Costs of rays, and what SAH, and SAH with EPO, predict of them.")
    predict.add_argument("--measurement", choices=["binary_ns_per_ray", "ns_per_ray"],
                         help="default: the first of these that the file has")
    add_leave_out(predict, [])
    add_scenes(predict)
    add("sweep", draw_sweep, "Time and SAH cost over the values of clbvh bench --sweep; means over the scenes.")
    return parser.parse_args()


def main():
    arguments = parse_arguments()
    try:
        figure = arguments.draw(load(arguments.input, arguments.part), arguments)
        try:
            figure.savefig(arguments.output, dpi=130)
        except (OSError, ValueError) as error:
            raise BadInput(f"cannot write {arguments.output}: {error}") from error
    except BadInput as error:
        sys.exit(f"plot.py: error: {error}")
    except KeyError as error:
        sys.exit(f"plot.py: error: {arguments.input} lacks {error}, which this figure needs")


if __name__ == "__main__":
    main()
