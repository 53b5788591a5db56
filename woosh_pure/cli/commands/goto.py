"""`woosh goto A1` or `woosh goto --pose X Y DEGREES`."""

from __future__ import annotations

from argparse import SUPPRESS, ArgumentParser, Namespace

from rosproto.cli import to_float
from rosproto.sentence import say
from woosh_pure.cli import config
from woosh_pure.cli.arguments import POSE, add_timeout, mark_missing, number, pose
from woosh_pure.cli.connection import connect
from woosh_pure.cli.drive_line import DriveLine
from woosh_pure.cli.follow_goal import follow, report
from woosh_pure.cli.output import Output
from woosh_pure.geometry import Pose2D
from woosh_pure.maps.marks import MarkFile

HELP = "drive to a mark, or to a pose in the map"


def add_arguments(parser: ArgumentParser) -> None:
    """See `Command`."""
    parser.add_argument("mark", nargs="?", help="a mark of the chassis's map, or a place of your list")
    parser.add_argument("more", nargs="*", help=SUPPRESS)  # for a helpful error
    parser.add_argument("--pose", nargs=3, type=number, metavar=POSE, help="m, m and degrees")
    add_timeout(parser)


def run(args: Namespace, out: Output) -> int:
    """See `Command`."""
    if args.more:
        raise ValueError(_several([args.mark, *args.more]))
    if args.mark is None and args.pose is None:
        raise ValueError(mark_missing(args, "give a mark or --pose X Y DEGREES"))
    if args.mark is not None and args.pose is not None:
        raise ValueError("give a mark or --pose X Y DEGREES, and not both")
    target = pose(args.pose) if args.pose else _place(args, out)
    with connect(args, out) as chassis:
        line = DriveLine(chassis, target)
        where = target if args.mark is None else say("mark {name}", name=args.mark)
        if target is None:
            handle = chassis.go_to_mark(args.mark)
        else:
            handle = chassis.go_to(target.x, target.y, target.yaw)  # type: ignore[assignment]
        outcome = follow(handle, out, say("going to {where}", where=where), args.timeout, line)
        here = chassis.pose.latest
        out.line(say("now at {where}", where=here or say("a pose that was not heard")))
        return report(outcome, out, pose=here)


def _place(args: Namespace, out: Output) -> Pose2D | None:
    """Return the pose of a place in the user's list; None for marks of the chassis, and with --sim."""
    if args.sim:
        return None  # the user's places belong to another map than the simulated hall
    mark = args.mark
    try:
        marks = MarkFile(config.mark_file())
    except (OSError, ValueError) as error:
        out.line(say("no marks: {error}", error=error))
        return None
    return marks[mark].pose if mark in marks and not marks[mark].on_chassis else None


def _several(words: list[str]) -> str:
    """Return the hint for several words: numbers are a pose, others a name without quotes."""
    try:
        numbers = [to_float(word) for word in words]
    except ValueError:
        return say("a mark is one word; quote it: woosh goto '{words}'", words=" ".join(words))
    missing = ["DEGREES"] if len(numbers) == 2 else []
    return say("for a pose write: woosh goto --pose {words}", words=" ".join([*words[:3], *missing]))
