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
from typing import NoReturn, TypeAlias

from rosproto.cli.exit_codes import TERMINATED

ONE_SIGNAL = 0.5
_THAT_END = ("SIGTERM", "SIGHUP", "SIGQUIT", "SIGBREAK")
"""SIGHUP is a closed terminal, SIGQUIT Ctrl-\\; SIGBREAK is Ctrl-Break, and a closed console on Windows."""
# learn.microsoft.com/windows/console/handlerroutine
_CLOSE_EVENTS = (2, 5, 6)  # CTRL_CLOSE_EVENT, CTRL_LOGOFF_EVENT, CTRL_SHUTDOWN_EVENT
_WINDOWS_PATIENCE = 4.5  # Windows ends the process 5 s after a closed console
_HANDLER: list[object] = []
Handler: TypeAlias = "Callable[[int, FrameType | None], object] | int | None"


class Terminated(SystemExit):
    """SIGTERM, SIGQUIT, a hang-up or a closed console: unwinds the program as Ctrl-C does, so that nodes are
    unregistered and motions stopped.
    """

    def __init__(self) -> None:
        super().__init__(TERMINATED)


@contextmanager
def signals_unwind(*, until_exit: bool = False, interrupt: bool = True) -> Iterator[None]:
    """Within the block the signals that end a process raise `Terminated` in the main thread.

    A signal may arrive twice: `timeout` sends it to the command and to the group. Signals within `ONE_SIGNAL`
    seconds count as one: a second exception would interrupt the cleanup and leave a node registered. Later
    ones count, such as a second Ctrl-C.

    Args:
        until_exit: The process ends with the block: the handlers stay, for the end of the interpreter.
        interrupt: Also Ctrl-C; a program of the user has it as Python sets it.
    """
    # An ignored SIGHUP stays ignored (nohup). A shell ignores SIGINT and SIGQUIT in background jobs of a
    # script; a command obeys them all the same, as in rospy: a signal must stop the robot.
    handlers = {
        name: _once(raise_terminated)
        for name in _THAT_END
        if not _ignored(name) or (until_exit and name != "SIGHUP")
    }
    if interrupt and (until_exit or signal.getsignal(signal.SIGINT) is signal.default_int_handler):
        handlers["SIGINT"] = _once(signal.default_int_handler)
    with _handled(handlers, until_exit=until_exit):
        yield


@contextmanager
def interrupt_on_signals(*some: str) -> Iterator[None]:
    """Within the block they, or some of them, raise KeyboardInterrupt: they end a recording like Ctrl-C.

    A SIGHUP that is ignored stays ignored: a recording under nohup outlives its terminal. An ignored SIGINT
    does not: a shell ignores it in background jobs of a script.
    """
    names = [name for name in some or ("SIGINT", *_THAT_END) if name != "SIGHUP" or not _ignored(name)]
    with _handled(dict.fromkeys(names, _interrupt)):
        yield


@contextmanager
def signals_ignored() -> Iterator[None]:
    """Ignore them within the block, for short work that must be completed."""
    with _handled(dict.fromkeys(("SIGINT", *_THAT_END), signal.SIG_IGN)):
        yield


@contextmanager
def _handled(handlers: Mapping[str, Handler], *, until_exit: bool = False) -> Iterator[None]:
    """Set handlers of the available signals within the block, or until the process ends."""
    before: dict[int, Handler] = {}
    for name, handler in handlers.items():
        number = getattr(signal, name, None)
        if number is not None:
            try:
                before[number] = signal.signal(number, handler)
            except ValueError:
                break  # not in the main thread: the calling program owns the signals
    try:
        yield
    finally:
        if not until_exit:
            for number, old in before.items():
                signal.signal(number, old)


def _ignored(name: str) -> bool:
    return hasattr(signal, name) and signal.getsignal(getattr(signal, name)) is signal.SIG_IGN


def _once(handler: Callable[[int, FrameType | None], object]) -> Callable[[int, FrameType | None], None]:
    """Call the handler for the first of several simultaneous signals."""
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
    """Return the handler that Windows calls in its own thread; True means handled.

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
