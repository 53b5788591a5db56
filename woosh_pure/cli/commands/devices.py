"""Commands for sensors, lights and voice."""

from __future__ import annotations

import math
import time
from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from rosproto.cli import count, counted, folder_exists, natural, positive
from rosproto.errors import RosTimeout
from rosproto.sentence import say
from woosh_pure.cli.arguments import add_wait, enum_words, png_file, wait_for, word_of, write
from woosh_pure.cli.connection import connect
from woosh_pure.cli.output import Output
from woosh_pure.enums import COLOURS, LedState
from woosh_pure.geometry import Pose2D, yaw_from_quaternion
from woosh_pure.values.state import Image, Imu, LaserScan, PointCloud

if TYPE_CHECKING:
    from woosh_pure.chassis import Chassis


def add_imu(parser: ArgumentParser) -> None:
    add_wait(parser)
    parser.add_argument("-n", "--count", type=count, default=1, metavar="N", help="number of readings (1)")


def run_imu(args: Namespace, out: Output) -> None:
    with connect(args, out) as chassis:
        for index in range(args.count):
            imu = wait_for(chassis.imu, args, out) if index == 0 else chassis.imu.wait(args.wait)
            _show_imu(imu, out)
            (out.result if args.count == 1 else out.record)(imu)


def _show_imu(imu: Imu, out: Output) -> None:
    w, a = imu.angular_velocity, imu.linear_acceleration
    turned = imu.orientation
    yaw = say("none") if turned is None else f"{math.degrees(yaw_from_quaternion(*turned)):.1f}°"
    out.line(
        "rates {rates} rad/s   acceleration {acceleration} m/s²   yaw {yaw}",
        rates=f"{w[0]:+.3f} {w[1]:+.3f} {w[2]:+.3f}",
        acceleration=f"{a[0]:+.3f} {a[1]:+.3f} {a[2]:+.3f}",
        yaw=yaw,
    )


WIDTH = 0.7
"""Metres; the chassis does not tell its own size."""


def add_scan(parser: ArgumentParser) -> None:
    add_wait(parser)
    parser.add_argument(
        "-o", "--png", type=png_file, metavar="FILE", help="draw it, from above, x to the right"
    )
    parser.add_argument(
        "--width", type=positive, default=WIDTH, metavar="M", help=f"of the robot and its lane ({WIDTH:g})"
    )
    parser.add_argument("--map", action="store_true", help="with --png: draw it into the map")


def run_scan(args: Namespace, out: Output) -> None:
    if args.map and not args.png:
        raise ValueError("--map draws the scan into the map: give --png FILE, too")
    from woosh_pure.readings import free_ways, nearest_of, scan_in_base, side_of

    with connect(args, out) as chassis:
        chassis.feed("tf_static").open()
        scan = wait_for(chassis.scan, args, out)
        points = scan_in_base(chassis, scan)
        ways, nearest = free_ways(points, args.width), nearest_of(points)
        out.line(
            "{all} in {frame}, {seeing} see something, {maximum:g} m at most",
            all=counted(scan.ranges.size, "ray", "rays"),
            frame=scan.frame,
            seeing=len(points),
            maximum=scan.range_max,
        )
        if nearest is not None:
            out.line(
                "nearest {metres:.2f} m from the robot's centre, at {degrees:.0f}° ({side})",
                metres=nearest[0],
                degrees=nearest[1],
                side=say(side_of(nearest[1])),
            )
        out.line("free in a lane of {width:g} m, from the robot's centre:", width=args.width)
        for name, distance in ways.items():
            free = "nothing in the way" if math.isinf(distance) else say("{metres:.2f} m", metres=distance)
            out.line(" ", out.cell(name, 8), free)
        file = write(args.png, _draw_scan(chassis, scan, args, out), out) if args.png else None
    out.result(
        {
            "file": file,
            "nearest": ways,
            "lane_width": args.width,
            "nearest_distance": nearest and nearest[0],
            "nearest_degrees": nearest and nearest[1],
            "frame": scan.frame,
            "angle_min": scan.angle_min,
            "angle_increment": scan.angle_increment,
            "range_min": scan.range_min,
            "range_max": scan.range_max,
            "ranges": scan.ranges,
        }
    )


def _draw_scan(chassis: Chassis, scan: LaserScan, args: Namespace, out: Output) -> bytes:
    from woosh_pure.maps.picture import blank_around, chart_png
    from woosh_pure.readings import scan_in_base, scan_in_map

    if not args.map:
        points = scan_in_base(chassis, scan)
        return chart_png(blank_around(points), out, marks=False, pose=Pose2D(0.0, 0.0), scan=points)
    try:
        pose = chassis.pose.wait(args.wait, new=False)
    except RosTimeout as error:
        raise RosTimeout(say("{error}; omit --map to draw it around the robot", error=error)) from error
    with out.working("fetching the map"):
        grid = chassis.get_map()
    return chart_png(grid, out, pose=pose, scan=scan_in_map(chassis, scan, pose))


def add_camera(parser: ArgumentParser) -> None:
    add_wait(parser)
    parser.add_argument(
        "--depth", action="store_true", help="the depth image: near is bright, not measured is black"
    )
    parser.add_argument(
        "--millimetres", action="store_true", help="with --depth: as data, 16-bit grey in mm (looks black)"
    )
    where = parser.add_mutually_exclusive_group()
    where.add_argument(
        "-o",
        "--png",
        type=png_file,
        metavar="FILE",
        help="where to write it (default: camera-DATE-TIME.png in this folder)",
    )
    where.add_argument("--no-file", action="store_true", help="write nothing, only describe it")


