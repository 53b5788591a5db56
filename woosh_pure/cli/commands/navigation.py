"""Commands for the navigation: localisation, paths, costmaps, outline, behaviour."""

from __future__ import annotations

import itertools
import math
from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING

from rosproto.cli import DONE, FAILED, counted, heading, metres, natural, positive, seconds
from rosproto.errors import RosTimeout
from rosproto.sentence import say
from woosh_pure.cli.arguments import (
    POSE,
    add_wait,
    corners,
    mark_missing,
    marks_here,
    png_file,
    pose,
    pose_of,
    wait_for,
    word_of,
    write,
)
from woosh_pure.cli.connection import connect
from woosh_pure.cli.output import Output
from woosh_pure.enums import NavDirection, NavigationMode
from woosh_pure.geometry import Footprint, Pose2D
from woosh_pure.reasons import ReasonKey

if TYPE_CHECKING:
    from woosh_pure.chassis import Chassis


def add_localization(parser: ArgumentParser) -> None:
    verbs = parser.add_subparsers(dest="verb", metavar="VERB", required=True)
    show = verbs.add_parser("show", help="its estimated position and how sure it is")
    add_wait(show)
    verbs.add_parser("start", help="start the localisation module")
    verbs.add_parser("stop", help="stop it")
    tell = verbs.add_parser("pose", help="set the position of the robot, for example after power-up")
    # Three arguments: argparse cannot describe one positional of three values.
    tell.add_argument("x", type=metres, metavar="X", help="m, in the map")
    tell.add_argument("y", type=metres, metavar="Y", help="m, in the map")
    tell.add_argument("degrees", type=heading, metavar="DEGREES", help="heading, counter-clockwise from x")
    tell.add_argument("--deviation", type=positive, default=0.25, metavar="M", help="1 sigma (0.25)")
    tell.add_argument("--yaw-deviation", type=positive, default=15.0, metavar="DEGREES", help="1 sigma (15)")
    add_wait(tell)


def run_localization(args: Namespace, out: Output) -> int:
    with connect(args, out) as chassis:
        if args.verb == "show":
            estimate = wait_for(chassis.localization, args, out)
            sigma = [math.sqrt(max(0.0, estimate.covariance[i, i])) for i in (0, 1, 5)]
            out.line(str(estimate.pose))
            deviation = "1 sigma: {x:.3f} m, {y:.3f} m, {yaw:.1f}°"
            out.line(deviation, x=sigma[0], y=sigma[1], yaw=math.degrees(sigma[2]))
            out.result({"pose": estimate.pose, "deviation": sigma})
        elif args.verb == "pose":
            where = pose((args.x, args.y, args.degrees))
            was_lost = _is_lost(chassis)
            with out.working("sending the position"):
                chassis.set_pose(
                    where,
                    position_deviation=args.deviation,
                    yaw_deviation=math.radians(args.yaw_deviation),
                )
            out.line("position sent: {where}", where=where)
            with out.working("waiting for the localisation"):
                taken = _is_taken(chassis, where, args.wait, was_lost=was_lost)
            here = chassis.pose.latest
            if taken:
                out.line("the robot has taken it: it reports {where}", where=here)
            else:
                where_now = here or say("a pose that was not heard")
                out.line("the robot has NOT taken it: it reports {where}; check the numbers", where=where_now)
            out.result({"ok": taken, "told": where, "pose": here})
            return DONE if taken else FAILED
        else:
            with out.working("asking the localisation"):
                chassis.start_localization(args.verb == "start")
            out.line("localisation: {verb}", verb=args.verb)
            out.result({"done": args.verb})
        return DONE


_NEAR_METRES, _NEAR_RADIANS = 0.3, 0.35
"""How near a reported pose is to the one that was taken, as on the page."""


def _is_lost(chassis: Chassis) -> bool:
    return any(reason.key is ReasonKey.NOT_LOCALISED for reason in chassis.readiness().reasons)


def _is_taken(chassis: Chassis, told: Pose2D, timeout: float, *, was_lost: bool) -> bool:
    """Wait until the robot reports the pose that it was told; one that was lost may report one beside it."""

    def accept(pose: Pose2D) -> bool:
        near = pose.distance_to(told) <= _NEAR_METRES and abs(pose.angle_to(told)) <= _NEAR_RADIANS
        return (near or was_lost) and not _is_lost(chassis)

    try:
        chassis.pose.wait_for(accept, timeout)
    except RosTimeout:
        return False
    return True


def add_plan(parser: ArgumentParser) -> None:
    parser.add_argument("mark", metavar="X|MARK", help="m, in the map; or a mark whose pose is known here")
    parser.add_argument("y", nargs="?", type=metres, metavar="Y", help="m, in the map")
    parser.add_argument(
        "degrees", nargs="?", type=heading, metavar="DEGREES", help="heading, counter-clockwise from x"
    )
    parser.add_argument("--start", nargs=3, metavar=POSE, help="from here (default: where the robot is)")
    parser.add_argument(
        "--tolerance", type=seconds, default=0.0, metavar="M", help="how far the end may be moved (0)"
    )
    parser.add_argument("-o", "--png", type=png_file, metavar="FILE", help="draw it into the map")


