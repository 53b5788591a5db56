"""`rosproto topic echo`: its options; `echo` does the work, and is imported for it alone."""

from __future__ import annotations

import argparse

from .option_types import count, positive
from .shared_options import add_allow_damaged

__all__ = ["add_arguments", "run"]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options of rostopic echo, and ours."""
    parser.add_argument(
        "topic",
        help="a topic, with a path to a field behind it: /odom/pose/pose/position/x, /scan/ranges[0:9]; "
        "or a pattern for several: '/battery*'",
    )
    parser.add_argument("topics", nargs="*", default=[], help="with --plot: more numbers to draw")
    parser.add_argument("-n", type=count, metavar="COUNT", help="stop after this many messages")
    parser.add_argument("-p", "--csv", action="store_true", dest="csv", help="one line of CSV a message")
    parser.add_argument("-c", "--clear", action="store_true", help="clear the screen before each message")
    parser.add_argument(
        "--filter", metavar="EXPRESSION", help='only messages for which it is true: "m.x > 1"'
    )
    parser.add_argument("--noarr", action="store_true", help="tell the size of arrays, not their elements")
    parser.add_argument("--nostr", action="store_true", help="leave strings out")
    parser.add_argument("--offset", action="store_true", help="times as durations since now")
    parser.add_argument("-b", "--bag", metavar="FILE", help="read messages from a bag, not from a graph")
    add_allow_damaged(parser)
    parser.add_argument("-a", "--all", action="store_true", help="with a bag: the messages of every topic")
    parser.add_argument("--plot", action="store_true", help="draw numbers over time in the terminal")
    parser.add_argument(
        "--seconds", type=positive, metavar="S", help="with --plot: so far back (30; of a bag all)"
    )
    parser.add_argument("-w", type=count, metavar="WIDTH", dest="width", help="width of numbers")
    parser.add_argument(
        "--timeout", type=positive, metavar="S", help="give up when no message comes for so long"
    )


def run(arguments: argparse.Namespace) -> int:
    """Print until interrupted, or until -n messages."""
    from .echo import run as echo

    return echo(arguments)
