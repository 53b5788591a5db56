"""The definition texts of an installed package, all in one file.

In the source tree and in an editable installation each definition is a file, as in ROS. A wheel would spend
more on the names and checksums of 280 small files than on their texts; so its build (`hatch_build.py`) puts
them into `msgdefs/definitions.txt`: for each file a line of a form feed and its path, then its text.
"""

from __future__ import annotations

import os
from collections.abc import Callable

__all__ = ["MARK", "PACK", "PackedTree", "make_pack"]

PACK = "definitions.txt"
MARK = "\f"
ENDINGS = (".msg", ".srv", ".action", ".txt")


def make_pack(
    folder: str | os.PathLike[str],
    endings: tuple[str, ...] = ENDINGS,
    change: Callable[[str], str] | None = None,
) -> str:
    """All files below a folder that end so, as one text: definitions, aliases, tables of revisions.

    Args:
        folder: Where they are, at any depth.
        endings: What their names end in.
        change: Makes of each text what is packed.

    Raises:
        ValueError: A text has a form feed in it.
    """
    found = {}
    for place, _, files in os.walk(folder):
        for name in files:
            if name.endswith(endings):
                path = os.path.join(place, name)
                with open(path, encoding="utf-8") as file:
                    found[os.path.relpath(path, folder).replace(os.sep, "/")] = file.read()
    if change is not None:
        found = {path: change(text) for path, text in found.items()}
    for path, text in found.items():
        if MARK in text:
            raise ValueError(f"{path}: has a form feed, which separates the texts of a pack; leave it out")
    return "".join(f"{MARK}{path}\n{text}" for path, text in sorted(found.items()))


class PackedTree:
    """A tree of files read from one text."""

    def __init__(self, package: str, text: str) -> None:
        self.package = package
        self._texts: dict[str, str] = {}
        self._names: dict[tuple[str, ...], set[str]] = {}
        for part in text.split(MARK)[1:]:
            path, _, content = part.partition("\n")
            self._texts[path] = content
            parts = tuple(path.split("/"))
            for depth, name in enumerate(parts):
                self._names.setdefault(parts[:depth], set()).add(name)

    def names(self, *parts: str) -> frozenset[str]:
        """Names of the files and folders in a folder; empty when there is no such folder."""
        return frozenset(self._names.get(parts, ()))

    def read(self, *parts: str) -> str:
        """Text of a file.

        Raises:
            KeyError: There is no such file; whoever asks has looked at `names`.
        """
        return self._texts["/".join(parts)]

    def describe(self, *parts: str) -> str:
        """The file's name for a person."""
        return "/".join((self.package, *parts))
