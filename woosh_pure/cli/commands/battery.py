"""`woosh battery`."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from woosh_pure.cli.arguments import add_wait, number, wait_for
from woosh_pure.cli.connection import connect
from woosh_pure.cli.output import Output

HELP = "show charge, voltage, current, temperature and health of the battery"


def add_arguments(parser: ArgumentParser) -> None:
    """See `Command`."""
    add_wait(parser)
    parser.add_argument(
        "--below", type=number, metavar="PERCENT", help="exit code 1 when it holds less than this"
    )


def run(args: Namespace, out: Output) -> int:
    """See `Command`."""
    with connect(args, out) as chassis:
        b = wait_for(chassis.battery, args, out)
    colour = "red" if b.percent < 20 else "yellow" if b.percent < 40 else "green"
    out.line(f"{'charge':12s} {out.colour(f'{b.percent} %', colour)}, {b.charge_status} ({b.charge_mode})")
    out.line(
        f"{'voltage':12s} {b.voltage:.2f} V, cells {b.cell_voltage_min:.2f} to {b.cell_voltage_max:.2f} V"
    )
    out.line(f"{'current':12s} {b.current:.2f} A")
    out.line(f"{'temperature':12s} {b.temperature_min} to {b.temperature_max} °C")
    out.line(
        f"{'capacity':12s} {b.capacity_remaining:.1f} of {b.capacity_full:.1f} Ah"
        f" (designed {b.capacity_design:.1f} Ah)"
    )
    out.line(f"{'cycles':12s} {b.charge_cycles} charged, {b.battery_cycles} of the battery")
    out.result(b)
    return 1 if args.below is not None and b.percent < args.below else 0
