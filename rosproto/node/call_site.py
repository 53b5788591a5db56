"""Where a program made a subscriber, a service or an action server: has that call returned?

Messages may come before the constructor has returned: a latched one comes at once, and between two nodes of
one process nothing takes any time. Programs do not expect their callback to run before
`self.scan = node.subscriber(...)` has assigned anything. So the first call of a callback waits until the
program has gone on behind that call; no later one asks.

The frame itself is not kept, as it would keep everything alive that the caller had: where it stood is enough.
"""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Iterator
from functools import partial
from itertools import accumulate, chain, islice, repeat, takewhile
from operator import is_not, itemgetter
from types import FrameType
from typing import Any

from rosproto.codec import pause

__all__ = ["CallSite"]

PATIENCE = 0.25  # seconds; a loop may come back to the same place again and again
LOOK_EVERY = 0.0005

_is_frame = partial(is_not, None)  # and no function of Python: see `_stack_of`


class CallSite:
    """One call in one thread.

    Args:
        frame: The caller's: `sys._getframe(1)` in a constructor.
    """

    __slots__ = ("_code", "_depth", "_done", "_place", "_thread")

    def __init__(self, frame: FrameType) -> None:
        self._done = False
        self._thread = threading.get_ident()
        self._code = frame.f_code
        self._place = frame.f_lasti
        self._depth = _depth(frame)

    @property
    def is_here(self) -> bool:
        """True in the thread of that call, while it has not returned: waiting would be in vain."""
        return threading.get_ident() == self._thread and not self.is_left

    @property
    def is_left(self) -> bool:
        """True when the program has gone on behind the call."""
        stack = _stack_of(self._thread)
        if len(stack) < self._depth:
            return True
        caller = stack[-self._depth]
        return caller.f_code is not self._code or caller.f_lasti != self._place

    def wait(self) -> None:
        """Return when the program has gone on; after `PATIENCE` in any case, at once in its own thread."""
        if self._done or threading.get_ident() == self._thread:
            return
        end = time.monotonic() + PATIENCE
        while not self.is_left and time.monotonic() < end:
            time.sleep(LOOK_EVERY)
        self._done = True


def _stack_of(thread: int) -> list[FrameType]:
    """What that thread runs now, the innermost call first; empty when it has ended.

    It is taken in one step of the interpreter, without a line of Python in between: the thread does not go on
    meanwhile. A chain of frames that return while it is followed is not safe to follow; CPython 3.11.7 was
    seen to crash there, once.

    The collector is kept away meanwhile: before 3.11.9 the interpreter holds its list of threads while it
    makes the frame objects. Should that begin a collection, and this end a `threading.local`, the same thread
    waits for the list that it holds itself, and has the interpreter's lock: the process stands still, and
    every time-out in it (github.com/python/cpython/issues/106883).
    """
    stack: list[FrameType] = []
    all_threads = map(itemgetter(thread), iter(sys._current_frames, None))
    outwards: Iterator[Any] = accumulate(chain(islice(all_threads, 1), repeat("f_back")), getattr)
    pause.pause()
    try:
        stack.extend(takewhile(_is_frame, outwards))
    except KeyError:
        return []
    finally:
        pause.resume()
    return stack


def _depth(frame: FrameType | None) -> int:
    count = 0
    while frame is not None:
        count += 1
        frame = frame.f_back
    return count
