"""`woosh scan`: the fused lidars."""

from __future__ import annotations

import math
from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING

from rosproto.errors import RosTimeout

from ..arguments import add_wait, folder_exists, wait_for, write
from ..connection import connect
from ..output import Output

if TYPE_CHECKING:
    from woosh_pure.chassis import Chassis
    from woosh_pure.values import LaserScan

HELP = "show the lidar scan: how near the nearest thing is, or a picture"
_SECTORS = ("behind", "right", "ahead", "left", "behind")


def add_arguments(parser: ArgumentParser) -> None:
    """See `registry`."""
    add_wait(parser)
    parser.add_argument(
        "--png", type=folder_exists, metavar="FILE", help="draw it, from above, x to the right"
    )
    parser.add_argument("--map", action="store_true", help="with --png: draw it into the map")


def run(args: Namespace, out: Output) -> int:
    """See `registry`."""
    if args.map and not args.png:
        raise ValueError("--map draws the scan into the map: give --png FILE too")
    with connect(args, out) as chassis:
        chassis.feed("tf_static").open()
        scan = wait_for(chassis.scan, args, out)
        nearest = _nearest(chassis, scan)
        valid = len(scan.points())
        out.line(
            f"{scan.ranges.size} rays in {scan.frame}, {valid} see something, {scan.range_max:g} m at most"
        )
        for name, distance in nearest.items():
            out.line(f"  {name:8s} {'nothing' if math.isinf(distance) else f'{distance:.2f} m'}")
        file = write(args.png, _draw(chassis, scan, args, out), out) if args.png else None
    out.result({"file": file, "nearest": nearest, "frame": scan.frame, **_document(scan)})
    return 0


def _nearest(chassis: Chassis, scan: LaserScan) -> dict[str, float]:
    """Shortest distance in each of four directions of base_link, m."""
    import numpy as np

    from ..scene import scan_in_base

    points = scan_in_base(chassis, scan)
    found = dict.fromkeys(("ahead", "left", "right", "behind"), math.inf)
    distances = np.hypot(points[:, 0], points[:, 1])
    sectors = np.rint(np.arctan2(points[:, 1], points[:, 0]) / (math.pi / 2.0)).astype(int) + 2
    for index, name in enumerate(_SECTORS):
        here = distances[sectors == index]
        if here.size:
            found[name] = min(found[name], float(here.min()))
    return found


def _draw(chassis: Chassis, scan: LaserScan, args: Namespace, out: Output) -> bytes:
    from woosh_pure.geometry import Pose2D

    from ..picture import blank_around, picture_of
    from ..png import encode_png
    from ..scene import scan_in_base, scan_in_map

    if not args.map:
        points = scan_in_base(chassis, scan)
        return encode_png(picture_of(blank_around(points), pose=Pose2D(0.0, 0.0), scan=points))
    try:
        pose = chassis.pose.wait(args.wait, new=False)
    except RosTimeout as error:
        raise RosTimeout(f"{error}; leave --map out to draw it around the robot") from error
    with out.working("fetching the map"):
        grid = chassis.get_map()
    return encode_png(picture_of(grid, pose=pose, scan=scan_in_map(chassis, scan, pose)))


def _document(scan: LaserScan) -> dict[str, object]:
    return {
        "angle_min": scan.angle_min,
        "angle_increment": scan.angle_increment,
        "range_min": scan.range_min,
        "range_max": scan.range_max,
        "ranges": scan.ranges,
    }
