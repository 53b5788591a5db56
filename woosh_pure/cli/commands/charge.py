"""`woosh charge MARK`."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING

from rosproto.errors import RosTimeout
from rosproto.sentence import say
from woosh_pure.cli.arguments import add_timeout, mark_missing
from woosh_pure.cli.connection import connect
from woosh_pure.cli.drive_line import DriveLine
from woosh_pure.cli.follow_goal import follow, report
from woosh_pure.cli.output import Output
from woosh_pure.values.state import Battery

if TYPE_CHECKING:
    from woosh_pure.chassis import Chassis

HELP = "drive to a charger and charge"


def add_arguments(parser: ArgumentParser) -> None:
    """See `Command`."""
    parser.add_argument("mark", nargs="?", help="name of the charger's mark, as on the chassis's map")
    add_timeout(parser)


def run(args: Namespace, out: Output) -> int:
    """See `Command`."""
    if args.mark is None:
        raise ValueError(mark_missing(args, "give the mark of a charger"))
    with connect(args, out) as chassis:
        line = DriveLine(chassis)
        handle = chassis.charge(args.mark, timeout=args.timeout)
        outcome = follow(handle, out, say("going to charge at {mark}", mark=args.mark), args.timeout, line)
        battery = _battery(chassis)
        if battery is not None:
            out.line(
                say("battery {percent} %, {charge}", percent=battery.percent, charge=battery.charge_status)
            )
        return report(outcome, out, battery=battery)


def _battery(chassis: Chassis) -> Battery | None:
    """Wait for the battery to report charging; it reports later than the task."""
    try:
        return chassis.battery.wait_for(lambda battery: battery.charging, 3.0)
    except RosTimeout:
        return chassis.battery.latest
