"""`woosh goto A1` or `woosh goto --pose X Y DEGREES`."""

from __future__ import annotations

import math
from argparse import ArgumentParser, Namespace

from ..connection import connect, follow
from ..output import Output

HELP = "drive to a mark, or to a pose in the map"


def add_arguments(parser: ArgumentParser) -> None:
    """See `registry`."""
    parser.add_argument("mark", nargs="?", help="name of the mark, as on the chassis's map")
    parser.add_argument("--pose", nargs=3, type=float, metavar=("X", "Y", "DEGREES"), help="m, m and degrees")
    parser.add_argument(
        "--timeout", type=float, default=300.0, metavar="S", help="then it is cancelled (300)"
    )


def run(args: Namespace, out: Output) -> int:
    """See `registry`."""
    if (args.mark is None) == (args.pose is None):
        raise ValueError("give a mark or --pose X Y DEGREES, and not both")
    with connect(args, out) as chassis:
        if args.mark is not None:
            handle, where = chassis.go_to_mark(args.mark), f"mark {args.mark}"
        else:
            x, y, degrees = args.pose
            handle, where = chassis.go_to(x, y, math.radians(degrees)), f"{x} m, {y} m, {degrees}°"  # type: ignore[assignment]
        outcome = follow(handle, out, f"going to {where}", args.timeout)
        out.line(outcome.sentence())
        pose = chassis.pose.latest
        out.line(f"now at {pose or 'a pose that was not heard'}")
        out.result({"outcome": outcome.kind.value, "seconds": round(outcome.seconds, 2), "pose": str(pose)})
    return 0
