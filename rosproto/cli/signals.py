"""Ends a command in order on signals and when its console is closed."""

from __future__ import annotations

import math
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from types import FrameType
from typing import Any, NoReturn

ONE_SIGNAL = 0.5
_THAT_END = ("SIGTERM", "SIGHUP", "SIGQUIT", "SIGBREAK")
"""SIGHUP is a closed terminal, SIGQUIT Ctrl-\\; SIGBREAK is Ctrl-Break, and a closed console on Windows."""
# learn.microsoft.com/windows/console/handlerroutine
_CLOSE_EVENTS = (2, 5, 6)  # CTRL_CLOSE_EVENT, CTRL_LOGOFF_EVENT, CTRL_SHUTDOWN_EVENT
_WINDOWS_PATIENCE = 4.5  # Windows ends the process 5 s after a closed console
_HANDLER: list[Any] = []


class Terminated(BaseException):
    """SIGTERM, SIGQUIT, a hang-up or a closed console: unwinds the program as Ctrl-C does, so that nodes are
    unregistered and motions stopped.
    """


@contextmanager
def signals_unwind(*, until_exit: bool = False) -> Iterator[None]:
    """Within the block the signals that end a process raise `Terminated` in the main thread.

    Signals sometimes come in pairs: `timeout` sends its one to the command and then to the whole group.
    What follows within `ONE_SIGNAL` seconds is the same one: raised again, it would end the orderly end
    halfway, and leave a node registered. Later ones count: who presses Ctrl-C again means it.

    Args:
        until_exit: The process ends with the block: the handlers stay, for the end of the interpreter.
    """
    # What is ignored stays so: nohup means it.
    handlers = {name: _once(raise_terminated) for name in _THAT_END if not _ignored(name)}
    interrupt = signal.getsignal(signal.SIGINT)
    # A shell ignores it in what a script starts with `&`: who sends it there means it, as to rospy.
    if interrupt is signal.default_int_handler or (until_exit and interrupt is signal.SIG_IGN):
        handlers["SIGINT"] = _once(signal.default_int_handler)
    with _handled(handlers, until_exit=until_exit):
        yield


@contextmanager
def interrupt_on_signals() -> Iterator[None]:
    """Within the block they raise KeyboardInterrupt: a recording or a replay is ended by them as by Ctrl-C.

    A SIGHUP that is ignored stays ignored: a recording under nohup outlives its terminal. An ignored SIGINT
    does not: a shell ignores it in whatever a script starts with `&`, and who sends it there means it.
    """
    names = [name for name in ("SIGINT", *_THAT_END) if name != "SIGHUP" or not _ignored(name)]
    with _handled(dict.fromkeys(names, _interrupt)):
        yield


@contextmanager
def signals_ignored() -> Iterator[None]:
    """Within the block they do nothing; for what must come to its end, and does so soon."""
    with _handled(dict.fromkeys(("SIGINT", *_THAT_END), signal.SIG_IGN)):
        yield


@contextmanager
def _handled(handlers: Mapping[str, Any], *, until_exit: bool = False) -> Iterator[None]:
    """Within the block, or until the process ends, these signals, as far as there are such, have handlers."""
    before: dict[int, Any] = {}
    for name, handler in handlers.items():
        number = getattr(signal, name, None)
        if number is not None:
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


def _ignored(name: str) -> bool:
    return hasattr(signal, name) and signal.getsignal(getattr(signal, name)) is signal.SIG_IGN


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


def _interrupt(number: int, frame: FrameType | None) -> NoReturn:
    raise KeyboardInterrupt


@contextmanager
def linger_when_closed() -> Iterator[None]:
    """On Windows: when the console is closed, keep the process alive until the block has ended.

    Windows ends a process as soon as its handlers of a closed console have returned. Python's own handler
    returns at once, before a motion is stopped or a bag is complete; this one, which is asked first, has the
    main thread terminated and waits for it.
    """
    if sys.platform != "win32" or threading.current_thread() is not threading.main_thread():
        yield
        return
    done = threading.Event()
    _install(close_handler(done))
    try:
        yield
    finally:
        done.set()


def close_handler(done: threading.Event) -> Callable[[int], bool]:
    """What Windows calls in a thread of its own: True says that the event was dealt with.

    The command's own handler of SIGBREAK (`signals_unwind`) ends it. While a motion is being stopped that
    signal is ignored: then it is only waited for.
    """

    def handle(event: int) -> bool:
        if event not in _CLOSE_EVENTS:
            return False  # Ctrl-C and Ctrl-Break are Python's
        number = getattr(signal, "SIGBREAK", signal.SIGTERM)
        if callable(signal.getsignal(number)):
            signal.raise_signal(number)  # noted here, handled by the main thread
        done.wait(_WINDOWS_PATIENCE)
        return True

    return handle


def _install(handle: Callable[[int], bool]) -> None:  # pragma: no cover  (Windows only)
    try:
        import ctypes

        kind = getattr(ctypes, "WINFUNCTYPE")(ctypes.c_int, ctypes.c_uint32)  # noqa: B009
        _HANDLER[:] = [kind(handle)]  # kept: Windows holds only its address
        getattr(ctypes, "windll").kernel32.SetConsoleCtrlHandler(_HANDLER[0], 1)  # noqa: B009
    except (AttributeError, ImportError, OSError):
        return
