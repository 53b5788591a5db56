"""Ctrl-C between the start of a command's process and the start of its work.

Python raises KeyboardInterrupt wherever the program is. Within an import that is a traceback, or another
error that the imported module makes of it. Nothing has been begun then that would need an end.
"""

from __future__ import annotations

import os
import signal
from types import FrameType

__all__ = ["INTERRUPTED", "exit_on_interrupt", "raise_on_interrupt"]

INTERRUPTED = 130
"""Exit code of a command that was interrupted."""


def exit_on_interrupt() -> None:
    """Let Ctrl-C end the process at once, until the command handles it or `raise_on_interrupt` is called."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _exit)


def raise_on_interrupt() -> None:
    """Let Ctrl-C raise KeyboardInterrupt again, for a program of the user."""
    if signal.getsignal(signal.SIGINT) is _exit:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def _exit(number: int, frame: FrameType | None) -> None:
    os._exit(INTERRUPTED)
