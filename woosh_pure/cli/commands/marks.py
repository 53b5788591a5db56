"""`woosh marks`: the user's own list of marks."""

from __future__ import annotations

from argparse import SUPPRESS, ArgumentParser, Namespace
from collections.abc import Iterable
from pathlib import Path

from rosproto.errors import RosError
from rosproto.sentence import say
from rosproto.text import padded, width
from woosh_pure.cli import config
from woosh_pure.cli.arguments import POSE, add_wait, marks_here, number, pose, wait_for
from woosh_pure.cli.connection import connect
from woosh_pure.cli.output import Output
from woosh_pure.errors import ChassisError
from woosh_pure.geometry import Pose2D
from woosh_pure.maps.marks import MarkFile, UserMark
from woosh_pure.reasons import ReasonKey

HELP = "keep your own list of marks (the chassis cannot list them), for completion and notes"


def add_arguments(parser: ArgumentParser) -> None:
    """See `Command`."""
    parser.add_argument("--file", type=Path, help="the list (default: beside the saved chassis)")
    verbs = parser.add_subparsers(dest="verb", metavar="VERB", required=True)
    verbs.add_parser("list", help="show the list")
    add = verbs.add_parser("add", help="add or replace a mark")
    add.add_argument("name", help="of a place, or of a mark on the chassis's map (--on-chassis)")
    place = add.add_mutually_exclusive_group()
    place.add_argument("--pose", nargs=3, type=number, metavar=POSE, help="m, m and degrees in the map")
    place.add_argument("--here", action="store_true", help="where the robot is now (the default)")
    place.add_argument(
        "--no-pose", action="store_true", help="the name alone, of a mark on the chassis's map; asks no robot"
    )
    owner = add.add_mutually_exclusive_group()
    owner.add_argument(
        "--on-chassis",
        action="store_true",
        help="the chassis's map has this mark: `goto` asks for it by name (else `goto` drives to the pose)",
    )
    owner.add_argument("--place", action="store_true", help=SUPPRESS)  # the default; for older scripts
    add.add_argument("--note", default="", help="anything")
    add_wait(add)
    remove = verbs.add_parser("remove", help="take a mark off the list")
    remove.add_argument("mark", help="its name")


def run(args: Namespace, out: Output) -> int:
    """See `Command`."""
    if args.sim and args.file is None:
        return _simulated(args, out)
    marks = MarkFile(args.file or config.mark_file())
    if args.verb == "add":
        before = {mark.name: mark for mark in marks}.get(args.name)
        on_chassis = args.on_chassis or (args.no_pose and not args.place)
        where = pose(args.pose) if args.pose else None if args.no_pose else _here(args, out)
        mark = marks.put(args.name, where, args.note, on_chassis=on_chassis)
        marks.save()
        out.line(
            say(
                "{name}: {pose} (in {path})",
                name=mark.name,
                pose=mark.pose or say("no pose"),
                path=marks.path,
            )
        )
        if before is not None and before.pose not in (None, where):
            out.line(say("before it was {pose}", pose=before.pose))
        if before is not None and before.on_chassis and not on_chassis:
            out.line(
                say(
                    "`woosh goto {name}` drives to this pose now; for the chassis's mark give --on-chassis",
                    name=mark.name,
                )
            )
    elif args.verb == "remove":
        marks.remove(args.mark)
        marks.save()
        out.line(say("removed {name}", name=args.mark))
    else:
        _print(marks, out)
        if not len(marks):
            out.line(say("no marks in {path}; add one with `woosh marks add NAME`", path=marks.path))
    out.result(sorted(marks, key=lambda m: m.name))
    return 0


def _simulated(args: Namespace, out: Output) -> int:
    """With --sim: list the marks of the simulated hall; refuse changes."""
    if args.verb != "list":
        raise ValueError(
            "--sim ends with this command, and your list is for real robots; give another one: --file FILE"
        )
    marks = [UserMark(name, where) for name, where in sorted(marks_here(args).items())]
    _print(marks, out)
    out.result(marks)
    return 0


def _print(marks: Iterable[UserMark], out: Output) -> None:
    listed = list(marks)
    column = max((width(mark.name) for mark in listed), default=0)
    for mark in listed:
        name = padded(mark.name, max(12, column))
        out.line(f"{name} {mark.pose or 'no pose'}  {mark.note}".rstrip())


def _here(args: Namespace, out: Output) -> Pose2D:
    """Return the robot's pose, if it is localized."""
    try:
        with connect(args, out) as chassis:
            chassis.readiness()  # subscribes
            where = wait_for(chassis.pose, args, out)
            lost = [r for r in chassis.readiness().reasons if r.key is ReasonKey.NOT_LOCALISED]
    except (RosError, ValueError):
        out.line("`--pose X Y DEGREES` or `--no-pose` keeps a mark without asking the robot")
        raise
    if lost:
        raise ChassisError(lost[0].text)
    return where
