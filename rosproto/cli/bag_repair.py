"""`rosproto bag reindex` and `fix`: bags that a crash or a bad copy left behind."""

from __future__ import annotations

import argparse
import os

from .bag_progress import Progress

__all__ = ["add_fix_arguments", "add_reindex_arguments", "fix", "reindex"]


def add_reindex_arguments(parser: argparse.ArgumentParser) -> None:
    """Which bags."""
    parser.add_argument("bags", nargs="+", metavar="BAG", help="also the .bag.active of a dead recorder")


def reindex(arguments: argparse.Namespace) -> int:
    """Mend each bag in place; an .active file gets its final name."""
    from rosproto.bag import reindex as mend

    for path in arguments.bags:
        report = mend(path)
        final = path.removesuffix(".active")
        if final != path and not os.path.exists(final):
            os.rename(path, final)
        else:
            final = path
        for line in report.damage:
            print(f"{final}: was: {line}")
        state = "has an index now" if report.damage else "is sound, nothing was changed"
        print(f"{final}: {state}; {report.messages} messages")
    return 0


def add_fix_arguments(parser: argparse.ArgumentParser) -> None:
    """From where to where."""
    parser.add_argument("bag", metavar="DAMAGED", help="is not changed")
    parser.add_argument("output", metavar="OUTPUT", help="a new bag")
    group = parser.add_mutually_exclusive_group()
    group.add_argument("--lz4", action="store_const", const="lz4", dest="compression", default="none")
    group.add_argument("-j", "--bz2", action="store_const", const="bz2", dest="compression")


def fix(arguments: argparse.Namespace) -> int:
    """Write every message that can be read into a new bag."""
    from rosproto.bag import recover

    with Progress(f"saving {arguments.bag}") as progress:
        report = recover(
            arguments.bag,
            arguments.output,
            compression=arguments.compression,
            progress=lambda count: progress.tell(f"saving {arguments.bag}: {count} messages"),
        )
    for line in report.damage:
        print(f"{arguments.bag}: {line}")
    print(f"{arguments.output}: {report.messages} messages")
    return 0