def run_plan(args: Namespace, out: Output) -> int:
    file, target = None, _plan_target(args)
    with connect(args, out) as chassis:
        start = pose_of(args.start) if args.start else None
        with out.working("planning"):
            path = chassis.plan(target, start, tolerance=args.tolerance)
        if args.png:
            from woosh_pure.maps.picture import chart_png

            with out.working("fetching the map"):
                grid = chassis.get_map()
            picture = chart_png(grid, out, pose=start or chassis.pose.latest, path=path)
            file = write(args.png, picture, out)
    length = sum(a.distance_to(b) for a, b in itertools.pairwise(path))
    out.line(
        say("{points}, {metres:.2f} m", points=counted(len(path), "point", "points"), metres=length)
        if path
        else "there is no path"
    )
    for point in path if len(path) <= 20 else (*path[:10], *path[-10:]):
        out.line(" ", str(point))
    out.result({"ok": bool(path), "length": length, "path": path, "file": file})
    return 0 if path else 1


def _plan_target(args: Namespace) -> Pose2D:
    """Return the pose of three numbers or of a locally known mark: the chassis reports no poses of marks."""
    if args.degrees is not None:
        return pose((metres(args.mark), args.y, args.degrees)).require_finite()
    mark = marks_here(args).get(args.mark) if args.y is None else None
    if mark is None or mark.pose is None:
        wrong = say("{place}: give X Y DEGREES, or a mark whose pose is known here", place=args.mark)
        raise ValueError(mark_missing(args, wrong, args.mark))
    return mark.pose


_COSTMAP_SAID = {
    "on": "obstacles enter the costmaps",
    "off": "obstacles are NO LONGER detected",
    "clear": "the obstacles seen so far are forgotten",
}


def add_costmap(parser: ArgumentParser) -> None:
    parser.add_argument(
        "setting", choices=("on", "off", "clear"), help="off: obstacles are no longer detected"
    )


def run_costmap(args: Namespace, out: Output) -> None:
    with connect(args, out) as chassis, out.working("asking the navigation"):
        if args.setting == "clear":
            chassis.clear_costmaps()
        else:
            chassis.enable_costmaps(args.setting == "on")
    out.line(_COSTMAP_SAID[args.setting])
    out.result({"done": args.setting})


def add_footprint(parser: ArgumentParser) -> None:
    shape = parser.add_mutually_exclusive_group(required=True)
    shape.add_argument("--rectangle", nargs=2, type=positive, metavar=("LENGTH", "WIDTH"), help="m")
    shape.add_argument("--circle", type=positive, metavar="RADIUS", help="m")
    shape.add_argument(
        "--points",
        metavar="CORNERS",
        help='corners in order, m, in base_link, as one argument: "0.4,0.3 -0.4,0.3 -0.4,-0.3 0.4,-0.3"',
    )
    parser.add_argument("--padding", type=seconds, default=0.0, metavar="M", help="added outwards (0)")
    which = parser.add_mutually_exclusive_group()
    which.add_argument("--local", action="store_true", help="only for avoiding obstacles nearby")
    which.add_argument("--global", dest="global_", action="store_true", help="only for planning")


def run_footprint(args: Namespace, out: Output) -> None:
    shape = _footprint_shape(args)
    with connect(args, out) as chassis, out.working("looking for the navigation"):
        outline = chassis.set_footprint(
            shape, padding=args.padding, local=not args.global_, global_=not args.local
        )
    out.line(
        "outline of {count} corners: inner radius {inscribed_radius:.3f} m, outer "
        "{circumscribed_radius:.3f} m",
        count=len(outline.points),
        inscribed_radius=outline.inscribed_radius,
        circumscribed_radius=outline.circumscribed_radius,
    )
    out.result({"points": outline.points, "local": not args.global_, "global": not args.local})


def _footprint_shape(args: Namespace) -> Footprint:
    if args.rectangle:
        return Footprint.rectangle(*args.rectangle)
    if args.circle is not None:
        return Footprint.circle(args.circle)
    return Footprint.from_points(corners(args.points))


MODES = ("fuzzy-avoidance", "precise-avoidance", "stop-and-wait", "wait-then-avoid")
DIRECTIONS = ("chassis-decides", "forward", "backward", "along-path")


def add_mode(parser: ArgumentParser) -> None:
    parser.add_argument("mode", choices=MODES, help="what to do about an obstacle")
    parser.add_argument(
        "--waiting-timeout",
        type=seconds,
        metavar="S",
        help="how long wait-then-avoid waits (required there; 0 may mean not at all)",
    )
    parser.add_argument(
        "--max-speed", type=seconds, default=0.0, metavar="M/S", help="0 keeps the configured one"
    )
    parser.add_argument("--passage", type=natural, default=0, metavar="ID", help="passage concerned (0)")
    parser.add_argument("--permitted", action="store_true", help="a changed path may be followed")
    parser.add_argument(
        "--capacity", type=natural, default=0, metavar="N", help="vehicles in the passage (0)"
    )
    parser.add_argument(
        "--direction", choices=DIRECTIONS, default=DIRECTIONS[0], help=f"which way round ({DIRECTIONS[0]})"
    )
    parser.add_argument("--timeout", type=positive, default=10.0, metavar="S", help="to confirm it (10)")


def run_mode(args: Namespace, out: Output) -> None:
    mode = NavigationMode[word_of(args.mode)]
    if mode is NavigationMode.WAIT_THEN_AVOID and args.waiting_timeout is None:
        raise ValueError(say("{mode} needs --waiting-timeout, in seconds", mode=args.mode))
    with connect(args, out) as chassis, out.working("asking the navigation"):
        chassis.set_navigation_mode(
            mode,
            waiting_timeout=args.waiting_timeout,
            max_speed=args.max_speed,
            passage_id=args.passage,
            permitted_passage=args.permitted,
            capacity=args.capacity,
            direction=NavDirection[word_of(args.direction)],
            timeout=args.timeout,
        )
    out.line("navigation mode: {mode}", mode=args.mode)
    out.result({"mode": args.mode})
