"""Ctrl-C in a function of the program's that the library calls.

What such a function raises is logged, so that it does no harm to a link. But some are called in the main
thread, inside a call of the program's own (a subscriber that closes, with its publisher in the same process),
and there a KeyboardInterrupt is no error of the function: somebody wants the program to end.
"""

from __future__ import annotations

import threading


def is_interrupt(error: BaseException) -> bool:
    """Whether it is to be raised on. In other threads Python raises none: there it is the function's own."""
    return isinstance(error, KeyboardInterrupt) and threading.current_thread() is threading.main_thread()
