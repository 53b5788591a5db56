"""Opens a command's recording (file or URL) and reports damage."""

from __future__ import annotations

import argparse
import os
from collections.abc import Sequence
from urllib.parse import unquote, urlsplit

from rosproto.bag import BagReader, open_bag
from rosproto.bag.remote import is_remote

from .bag_progress import Progress
from .console import counted
from .exit_codes import CommandError, say


def reader_of(
    path: str, *, skip_damaged: bool = False, quiet: bool = False, bags_only: bool = False
) -> BagReader:
    """Open a bag or MCAP file; a file without an index is scanned, which takes as long as reading it.

    Only for commands that report damage themselves; others use `opened`.

    Raises:
        BagError: It cannot be opened, or has another format; with `bags_only` also for MCAP.
    """

    with Progress(f"opening {path}", quiet=quiet, in_bytes=True) as progress:
        if bags_only:
            return BagReader(path, skip_damaged=skip_damaged, scanning=progress.at)
        return open_bag(path, skip_damaged=skip_damaged, scanning=progress.at)


def opened(
    path: str, arguments: argparse.Namespace, *, quiet: bool = False, bags_only: bool = False
) -> BagReader:
    """Like `reader_of`, for commands that use the messages.

    Damage is reported at once on stderr. Because messages may be missing, `arguments.incomplete` is set and
    the command ends with `FAILED`, unless --allow-damaged is given (see `add_allow_damaged`).
    """
    bag = reader_of(path, quiet=quiet, bags_only=bags_only)
    if bag.damage:
        arguments.incomplete = not arguments.allow_damaged
        say(f"{path}: {damage_sentence(path, bag.damage)}")
    return bag


def damage_sentence(path: str, damage: Sequence[str]) -> str:
    """Describe a file's damage and its effect on the messages."""
    others = len(damage) - 1
    more = f" (and {counted(others, 'other problem')}; see: rosproto bag check {path})" if others else ""
    return (
        f"damaged, messages may be missing: {damage[0]}{more}; the exit code tells it, "
        "unless --allow-damaged is given"
    )


def next_to(path: str) -> str:
    """Return the output path of a recording, without ending: next to it, or in this directory for a URL."""
    if not is_remote(path):
        return os.path.splitext(path)[0]
    name = os.path.splitext(os.path.basename(unquote(urlsplit(path).path)))[0]
    return name or "export"


def check_local(path: str, instead: str) -> None:
    """Refuse a URL for a command that writes in place.

    Raises:
        CommandError: The path is a URL; the text names an alternative.
    """
    if is_remote(path):
        raise CommandError(f"{path} is changed in place, and a URL cannot be written; {instead}")
