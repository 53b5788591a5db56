"""How a command ends: exit codes, one sentence for an error, signals that unwind it.

`rosproto` and `woosh` use the same codes; 3, a refusal of the chassis, and 5, "not known", are woosh's alone.
"""

from __future__ import annotations

import math
import os
import signal
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any, NoReturn

from rosproto.errors import ConnectionLost, RosError
from rosproto.sentence import led, sentence_of
from rosproto.text import printable

__all__ = [
    "DONE",
    "FAILED",
    "INTERRUPTED",
    "TERMINATED",
    "UNREACHABLE",
    "WRONG_USE",
    "CommandError",
    "Terminated",
    "cannot_listen",
    "explain",
    "output_is_gone",
    "raise_terminated",
    "say",
    "signals_unwind",
]

DONE, FAILED, WRONG_USE, UNREACHABLE = 0, 1, 2, 4
INTERRUPTED, TERMINATED = 130, 143
ONE_SIGNAL = 0.5


class CommandError(RosError):
    """A command cannot do what was asked; the text is the one sentence the user sees."""


class Terminated(BaseException):
    """SIGTERM, SIGQUIT, a hang-up or a closed console: unwinds the program as Ctrl-C does, so that nodes are
    unregistered and motions stopped.
    """


def explain(error: Exception) -> tuple[str, int]:
    """One sentence and the exit code.

    Of a lost connection where, and what happened there: who types commands has no use for our node's name and
    the method that was called.
    """
    text = _one_line(sentence_of(error))
    if isinstance(error, ConnectionLost):
        return (_one_line(led(error.peer, error.why)) if error.peer and error.why else text), UNREACHABLE
    if isinstance(error, RosError):
        return text, error.exit_code
    if isinstance(error, ValueError):
        return text, WRONG_USE
    if isinstance(error, OSError) and error.strerror:
        # Only the standard streams have no name; what is buffered there must not fail again at exit.
        if not error.filename:
            output_is_gone()
        return f"{error.filename or 'cannot write the output'}: {error.strerror}", FAILED
    if isinstance(error, (OSError, KeyError)):
        return text, FAILED
    return f"{type(error).__name__}: {text}; this is a mistake of ours, please report it with --debug", FAILED


def _one_line(text: str) -> str:
    plain = " ".join(text.split())
    return text if text == plain else plain  # the same, and still a Sentence


def cannot_listen(error: ConnectionLost, option: str) -> str:
    """Why this computer does not let a command listen there, with the option to change."""
    from rosproto.transport.os_errors import address_is_not_ours, port_is_taken

    if port_is_taken(error.__cause__):
        return (
            f"listen on {error.peer}: the port is taken (or not allowed); "
            "end what runs there, or choose another --port (0: a free one)"
        )
    if address_is_not_ours(error.__cause__):
        return (
            f"listen on {error.peer}: this computer has no such address; "
            f"give one of its own with {option}, 0.0.0.0 for all of them"
        )
    return str(error)


def say(text: str) -> None:
    """A line on stderr, if there is still somebody to read it."""
    try:
        print(printable(text), file=sys.stderr, flush=True)
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
def signals_unwind(*, until_exit: bool = False) -> Iterator[None]:
    """Within the block SIGTERM, SIGHUP, SIGQUIT and SIGBREAK raise `Terminated` in the main thread.

    SIGBREAK is Ctrl-Break, and what a closed Windows console sends; SIGHUP a closed terminal elsewhere;
    SIGQUIT Ctrl-\\.

    Signals sometimes come in pairs: `timeout` sends its one to the command and then to the whole group.
    What follows within `ONE_SIGNAL` seconds is the same one: raised again, it would end the orderly end
    halfway, and leave a node registered. Later ones count: who presses Ctrl-C again means it.

    Args:
        until_exit: The process ends with the block: the handlers stay, for the end of the interpreter.
    """
    before: dict[int, Any] = {}
    handlers = {name: _once(raise_terminated) for name in ("SIGTERM", "SIGHUP", "SIGQUIT", "SIGBREAK")}
    interrupt = signal.getsignal(signal.SIGINT)
    # A shell ignores it in what a script starts with `&`: who sends it there means it, as to rospy.
    if interrupt is signal.default_int_handler or (until_exit and interrupt is signal.SIG_IGN):
        handlers["SIGINT"] = _once(signal.default_int_handler)
    for name, handler in handlers.items():
        number = getattr(signal, name, None)
        # What else is ignored stays so: nohup means it.
        if number is not None and (name == "SIGINT" or signal.getsignal(number) is not signal.SIG_IGN):
            try:
                before[number] = signal.signal(number, handler)
            except ValueError:
                break  # not in the main thread: the program that called us owns the signals
    try:
        yield
    finally:
        if not until_exit:
            for number, old in before.items():
                signal.signal(number, old)


def _once(handler: Callable[[int, FrameType | None], Any]) -> Callable[[int, FrameType | None], None]:
    """The handler, called for the first signal of several that come at once."""
    last = -math.inf

    def handle(number: int, frame: FrameType | None) -> None:
        nonlocal last
        before, last = last, time.monotonic()
        if last - before > ONE_SIGNAL:
            handler(number, frame)

    return handle


def raise_terminated(number: int, frame: FrameType | None) -> NoReturn:
    """Handler of a signal."""
    raise Terminated
