"""`woosh stop`."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from woosh_pure.cli.arguments import positive
from woosh_pure.cli.connection import connect
from woosh_pure.cli.output import Output

HELP = "stop: zero velocity and cancel everything, whoever started it (no emergency stop)"


def add_arguments(parser: ArgumentParser) -> None:
    """See `Command`."""
    parser.add_argument(
        "--end-drivers",
        action="store_true",
        help="also ask other programs that can send velocities to end (not the robot's own)",
    )
    parser.add_argument("--timeout", type=positive, default=5.0, metavar="S", help="to confirm the stop (5)")


def run(args: Namespace, out: Output) -> int:
    """See `Command`."""
    from dataclasses import asdict

    with connect(args, out) as chassis:
        # Other processes started the motion.
        with out.working("stopping"):
            report = chassis.stop(everything=True, end_drivers=args.end_drivers, timeout=args.timeout)
        out.line(report.sentence())
        out.result(asdict(report))
        return 0 if report.standing else 1
