"""`woosh battery`."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from rosproto.sentence import say
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
    charge = out.colour(f"{b.percent} %", colour)
    rows = {
        "charge": say(
            "{charge}, {status} ({mode})", charge=charge, status=b.charge_status, mode=b.charge_mode
        ),
        "voltage": say(
            "{volts:.2f} V, cells {lowest:.2f} to {highest:.2f} V",
            volts=b.voltage,
            lowest=b.cell_voltage_min,
            highest=b.cell_voltage_max,
        ),
        "current": f"{b.current:.2f} A",
        "temperature": say("{lowest} to {highest} °C", lowest=b.temperature_min, highest=b.temperature_max),
        "capacity": say(
            "{left:.1f} of {full:.1f} Ah (designed {designed:.1f} Ah)",
            left=b.capacity_remaining,
            full=b.capacity_full,
            designed=b.capacity_design,
        ),
        "cycles": say(
            "{charged} charged, {own} of the battery", charged=b.charge_cycles, own=b.battery_cycles
        ),
    }
    for name, text in rows.items():
        out.line(out.cell(name, 12), text)
    out.result(b)
    return 1 if args.below is not None and b.percent < args.below else 0
