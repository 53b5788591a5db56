"""The moment a Windows console is closed: the command ends in order, and is given the time for it."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

__all__ = ["close_handler", "linger_when_closed"]

# learn.microsoft.com/windows/console/handlerroutine
_CLOSE_EVENTS = (2, 5, 6)  # CTRL_CLOSE_EVENT, CTRL_LOGOFF_EVENT, CTRL_SHUTDOWN_EVENT
_WINDOWS_PATIENCE = 4.5  # Windows ends the process 5 s after a closed console
_HANDLER: list[Any] = []


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
