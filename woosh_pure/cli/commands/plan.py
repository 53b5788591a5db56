"""`woosh plan X Y DEGREES`: a path, without driving it."""

from __future__ import annotations

import itertools
from argparse import ArgumentParser, Namespace

from rosproto.cli import counted
from rosproto.sentence import say
from woosh_pure.cli.arguments import POSE, add_pose, folder_exists, number, pose, write
from woosh_pure.cli.connection import connect
from woosh_pure.cli.output import Output

HELP = "plan a path without driving it (exit code 1: there is no way)"


def add_arguments(parser: ArgumentParser) -> None:
    """See `Command`."""
    add_pose(parser)
    parser.add_argument(
        "--start", nargs=3, type=number, metavar=POSE, help="from here (default: where the robot is)"
    )
    parser.add_argument(
        "--tolerance", type=number, default=0.0, metavar="M", help="how far the end may be moved (0)"
    )
    parser.add_argument("--png", type=folder_exists, metavar="FILE", help="draw it into the map")


def run(args: Namespace, out: Output) -> int:
    """See `Command`."""
    file = None
    with connect(args, out) as chassis:
        start = pose(args.start) if args.start else None
        with out.working("planning"):
            path = chassis.plan(pose((args.x, args.y, args.degrees)), start, tolerance=args.tolerance)
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
