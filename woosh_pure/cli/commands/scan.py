"""`woosh scan`: the fused lidars."""

from __future__ import annotations

import math
from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING

from rosproto.cli import counted
from rosproto.errors import RosTimeout
from rosproto.sentence import say
from woosh_pure.cli.arguments import add_wait, png_file, positive, wait_for, write
from woosh_pure.cli.connection import connect
from woosh_pure.cli.output import Output
from woosh_pure.geometry import Pose2D
from woosh_pure.values.state import LaserScan

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from woosh_pure.chassis import Chassis

HELP = "show the lidar scan: the nearest thing, how far it is free on each side, or a picture"
WIDTH = 0.7
"""Metres; the chassis does not tell its own size."""


def add_arguments(parser: ArgumentParser) -> None:
    """See `Command`."""
    add_wait(parser)
    parser.add_argument(
        "-o", "--png", type=png_file, metavar="FILE", help="draw it, from above, x to the right"
    )
    parser.add_argument(
        "--width", type=positive, default=WIDTH, metavar="M", help=f"of the robot and its lane ({WIDTH:g})"
    )
    parser.add_argument("--map", action="store_true", help="with --png: draw it into the map")


def run(args: Namespace, out: Output) -> int:
    """See `Command`."""
    if args.map and not args.png:
        raise ValueError("--map draws the scan into the map: give --png FILE too")
    from woosh_pure.readings import scan_in_base

    with connect(args, out) as chassis:
        chassis.feed("tf_static").open()
        scan = wait_for(chassis.scan, args, out)
        points = scan_in_base(chassis, scan)
        ways, nearest = free_ways(points, args.width), nearest_of(points)
        out.line(
            say(
                "{all} in {frame}, {seeing} see something, {most:g} m at most",
                all=counted(scan.ranges.size, "ray"),
                frame=scan.frame,
                seeing=len(points),
                most=scan.range_max,
            )
        )
        if nearest is not None:
            out.line(
                say(
                    "nearest {metres:.2f} m from the robot's middle, at {degrees:.0f}° ({side})",
                    metres=nearest[0],
                    degrees=nearest[1],
                    side=say(_word(nearest[1])),
                )
            )
        out.line(say("free in a lane of {width:g} m, from the robot's middle:", width=args.width))
        for name, distance in ways.items():
            free = "nothing in the way" if math.isinf(distance) else f"{distance:.2f} m"
            out.line(" ", out.cell(name, 8), free)
        file = write(args.png, _draw(chassis, scan, args, out), out) if args.png else None
    out.result(
        {
            "file": file,
            "nearest": ways,
            "lane_width": args.width,
            "nearest_distance": nearest and nearest[0],
            "nearest_degrees": nearest and nearest[1],
            "frame": scan.frame,
            **_document(scan),
        }
    )
    return 0


def _word(degrees: float) -> str:
    """Return the robot's side in a direction."""
    sides = ("ahead", "ahead left", "left", "behind left", "behind", "behind right", "right", "ahead right")
    return sides[round(degrees / 45.0) % 8]


def free_ways(points: NDArray[np.floating], width: float) -> dict[str, float]:
    """Return the distance in m from base_link to the first obstacle, in its four directions.

    Only points in a lane of `width` count: a wall beside the robot is not ahead.

    Args:
        points: (N, 2) m in base_link.
        width: Width of the lane, m.
    """
    found = {}
    for name, along, across in (
        ("ahead", points[:, 0], points[:, 1]),
        ("left", points[:, 1], points[:, 0]),
        ("right", -points[:, 1], points[:, 0]),
        ("behind", -points[:, 0], points[:, 1]),
    ):
        here = along[(along > 0.0) & (abs(across) <= width / 2.0)]
        found[name] = float(here.min()) if here.size else math.inf
    return found


def nearest_of(points: NDArray[np.floating]) -> tuple[float, float] | None:
    """Return distance (m) and direction (degrees, 0 ahead, left positive) of the nearest point."""
    import numpy as np

    if not len(points):
        return None
    distances = np.hypot(points[:, 0], points[:, 1])
    x, y = points[int(distances.argmin())]
    return float(distances.min()), math.degrees(math.atan2(y, x))


def _draw(chassis: Chassis, scan: LaserScan, args: Namespace, out: Output) -> bytes:
    from woosh_pure.cli.picture import blank_around, chart_png
    from woosh_pure.readings import scan_in_base, scan_in_map

    if not args.map:
        points = scan_in_base(chassis, scan)
        return chart_png(blank_around(points), out, marks=False, pose=Pose2D(0.0, 0.0), scan=points)
    try:
        pose = chassis.pose.wait(args.wait, new=False)
    except RosTimeout as error:
        raise RosTimeout(say("{error}; leave --map out to draw it around the robot", error=error)) from error
    with out.working("fetching the map"):
        grid = chassis.get_map()
    return chart_png(grid, out, pose=pose, scan=scan_in_map(chassis, scan, pose))


def _document(scan: LaserScan) -> dict[str, object]:
    return {
        "angle_min": scan.angle_min,
        "angle_increment": scan.angle_increment,
        "range_min": scan.range_min,
        "range_max": scan.range_max,
        "ranges": scan.ranges,
    }
