"""`woosh plan X Y DEGREES` or `woosh plan A1`: plan a path without driving."""

from __future__ import annotations

import itertools
from argparse import ArgumentParser, Namespace

from rosproto.cli import counted, to_float
from rosproto.sentence import say
from woosh_pure.cli.arguments import POSE, mark_missing, marks_here, number, png_file, pose, write
from woosh_pure.cli.connection import connect
from woosh_pure.cli.output import Output
from woosh_pure.geometry import Pose2D

HELP = "plan a path without driving it (exit code 1: there is no way)"


def add_arguments(parser: ArgumentParser) -> None:
    """See `Command`."""
    parser.add_argument("mark", metavar="X|MARK", help="m, in the map; or a mark whose pose is known here")
    parser.add_argument("y", nargs="?", type=number, metavar="Y", help="m, in the map")
    parser.add_argument(
        "degrees", nargs="?", type=number, metavar="DEGREES", help="heading, counter-clockwise from x"
    )
    parser.add_argument(
        "--start", nargs=3, type=number, metavar=POSE, help="from here (default: where the robot is)"
    )
    parser.add_argument(
        "--tolerance", type=number, default=0.0, metavar="M", help="how far the end may be moved (0)"
    )
    parser.add_argument("-o", "--png", type=png_file, metavar="FILE", help="draw it into the map")


def run(args: Namespace, out: Output) -> int:
    """See `Command`."""
    file, target = None, _target(args)
    with connect(args, out) as chassis:
        start = pose(args.start) if args.start else None
        with out.working("planning"):
            path = chassis.plan(target, start, tolerance=args.tolerance)
        if args.png:
            from woosh_pure.cli.picture import chart_png

            with out.working("fetching the map"):
                grid = chassis.get_map()
            picture = chart_png(grid, out, pose=start or chassis.pose.latest, path=path)
            file = write(args.png, picture, out)
    length = sum(a.distance_to(b) for a, b in itertools.pairwise(path))
    out.line(
        say("{points}, {metres:.2f} m", points=counted(len(path), "point"), metres=length)
        if path
        else "there is no way"
    )
    for point in path if len(path) <= 20 else (*path[:10], *path[-10:]):
        out.line(" ", str(point))
    out.result({"ok": bool(path), "length": length, "path": path, "file": file})
    return 0 if path else 1


def _target(args: Namespace) -> Pose2D:
    """Return the pose of three numbers or of a locally known mark: the chassis reports no poses of marks."""
    if args.degrees is not None:
        return pose((to_float(args.mark), args.y, args.degrees)).require_finite()
    target = marks_here(args).get(args.mark) if args.y is None else None
    if target is None:
        wrong = say("{place}: give X Y DEGREES, or a mark whose pose is known here", place=args.mark)
        raise ValueError(mark_missing(args, wrong))
    return target
