"""Words between options: `play -r 2 run.bag /a:=/b` and `play run.bag -r 2 /a:=/b` are the same to a person.

argparse fills a positional argument once, from the first row of words, and calls later ones unrecognized.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import Any

__all__ = ["collect_words"]


def collect_words(parser: argparse.ArgumentParser, name: str) -> None:
    """Let all words that are no options, wherever they stand, come into the list argument `name`."""
    plain = parser.parse_known_args

    def parse(args: Sequence[str] | None = None, namespace: Any = None) -> tuple[Any, list[str]]:
        found, rest = plain(args, namespace)
        words = [word for word in rest if not word.startswith("-")]
        setattr(found, name, [*getattr(found, name), *words])
        return found, [word for word in rest if word.startswith("-")]

    parser.parse_known_args = parse  # type: ignore[method-assign, assignment]
