"""`woosh move METRES`."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from rosproto.sentence import say
from woosh_pure.cli.arguments import number, positive
from woosh_pure.cli.connection import connect
from woosh_pure.cli.drive_line import DriveLine
from woosh_pure.cli.follow_goal import follow, report
from woosh_pure.cli.output import Output

HELP = "move straight by metres (negative: backward), or sideways"


def add_arguments(parser: ArgumentParser) -> None:
    """See `Command`."""
    parser.add_argument("metres", type=number, help="at most 10")
    parser.add_argument(
        "--speed", type=positive, default=0.0, metavar="M/S", help="default: the chassis's 0.2"
    )
    parser.add_argument("--left", action="store_true", help="sideways to the left (omnidirectional bases)")
    parser.add_argument("--no-avoid", action="store_true", help="switch obstacle avoidance off for this move")


def run(args: Namespace, out: Output) -> int:
    """See `Command`."""
    with connect(args, out) as chassis:
        line = DriveLine(chassis)
        verb = chassis.strafe if args.left else chassis.move
        handle = verb(args.metres, speed=args.speed, avoid=not args.no_avoid)
        outcome = follow(
            handle, out, say("moving {metres:g} m", metres=args.metres), handle.default_timeout, line
        )
        return report(outcome, out)
