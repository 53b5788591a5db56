"""Output files of commands on recordings: a new file, complete or absent.

This holds for `bag filter`, `merge`, `convert`, `compress`, `fix` and `export`.
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
    """Refuse outputs that exist (other than empty folders) or are inputs.

    Raises:
        CommandError: An output exists or is an input.
    """
    for output in outputs:
        if any(os.path.realpath(output) == os.path.realpath(path) for path in inputs):
            raise CommandError(f"{output} is what is read; choose another name")
        if os.path.exists(output) and not (os.path.isdir(output) and not os.listdir(output)):
            raise CommandError(f"{output} exists already; choose another name")


@contextmanager
def whole(path: str) -> Iterator[None]:
    """Write this file (see `check_new`) within the block; remove it on failure.

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
    """Write this file within the block; operating system errors name it.

    Raises:
        CommandError: It cannot be written.
    """
    try:
        yield
    except OutputError:
        raise  # from a print within the block
    except (OSError, BagError) as error:
        problem = _problem_of(error, path)
        if problem is None:
            raise
        why = getattr(problem, "strerror", None) or problem
        raise CommandError(f"{path}: cannot write: {why}") from error


def _problem_of(error: OSError | BagError, path: str) -> BaseException | None:
    """Return the cause of a write error of this file; None for other errors.

    The text of a bag writer's error says how much is readable, which is wrong for a removed file.
    """
    if isinstance(error, BagError):
        return error.__cause__ if error.path == path else None
    return error if error.filename in (None, path) else None


def compression_of(arguments: argparse.Namespace) -> Compression:
    """Compression of `arguments.output` by the options; default: none for a bag, zstd for MCAP."""
    chosen: Compression = arguments.compression
    return MCAP_COMPRESSION if chosen == "none" and is_mcap_name(arguments.output) else chosen
