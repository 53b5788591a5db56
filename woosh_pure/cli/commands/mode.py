"""`woosh mode`: the navigation's behaviour at obstacles."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from rosproto.sentence import say
from woosh_pure.cli.arguments import natural, positive, seconds, word_of
from woosh_pure.cli.connection import connect
from woosh_pure.cli.output import Output
from woosh_pure.enums import NavDirection, NavigationMode

MODES = ("fuzzy-avoidance", "precise-avoidance", "stop-and-wait", "wait-then-avoid")
DIRECTIONS = ("chassis-decides", "forward", "backward", "along-path")
HELP = "set what the navigation does about obstacles, and how fast it drives"


def add_arguments(parser: ArgumentParser) -> None:
    """See `Command`."""
    parser.add_argument("mode", choices=MODES, help="what to do about an obstacle")
    parser.add_argument(
        "--waiting-timeout",
        type=seconds,
        metavar="S",
        help="how long wait-then-avoid waits (needed there; 0 may mean not at all)",
    )
    parser.add_argument(
        "--max-speed", type=seconds, default=0.0, metavar="M/S", help="0 keeps the configured one"
    )
    parser.add_argument("--passage", type=natural, default=0, metavar="ID", help="passage this is about (0)")
    parser.add_argument("--permitted", action="store_true", help="a changed path may be followed")
    parser.add_argument(
        "--capacity", type=natural, default=0, metavar="N", help="vehicles in the passage (0)"
    )
    parser.add_argument(
        "--direction", choices=DIRECTIONS, default=DIRECTIONS[0], help=f"which way round ({DIRECTIONS[0]})"
    )
    parser.add_argument("--timeout", type=positive, default=10.0, metavar="S", help="to confirm it (10)")


def run(args: Namespace, out: Output) -> int:
    """See `Command`."""
    mode = NavigationMode[word_of(args.mode)]
    if mode is NavigationMode.WAIT_THEN_AVOID and args.waiting_timeout is None:
        raise ValueError(say("{mode} needs --waiting-timeout, in seconds", mode=args.mode))
    with connect(args, out) as chassis, out.working("asking the navigation"):
        chassis.set_navigation_mode(
            mode,
            waiting_timeout=args.waiting_timeout,
            max_speed=args.max_speed,
            passage_id=args.passage,
            permitted_passage=args.permitted,
            capacity=args.capacity,
            direction=NavDirection[word_of(args.direction)],
            timeout=args.timeout,
        )
    out.line(say("navigation mode: {mode}", mode=args.mode))
    out.result({"mode": args.mode})
    return 0