def run_camera(args: Namespace, out: Output) -> None:
    if args.millimetres and not args.depth:
        raise ValueError("--millimetres applies to the depth image: give --depth, too")
    with connect(args, out) as chassis:
        image = wait_for(chassis.depth if args.depth else chassis.camera, args, out)
    height, width = image.pixels.shape[:2]
    facts = {"width": width, "height": height, "encoding": image.encoding, "frame": image.frame}
    out.line(say("{width} x {height} {encoding} in {frame}", **facts))
    if args.depth:
        import numpy as np

        metres = image.depth_metres()
        seen = metres[np.isfinite(metres) & (metres > 0.0)]
        facts["nearest"] = nearest = float(seen.min()) if seen.size else None
        facts["farthest"] = farthest = float(seen.max()) if seen.size else None
        out.line(
            "nothing measured"
            if nearest is None
            else say("from {nearest:.2f} m to {farthest:.2f} m", nearest=nearest, farthest=farthest)
        )
    if not args.no_file:
        file = args.png or _free_name("depth" if args.depth else "camera")
        facts["file"] = write(file, image_png(image, millimetres=args.millimetres), out)
    out.result(facts)


def _free_name(kind: str) -> Path:
    """Return an unused file name with the time."""
    stem = f"{kind}-{time.strftime('%Y%m%d-%H%M%S')}"
    path, number = Path(f"{stem}.png"), 2
    while path.exists():
        path, number = Path(f"{stem}-{number}.png"), number + 1
    return path


def image_png(image: Image, *, millimetres: bool = False) -> bytes:
    """Convert a camera image to PNG; depth is scaled to its range: near is bright, not measured is black.

    Args:
        image: The camera's image.
        millimetres: True for depth as 16-bit grey in mm, 0 for not measured. It looks black.

    Raises:
        ValueError: The encoding is not supported, or not that of a depth image.
    """
    from rosproto.numeric import depth_millimetres, encode_png

    return encode_png(depth_millimetres(image.depth_metres()) if millimetres else image.visible())


def add_cloud(parser: ArgumentParser) -> None:
    add_wait(parser)
    parser.add_argument("--obstacles", action="store_true", help="only obstacles, the ground removed")
    parser.add_argument(
        "-o", "--ply", type=folder_exists, metavar="FILE", help="where to write it (binary PLY, m)"
    )


def run_cloud(args: Namespace, out: Output) -> None:
    with connect(args, out) as chassis:
        cloud = wait_for(chassis.obstacle_points if args.obstacles else chassis.points, args, out)
    points = cloud.points
    out.line("{points} in {frame}", points=counted(len(points), "point", "points"), frame=cloud.frame)
    low, high = (points.min(axis=0), points.max(axis=0)) if len(points) else (None, None)
    if low is not None and high is not None:
        for axis, a, b in zip("xyz", low, high, strict=True):
            out.line(" ", say("{axis} {lowest:+.3f} to {highest:+.3f} m", axis=axis, lowest=a, highest=b))
    file = write(args.ply, ply(cloud), out) if args.ply else None
    out.result({"points": len(points), "frame": cloud.frame, "low": low, "high": high, "file": file})


def ply(cloud: PointCloud) -> bytes:
    """Return a binary PLY file (paulbourke.net/dataformats/ply): x, y, z float in m."""
    head = (
        "ply",
        "format binary_little_endian 1.0",
        f"comment frame {cloud.frame}",
        f"element vertex {len(cloud.points)}",
        *(f"property float {axis}" for axis in "xyz"),
        "end_header",
        "",
    )
    return "\n".join(head).encode("ascii", "replace") + cloud.points.astype("<f4").tobytes()


def add_led(parser: ArgumentParser) -> None:
    parser.add_argument(
        "state", nargs="?", help="a state of the strip, see --list; none: nothing of its own; or a colour"
    )
    parser.add_argument(
        "--color", metavar="COLOUR", help=f"three hexadecimal bytes, ff8000, or {', '.join(COLOURS)}"
    )
    parser.add_argument(
        "--strip", choices=("base", "shelf", "both"), default="base", help="which strip (base)"
    )
    parser.add_argument("--module", type=natural, default=0, metavar="N", help="0 all, 1 to 8 one module")
    parser.add_argument("--urgency", action="store_true", help='show "under maintenance"')
    parser.add_argument("--abnormal", action="store_true", help='show "fault"')
    parser.add_argument("--list", action="store_true", help="list the states; asks no chassis")


def run_led(args: Namespace, out: Output) -> None:
    if args.list:
        words = enum_words(LedState)
        for word in words:
            out.line("{word}", word=word)
        out.result({word: int(LedState[word_of(word)]) for word in words})
        return
    from woosh_pure.peripherals import light_of

    if args.state is None and not (args.color or args.urgency or args.abnormal):
        raise ValueError("give a state (see --list) or --color COLOUR; what the strip shows is not reported")
    state, color = light_of("none" if args.state is None else args.state, args.color, args.module)
    [name] = enum_words([state])
    with connect(args, out) as chassis, out.working("looking for the light strip"):
        chassis.light(
            state,
            color=color,
            strip=args.strip,
            module=args.module,
            urgency=args.urgency,
            abnormal=args.abnormal,
        )
    shown = "{strip} strip: {state}" if color is None else "{strip} strip: {state}, colour {color:06x}"
    out.line(shown, strip=say(args.strip), state=name, color=color)
    out.result({"strip": args.strip, "state": name, "color": color, "module": args.module})


def add_say(parser: ArgumentParser) -> None:
    parser.add_argument("text", nargs="+", help="what to say")


def run_say(args: Namespace, out: Output) -> None:
    text = " ".join(args.text)
    if not text.strip():
        raise ValueError("the text is empty; give the words to say")
    with connect(args, out) as chassis, out.working("speaking"):
        chassis.say(text)
    out.line("said: {text}", text=text)
    out.result({"said": text})
