"""`woosh costmap on|off|clear`."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from woosh_pure.cli.connection import connect
from woosh_pure.cli.output import Output

_SAID = {
    "on": "obstacles enter the costmaps",
    "off": "obstacles are NO LONGER noticed",
    "clear": "the obstacles seen so far are forgotten",
}
HELP = "let obstacles enter the costmaps or not, or forget those seen so far"


def add_arguments(parser: ArgumentParser) -> None:
    """See `Command`."""
    parser.add_argument(
        "setting", choices=("on", "off", "clear"), help="off: obstacles are no longer noticed"
    )


def run(args: Namespace, out: Output) -> int:
    """See `Command`."""
    with connect(args, out) as chassis, out.working("asking the navigation"):
        if args.setting == "clear":
            chassis.clear_costmaps()
        else:
            chassis.enable_costmaps(args.setting == "on")
    out.line(_SAID[args.setting])
    out.result({"done": args.setting})
    return 0
