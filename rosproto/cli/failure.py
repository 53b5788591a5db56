"""How a command ends: exit codes, one sentence for an error, signals that unwind it.

`rosproto` and `woosh` use the same codes; 3, a refusal of the chassis, is woosh's alone.
"""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any, NoReturn

from rosproto.errors import ConnectionLost, RosError

__all__ = [
    "DONE",
    "FAILED",
    "INTERRUPTED",
    "TERMINATED",
    "UNREACHABLE",
    "WRONG_USE",
    "CommandError",
    "Terminated",
    "explain",
    "output_is_gone",
    "raise_terminated",
    "say",
    "signals_unwind",
]

DONE, FAILED, WRONG_USE, UNREACHABLE = 0, 1, 2, 4
INTERRUPTED, TERMINATED = 130, 143


class CommandError(RosError):
    """A command cannot do what was asked; the text is the one sentence the user sees."""


class Terminated(BaseException):
    """SIGTERM, a hang-up or a closed console: unwinds the program as Ctrl-C does, so that nodes are
    unregistered and motions stopped.
    """


def explain(error: Exception) -> tuple[str, int]:
    """One sentence and the exit code."""
    text = " ".join(str(error.args[0] if isinstance(error, KeyError) and error.args else error).split())
    if isinstance(error, ConnectionLost):
        return text, UNREACHABLE
    if isinstance(error, ValueError) and not isinstance(error, RosError):
        return text, WRONG_USE
    if isinstance(error, OSError) and not isinstance(error, RosError) and error.strerror:
        # Only the standard streams have no name.
        return f"{error.filename or 'cannot write the output'}: {error.strerror}", FAILED
    if isinstance(error, (RosError, ValueError, OSError, KeyError)):
        return text, FAILED
    return f"{type(error).__name__}: {text}; this is a mistake of ours, please report it with --debug", FAILED


def say(text: str) -> None:
    """A line on stderr, if there is still somebody to read it."""
    try:
        print(text, file=sys.stderr, flush=True)
    except (OSError, ValueError):
        pass  # the terminal has gone: the exit code is all that is left to say


def output_is_gone() -> None:
    """The reader (head, less) has enough: what is still buffered must not raise again at exit."""
    if sys.stdout is not None:
        try:
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        except (OSError, ValueError):
            pass  # no descriptor stands behind it: nothing is flushed to anywhere


@contextmanager
def signals_unwind() -> Iterator[None]:
    """Within the block SIGTERM, SIGHUP and SIGBREAK raise `Terminated` in the main thread.

    SIGBREAK is Ctrl-Break, and what a closed Windows console sends; SIGHUP a closed terminal elsewhere.
    """
    before: dict[int, Any] = {}
    for name in ("SIGTERM", "SIGHUP", "SIGBREAK"):
        number = getattr(signal, name, None)
        # What is ignored stays so: nohup means it.
        if number is not None and signal.getsignal(number) is not signal.SIG_IGN:
            try:
                before[number] = signal.signal(number, raise_terminated)
            except ValueError:
                break  # not in the main thread: the program that called us owns the signals
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def raise_terminated(number: int, frame: FrameType | None) -> NoReturn:
    """Handler of a signal."""
    raise Terminated
