"""`rosproto topic pub`: its options; `publish` does the work, and is imported for it alone."""

from __future__ import annotations

import argparse

from .option_types import count, positive

__all__ = ["add_arguments", "run"]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options of rostopic pub."""
    parser.add_argument("topic")
    parser.add_argument("type", help="package/Type")
    parser.add_argument(
        "values",
        nargs="*",
        default=[],
        help="{field: value}, or the fields in order; now and auto for times; "
        "without any they are read from standard input",
    )
    how = parser.add_mutually_exclusive_group()
    how.add_argument("-r", "--rate", type=positive, metavar="HZ", help="publish this often, per second")
    how.add_argument("-1", "--once", action="store_true", help="publish one message and end")
    parser.add_argument(
        "-f", "--file", default=None, help="take the values from a YAML or JSON file, - is stdin"
    )
    parser.add_argument("-l", "--latch", action="store_true", help="latch also with -r, and with a file")
    parser.add_argument(
        "-s", "--substitute-keywords", action="store_true", help="accepted: now and auto always work"
    )
    parser.add_argument("--use-rostime", action="store_true", help="accepted for rostopic's sake")
    parser.add_argument("-n", type=count, default=None, metavar="COUNT", help="stop after this many messages")


def run(arguments: argparse.Namespace) -> int:
    """Publish; latched unless a rate is asked for."""
    from .publish import run as publish

    return publish(arguments)
