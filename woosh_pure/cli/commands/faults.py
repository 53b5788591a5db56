"""`woosh faults`: the present faults, and the meaning of a code."""

from __future__ import annotations

import time
from argparse import ArgumentParser, Namespace
from collections.abc import Iterable

from rosproto.cli import DONE, FAILED, to_int, whole
from rosproto.sentence import say
from woosh_pure.cli.arguments import seconds
from woosh_pure.cli.connection import connect
from woosh_pure.cli.exit_codes import NOT_KNOWN
from woosh_pure.cli.output import Output
from woosh_pure.cli.readiness import is_there, nobody_there
from woosh_pure.enums import RobotState, TaskState
from woosh_pure.errors import ChassisError
from woosh_pure.faults import StatusCode, all_codes, decode_status_code

HELP = "show active faults, or what a status code means (exit code 1: there are faults; 5: not known)"


def add_arguments(parser: ArgumentParser) -> None:
    """See `Command`."""
    parser.add_argument(
        "--listen",
        type=seconds,
        default=3.0,
        metavar="S",
        help="seconds to listen: codes come on change only (3)",
    )
    parser.add_argument(
        "what", nargs="?", metavar="CODE|TEXT", help="as --code or --find; none: what is wrong now"
    )
    parser.add_argument("--code", type=whole, metavar="NUMBER", help="explain this code; asks no chassis")
    parser.add_argument("--find", metavar="TEXT", help="codes whose name or words have it; asks no chassis")
    parser.add_argument("--chinese", action="store_true", help="words in Chinese")


def run(args: Namespace, out: Output) -> int:
    """See `Command`."""
    if args.what is not None:
        if args.code is not None or args.find is not None:
            raise ValueError("give one of: a code, a text, --code, --find")
        try:
            args.code = to_int(args.what)
        except ValueError:
            args.find = args.what
    if args.code is not None:
        if not 0 <= args.code < 1 << 64:
            raise ValueError(
                say("--code {code}: a status code is a number from 0 to 2^64 - 1", code=args.code)
            )
        code, task, robot = decode_status_code(args.code), TaskState(args.code), RobotState(args.code)
        if task.known or robot.known:
            out.line(
                say(
                    "{number} is no status code (12 digits); "
                    "in /robot_status it is task_state {task}, robot_state {robot}",
                    number=args.code,
                    task=task,
                    robot=robot,
                )
            )
            out.result([code])
        else:
            _print([code], args, out)
        return 0
    if args.find is not None:
        wanted = args.find.lower()
        found = [c for c in all_codes() if wanted in f"{c.identifier} {c.english} {c.chinese}".lower()]
        if not found:
            out.line(say("no code has {text!r} in its name or words", text=args.find))
        _print(found, args, out)
        return 0 if found else 1
    with connect(args, out) as chassis:
        faults = chassis.faults  # subscribes
        with out.working("listening"):
            time.sleep(args.listen)
        faults = chassis.faults
        if not faults and not is_there(chassis):
            raise ChassisError(nobody_there(chassis))
    if not faults:
        out.line(faults.sentence())
    _print_codes(faults, args, out)
    out.result({"known": faults.known, "present": faults.present, "faults": list(faults)})
    return {True: FAILED, False: DONE, None: NOT_KNOWN}[faults.present]


def _print(codes: Iterable[StatusCode], args: Namespace, out: Output) -> None:
    listed = list(codes)
    _print_codes(listed, args, out)
    out.result(listed)


def _print_codes(codes: Iterable[StatusCode], args: Namespace, out: Output) -> None:
    colours = {0: "green", 1: "blue", 2: "yellow", 3: "red"}
    for c in codes:
        level = out.colour(c.level.name.lower(), colours[int(c.level)], 8)
        note = " (derived)" if c.derived else ""
        words = c.chinese if args.chinese or out.language == "zh" else c.english
        out.line(level, f"{c.code:012d}", f"{words}{note} ", c.identifier or "not in the table")
