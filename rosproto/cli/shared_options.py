"""Options that several commands have, written once."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from typing import Any

__all__ = ["AddArguments", "add_allow_damaged", "add_compression", "add_json", "add_quiet", "argument"]

AddArguments = Callable[[argparse.ArgumentParser], object]
"""What gives a parser its arguments."""


def argument(*names: str, **options: Any) -> AddArguments:
    """For a verb that has a single argument: what `add_argument` takes."""
    return lambda parser: parser.add_argument(*names, **options)


def add_json(parser: argparse.ArgumentParser) -> None:
    """--json."""
    parser.add_argument("--json", action="store_true", help="print facts as JSON, for programs")


def add_allow_damaged(parser: argparse.ArgumentParser) -> None:
    """--allow-damaged; see `bag_opening.opened`."""
    parser.add_argument(
        "--allow-damaged",
        action="store_true",
        help="exit code 0 although a bag is damaged and messages may be missing",
    )


def add_quiet(parser: argparse.ArgumentParser) -> None:
    """-q."""
    parser.add_argument("-q", "--quiet", action="store_true", help="print errors only")


def add_compression(parser: argparse.ArgumentParser, default: str = "none") -> None:
    """--lz4 and --bz2: how a bag is written."""
    group = parser.add_mutually_exclusive_group()
    group.add_argument(
        "--lz4", action="store_const", const="lz4", dest="compression", default=default, help="compress, fast"
    )
    group.add_argument(
        "-j", "--bz2", action="store_const", const="bz2", dest="compression", help="compress more, slowly"
    )
