"""Output files of commands on recordings: never an existing file, and complete or absent.

`bag filter`, `merge`, `convert`, `compress`, `fix` and `export` keep to that: half a file would pass for the
whole.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Literal

from rosproto.bag.opening import is_mcap_name
from rosproto.errors import BagError

from .console import OutputError
from .exit_codes import CommandError

Compression = Literal["none", "bz2", "lz4", "zstd"]
MCAP_COMPRESSION: Literal["zstd"] = "zstd"
"""Of MCAP files, unless an option says otherwise."""


def check_new(outputs: Iterable[str], *inputs: str) -> None:
    """Refuse outputs that exist (an empty folder may), or are what is read.

    Raises:
        CommandError: One of them is.
    """
    for output in outputs:
        if any(os.path.realpath(output) == os.path.realpath(path) for path in inputs):
            raise CommandError(f"{output} is what is read; choose another name")
        if os.path.exists(output) and not (os.path.isdir(output) and not os.listdir(output)):
            raise CommandError(f"{output} exists already; choose another name")


@contextmanager
def whole(path: str) -> Iterator[None]:
    """Within the block this file, which was `check_new`, is written; when that fails, nothing is left of it.

    Raises:
        CommandError: See `named`.
    """
    try:
        with named(path):
            yield
    except BaseException:
        if os.path.exists(path):
            os.remove(path)
        raise


@contextmanager
def named(path: str) -> Iterator[None]:
    """Within the block this file is written, and an error of the system names it.

    Raises:
        CommandError: It cannot be written.
    """
    try:
        yield
    except OutputError:
        raise  # a print within the block
    except (OSError, BagError) as error:
        problem = _problem_of(error, path)
        if problem is None:
            raise
        why = getattr(problem, "strerror", None) or problem
        raise CommandError(f"{path}: cannot write: {why}") from error


def _problem_of(error: OSError | BagError, path: str) -> BaseException | None:
    """What kept this file from being written; None when the error is about something else.

    A writer of bags says how much of its file can be read, which is not true of a file that is removed.
    """
    if isinstance(error, BagError):
        return error.__cause__ if error.path == path else None
    return error if error.filename in (None, path) else None


def compression_of(arguments: argparse.Namespace) -> Compression:
    """How `arguments.output` is compressed: as the options say, else a bag not at all, MCAP by zstd."""
    chosen: Compression = arguments.compression
    return MCAP_COMPRESSION if chosen == "none" and is_mcap_name(arguments.output) else chosen
