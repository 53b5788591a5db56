"""Open what a command was told to read: a file or a URL, with a line on stderr while that takes long."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING
from urllib.parse import unquote, urlsplit

from rosproto.bag.remote import is_remote

from .bag_progress import Progress
from .connection import CommandError

if TYPE_CHECKING:
    from rosproto.bag import BagReader

__all__ = ["check_local", "next_to", "opened"]


def opened(path: str, *, skip_damaged: bool = False, quiet: bool = False) -> BagReader:
    """A reader of a bag or an MCAP file; one without an index is scanned, which takes as long as reading it.

    Raises:
        BagError: It cannot be opened, or is neither.
    """
    from rosproto.bag import open_bag

    with Progress(f"opening {path}", quiet=quiet, in_bytes=True) as progress:
        return open_bag(path, skip_damaged=skip_damaged, scanning=progress.at)


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
