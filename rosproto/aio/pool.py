"""Threads for calls that block, shared by all calls of one asyncio node.

`asyncio.to_thread` would do but for two things: its threads are no daemons, so a call that hangs keeps the
process from ending, and it cannot tell the call that its awaiter was cancelled.
"""

from __future__ import annotations

import asyncio
import threading
from collections import deque
from collections.abc import Callable
from typing import Any, TypeVar

__all__ = ["Pool"]

T = TypeVar("T")
Work = Callable[[], "Callable[[], object] | None"]
"""What a thread does, and what it then does with the result (tell the loop)."""


class Pool:
    """At most `most` daemon threads; further calls wait for one of them. Idle ones end by themselves.

    Attributes:
        most: Most threads at a time.
        idle_seconds: A thread without work ends after this.
    """

    def __init__(self, most: int = 64, *, idle_seconds: float = 10.0, name: str = "aio") -> None:
        self.most = most
        self.idle_seconds = idle_seconds
        self._name = name
        self._work: deque[Work] = deque()
        self._changed = threading.Condition()
        self._threads = self._idle = 0
        self._closed = False

    async def run(
        self,
        function: Callable[[], T],
        *,
        cancel: Callable[[], None] | None = None,
        dispose: Callable[[T], None] | None = None,
    ) -> T:
        """Await `function()` called in a thread.

        Args:
            function: Called without arguments.
            cancel: Called when the awaiting task is cancelled, to make `function` end early; what it
                returns or raises after that is dropped.
            dispose: Called in a thread with what `function` returned for nobody, to close it again.
        """
        loop = asyncio.get_running_loop()
        future: asyncio.Future[T] = loop.create_future()
        self._put(lambda: self._call(function, future, loop, dispose))
        try:
            return await future
        except asyncio.CancelledError:
            if cancel is not None:
                cancel()
            raise

    def close(self) -> None:
        """End the threads that are idle now, and from now on each one that becomes idle. Does not wait."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()

    def _put(self, work: Work) -> None:
        with self._changed:
            self._work.append(work)
            if self._idle >= len(self._work):
                self._changed.notify()
            elif self._threads < self.most:
                self._threads += 1
                threading.Thread(target=self._serve, name=f"rosproto:{self._name}", daemon=True).start()

    def _serve(self) -> None:
        while True:
            with self._changed:
                if not self._work:
                    self._idle += 1
                    self._changed.wait_for(lambda: self._work or self._closed, self.idle_seconds)
                    self._idle -= 1
                if not self._work:
                    self._threads -= 1
                    return
                work = self._work.popleft()
            tell = work()
            if tell is not None:
                # Free before the result is known: the next call, made because of it, finds this thread.
                with self._changed:
                    self._idle += 1
                tell()
                with self._changed:
                    self._idle -= 1

    def _call(
        self,
        function: Callable[[], T],
        future: asyncio.Future[T],
        loop: asyncio.AbstractEventLoop,
        dispose: Callable[[T], None] | None,
    ) -> Callable[[], object] | None:
        if future.cancelled():
            return None
        try:
            result = function()
        except BaseException as error:
            problem = error  # the name in `except` is gone when it is told
            return lambda: notify(loop, _fail, future, problem)
        return lambda: notify(loop, self._settle, future, result, dispose)

    def _settle(self, future: asyncio.Future[T], result: T, dispose: Callable[[T], None] | None) -> None:
        if not future.done():
            future.set_result(result)
        elif dispose is not None:
            self._put(lambda: dispose(result))


def _fail(future: asyncio.Future[T], error: BaseException) -> None:
    if not future.done():
        future.set_exception(error)


def notify(loop: asyncio.AbstractEventLoop, function: Callable[..., Any], *arguments: Any) -> None:
    """Call a function in the loop from any thread; a loop that is closed has nobody left to be told."""
    try:
        loop.call_soon_threadsafe(function, *arguments)
    except RuntimeError:
        if not loop.is_closed():
            raise
