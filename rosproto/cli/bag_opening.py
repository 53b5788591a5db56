"""Opens the recording of a command, a file or a URL, and reports its damage."""

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
    """A reader of a bag or an MCAP file; one without an index is scanned, which takes as long as reading it.

    For commands whose answer is what is wrong with a file; `opened` is for all others.

    Raises:
        BagError: It cannot be opened, or is neither; with `bags_only` also when it is MCAP.
    """

    with Progress(f"opening {path}", quiet=quiet, in_bytes=True) as progress:
        if bags_only:
            return BagReader(path, skip_damaged=skip_damaged, scanning=progress.at)
        return open_bag(path, skip_damaged=skip_damaged, scanning=progress.at)


def opened(
    path: str, arguments: argparse.Namespace, *, quiet: bool = False, bags_only: bool = False
) -> BagReader:
    """As `reader_of`, for a command that takes the messages.

    When the file is damaged, this is told at once on stderr, and the command ends with `FAILED` even if it
    does all the rest, because messages may be missing: `arguments.incomplete` tells the entry. With
    --allow-damaged (see `add_allow_damaged`) it ends as otherwise.
    """
    bag = reader_of(path, quiet=quiet, bags_only=bags_only)
    if bag.damage:
        arguments.incomplete = not arguments.allow_damaged
        say(f"{path}: {damage_sentence(path, bag.damage)}")
    return bag


def damage_sentence(path: str, damage: Sequence[str]) -> str:
    """What is wrong with a file, and what that means for its messages."""
    others = len(damage) - 1
    more = f" (and {counted(others, 'other problem')}; see: rosproto bag check {path})" if others else ""
    return (
        f"damaged, messages may be missing: {damage[0]}{more}; the exit code tells it, "
        "unless --allow-damaged is given"
    )


def next_to(path: str) -> str:
    """The name for what is made of a recording, without an ending: beside it; of a URL, in this directory."""
    if not is_remote(path):
        return os.path.splitext(path)[0]
    name = os.path.splitext(os.path.basename(unquote(urlsplit(path).path)))[0]
    return name or "export"


def check_local(path: str, instead: str) -> None:
    """Refuse a URL where a file is written in place.

    Raises:
        CommandError: It is one; says what to do instead.
    """
    if is_remote(path):
        raise CommandError(f"{path} is changed in place, and a URL cannot be written; {instead}")
