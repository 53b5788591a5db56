"""`rosproto bag echo`: `rosproto topic echo` on a bag."""

from __future__ import annotations

import argparse

from . import topic_echo

__all__ = ["add_echo_arguments", "echo"]


def add_echo_arguments(parser: argparse.ArgumentParser) -> None:
    """The bag, then what `topic echo` takes."""
    parser.add_argument("file", metavar="BAG")
    topic_echo.add_arguments(parser)
    parser.add_argument("--json", action="store_true", help="print messages as JSON, one a line")


def echo(arguments: argparse.Namespace) -> int:
    """Print the messages of a topic (also a pattern such as '/camera/*')."""
    arguments.bag = arguments.file
    return topic_echo.run(arguments)
