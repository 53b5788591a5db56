"""Threads for blocking calls, shared by all calls of one asyncio node.

Differences from `asyncio.to_thread`: its threads are no daemons, so a call that hangs keeps the process from
ending; it cannot notify the call that its awaiter was cancelled; and an object that the call opens for a
cancelled task stays open. Here such an object is returned or closed, and closing always completes (`always`).
"""

from __future__ import annotations

import asyncio
import threading
from collections import deque
from collections.abc import Awaitable, Callable, Generator
from typing import Any, Generic, Protocol, TypeVar

from rosproto.logs import get_logger

logger = get_logger("rosproto.aio")

T = TypeVar("T")
Work = Callable[[], "Callable[[], object] | None"]
"""Work of a thread; it returns a function that passes the result to the loop, or None."""


class Pool:
    """At most `most` daemon threads; further calls wait for a free one, except those that close something.
    Idle threads end by themselves.

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
        cancel: Callable[[], object] | None = None,
        dispose: Callable[[T], object] | None = None,
        always: bool = False,
    ) -> T:
        """Call `function()` in a thread and await the result.

        Args:
            function: Called without arguments.
            cancel: Called when the awaiting task is cancelled, to make `function` end early; its result or
                error is then dropped.
            dispose: Called in a thread with a result that no task receives, to close it. This includes a task
                that is cancelled in the pass of the loop in which the result arrives, and a loop that is
                closed meanwhile.
            always: For closing. The call is made even if the task is cancelled before a thread is free, does
                not wait for a free thread, and a cancelled task waits for its end; the call must take bounded
                time.
        """
        call = _Call(self, function, dispose)
        self._put(call, urgent=always)
        if always:
            return await call.to_the_end()
        try:
            return await call.future
        except (asyncio.CancelledError, GeneratorExit):  # the latter: the loop was closed meanwhile
            call.abandon()
            if cancel is not None:
                cancel()
            raise

    def spawn(self, function: Callable[[], object]) -> None:
        """Call `function` in a thread at once, for a caller that cannot await it; it must not raise."""

        def work() -> None:
            function()

        self._put(work, urgent=True)

    def close(self) -> None:
        """End the idle threads now, and each other one when it becomes idle. Does not wait."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()

    def _put(self, work: Work, *, urgent: bool = False) -> None:
        with self._changed:
            if urgent:
                self._work.appendleft(work)
            else:
                self._work.append(work)
            if self._idle >= len(self._work):
                self._changed.notify()
            elif urgent or self._threads < self.most:
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
            notify_loop = work()
            if notify_loop is not None:
                # Free before the result is delivered: the call that follows it then finds this thread.
                with self._changed:
                    self._idle += 1
                notify_loop()
                with self._changed:
                    self._idle -= 1


class _Call(Generic[T]):
    """One call in a thread. The awaiting task receives the result, or it is disposed of: the later of the
    two, the thread with a result or the cancelled task, notices the other.

    Attributes:
        future: The result, in the loop.
    """

    def __init__(self, pool: Pool, function: Callable[[], T], dispose: Callable[[T], object] | None) -> None:
        self._pool = pool
        self._function = function
        self._dispose = dispose
        self._loop = asyncio.get_running_loop()
        self.future: asyncio.Future[T] = self._loop.create_future()
        self._lock = threading.Lock()
        self._opened: list[T] = []
        self._abandoned = False

    def __call__(self) -> Callable[[], object] | None:
        """Call the function in a thread; return the function that notifies the loop."""
        if self._abandoned:
            return None  # it was cancelled before it began
        try:
            result = self._function()
        except BaseException as error:
            problem = error  # Python deletes the name of `except` after the block
            return lambda: notify(self._loop, _fail, self.future, problem)
        with self._lock:
            self._opened.append(result)
            abandoned = self._abandoned
        if abandoned:
            self._take_back()
            return None
        return lambda: self._tell(result)

    def _tell(self, result: T) -> None:
        if not notify(self._loop, _settle, self.future, result):
            self._take_back()  # the loop is closed: nothing can receive it

    def abandon(self) -> None:
        """The task is gone: close the result, now or when it comes."""
        with self._lock:
            self._abandoned = True
            opened = bool(self._opened)
        if opened:
            self._pool.spawn(self._take_back)

    def _take_back(self) -> None:
        with self._lock:
            opened, self._opened = self._opened, []
        if self._dispose is None:
            return
        for each in opened:
            try:
                self._dispose(each)
            except Exception as error:  # nobody waits for the result
                logger.warning("! not closed again after its task was cancelled: %s", error)

    async def to_the_end(self) -> T:
        """The result; a task that is cancelled waits for it first."""
        cancelled: asyncio.CancelledError | None = None
        while not self.future.done():
            try:
                await asyncio.wait([self.future])
            except asyncio.CancelledError as error:
                cancelled = error
        if cancelled is not None:
            raise cancelled from self.future.exception()
        return self.future.result()


def _settle(future: asyncio.Future[T], result: T) -> None:
    if not future.done():
        future.set_result(result)


def _fail(future: asyncio.Future[T], error: BaseException) -> None:
    if not future.done():
        future.set_exception(error)


def notify(loop: asyncio.AbstractEventLoop, function: Callable[..., Any], *arguments: Any) -> bool:
    """Call a function in the loop from any thread; False if the loop is closed."""
    try:
        loop.call_soon_threadsafe(function, *arguments)
    except RuntimeError:
        if not loop.is_closed():
            raise
        return False
    return True


class Closable(Protocol):
    """An object with an awaited `close`."""

    async def close(self) -> None: ...


C = TypeVar("C", bound=Closable)


class PendingOpen(Generic[C]):
    """`sub = await node.subscriber(...)`, or `async with node.subscriber(...) as sub:`, which closes it.

    A task that is cancelled while opening has opened nothing. Leaving the block always closes completely,
    also when cancelled.
    """

    def __init__(self, open_it: Callable[[], Awaitable[C]]) -> None:
        self._open_it = open_it
        self._opened: C | None = None

    def __await__(self) -> Generator[Any, None, C]:
        return self._open_it().__await__()

    async def __aenter__(self) -> C:
        self._opened = await self._open_it()
        return self._opened

    async def __aexit__(self, *exc_info: object) -> None:
        if self._opened is not None:
            await self._opened.close()
