"""`woosh rotate DEGREES`."""

from __future__ import annotations

import math
from argparse import ArgumentParser, Namespace

from rosproto.sentence import say
from woosh_pure.cli.arguments import number, positive
from woosh_pure.cli.connection import connect
from woosh_pure.cli.drive_line import DriveLine
from woosh_pure.cli.follow_goal import follow, report
from woosh_pure.cli.output import Output

HELP = "turn in place by degrees (positive: to the left)"


def add_arguments(parser: ArgumentParser) -> None:
    """See `Command`."""
    parser.add_argument("degrees", type=number, help="at most 3600")
    parser.add_argument(
        "--speed", type=positive, default=0.0, metavar="DEG/S", help="default: the chassis's 5.7"
    )
    parser.add_argument("--no-avoid", action="store_true", help="switch obstacle avoidance off for this move")


def run(args: Namespace, out: Output) -> int:
    """See `Command`."""
    if abs(args.degrees) > 3600.0:
        raise ValueError(
            say(
                "{degrees:g}° is more than the 3600° (ten turns) that one step may have", degrees=args.degrees
            )
        )
    with connect(args, out) as chassis:
        line = DriveLine(chassis)
        handle = chassis.rotate(
            args.degrees,
            degrees=True,
            speed=math.radians(args.speed),
            several_turns=True,
            avoid=not args.no_avoid,
        )
        outcome = follow(
            handle, out, say("turning {degrees:g}°", degrees=args.degrees), handle.default_timeout, line
        )
        return report(outcome, out)
