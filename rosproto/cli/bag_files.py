"""The files of commands on recordings: inputs, with their damage, and outputs, complete or absent."""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import Literal
from urllib.parse import unquote, urlsplit

from rosproto.bag import BagReader, open_bag
from rosproto.bag.opening import is_mcap_name
from rosproto.bag.remote import is_remote
from rosproto.cli.bag_progress import Progress
from rosproto.cli.console import OutputError, counted
from rosproto.cli.exit_codes import CommandError, say
from rosproto.errors import BagError

Compression = Literal["none", "bz2", "lz4", "zstd"]
MCAP_COMPRESSION: Literal["zstd"] = "zstd"
"""Of MCAP files, unless an option says otherwise."""


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


def decodable(bag: BagReader, topics: Sequence[str], arguments: argparse.Namespace) -> list[str]:
    """Return the topics whose messages can be decoded; the others are reported on stderr as left out.

    One of them does not stop the command, but it ends with `FAILED`, unless --allow-damaged is given.
    """
    found = []
    for topic in topics:
        try:
            for connection in bag.topics[topic].connections:
                bag.message_class(connection)
        except BagError as problem:
            left_out(str(problem), arguments)
        else:
            found.append(topic)
    return found


def left_out(problem: str, arguments: argparse.Namespace) -> None:
    """Report messages that a command leaves out; its exit code tells it, unless --allow-damaged is given."""
    arguments.incomplete = not arguments.allow_damaged
    say(f"left out: {problem}")


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


# -- output --------------------------------------------------------------------------------------------------


def check_new(outputs: Iterable[str], *inputs: str) -> None:
    """Refuse outputs that exist (other than empty folders) or are inputs.

    Raises:
        CommandError: An output exists or is an input.
    """
    for output in outputs:
        if any(os.path.realpath(output) == os.path.realpath(path) for path in inputs):
            raise CommandError(f"{output} is the input; choose another name")
        if os.path.exists(output) and not (os.path.isdir(output) and not os.listdir(output)):
            raise CommandError(f"{output} already exists; choose another name")


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
