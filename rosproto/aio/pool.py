"""Threads for blocking calls, shared by all calls of one asyncio node.

Differences from `asyncio.to_thread`: its threads are not daemons, so a call that hangs keeps the process from
ending; it cannot notify the call that its awaiter was cancelled; and an object that the call opens for a
cancelled task stays open. Here such an object is returned or closed, and closing always completes (`always`).
"""

from __future__ import annotations

import asyncio
import warnings
from collections.abc import Awaitable, Callable, Generator
from concurrent.futures import Future
from functools import partial
from typing import Generic, Protocol, TypeVar

from rosproto.deprecation import former_parameters
from rosproto.logs import get_logger
from rosproto.worker_pool import WorkerPool

logger = get_logger("rosproto.aio")

T = TypeVar("T")


class Pool:
    """A limited number of daemon threads; further calls wait for a free one, except those that close
    something. Idle threads end by themselves.

    Args:
        max_threads: Most threads at a time.
        idle_seconds: A thread without work ends after this.
        name: Of the threads.
        daemon: Whether a program may end before the calls have returned.
    """

    @former_parameters(most="max_threads")
    def __init__(
        self,
        max_threads: int = 64,
        *,
        idle_seconds: float = 10.0,
        name: str = "rosproto:aio",
        daemon: bool = True,
    ) -> None:
        self._max_threads, self._idle_seconds = max_threads, idle_seconds
        self._workers = WorkerPool(name, max_threads, daemon=daemon, idle_seconds=idle_seconds)

    @property
    def most(self) -> int:
        """Deprecated: what was passed as `max_threads`."""
        warnings.warn("Pool.most will be removed; keep what you pass", DeprecationWarning, stacklevel=2)
        return self._max_threads

    @property
    def idle_seconds(self) -> float:
        """Deprecated: what was passed as `idle_seconds`."""
        warnings.warn(
            "Pool.idle_seconds will be removed; keep what you pass", DeprecationWarning, stacklevel=2
        )
        return self._idle_seconds

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
        loop = asyncio.get_running_loop()
        future: asyncio.Future[T] = loop.create_future()
        task = self._workers.add(function, urgent=always)
        take_back = _once(dispose)

        def deliver(done: Future[T]) -> None:
            if not done.cancelled() and not notify(loop, _settle, future, done):
                take_back(done)  # the loop is closed: nothing can receive it

        task.add_done_callback(deliver)
        if always:
            return await _to_the_end(future)
        try:
            return await future
        except (asyncio.CancelledError, GeneratorExit):  # the latter: the loop was closed meanwhile
            if not task.cancel() and dispose is not None:  # it has begun
                task.add_done_callback(lambda done: self.spawn(lambda: take_back(done)))
            if cancel is not None:
                cancel()
            raise

    def start(self, function: Callable[..., T], *arguments: object) -> asyncio.Future[T]:
        """Call something in a thread, whether or not the result is awaited. Call this in the loop."""
        future = asyncio.wrap_future(self._workers.add(partial(function, *arguments)))
        # Retrieved here, so that asyncio does not log it if nothing awaits the call.
        future.add_done_callback(lambda done: done.cancelled() or done.exception())
        return future

    def spawn(self, function: Callable[[], object]) -> None:
        """Call `function` in a thread at once, for a caller that cannot await it; it must not raise."""
        self._workers.add(function, urgent=True)

    def close(self) -> None:
        """End the idle threads now, and each other one when it becomes idle. Does not wait."""
        self._workers.close()


def _once(dispose: Callable[[T], object] | None) -> Callable[[Future[T]], None]:
    """Return a function that disposes of the result of a call, the first time that it is called."""
    left = [dispose]

    def take_back(done: Future[T]) -> None:
        try:
            dispose = left.pop()  # atomic: the thread and the loop may come together
        except IndexError:
            return
        if dispose is None or done.exception() is not None:
            return
        try:
            dispose(done.result())
        except Exception as error:  # nobody waits for the result
            logger.warning("! not closed again after its task was cancelled: %s", error)

    return take_back


async def _to_the_end(future: asyncio.Future[T]) -> T:
    """The result; a task that is cancelled waits for it first."""
    cancelled: asyncio.CancelledError | None = None
    while not future.done():
        try:
            await asyncio.wait([future])
        except asyncio.CancelledError as error:
            cancelled = error
    if cancelled is not None:
        raise cancelled from future.exception()
    return future.result()


def _settle(future: asyncio.Future[T], done: Future[T]) -> None:
    if not future.done():
        error = done.exception()
        if error is None:
            future.set_result(done.result())
        else:
            future.set_exception(error)


def notify(loop: asyncio.AbstractEventLoop, function: Callable[..., object], *arguments: object) -> bool:
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

    def __await__(self) -> Generator[object, None, C]:
        return self._open_it().__await__()

    async def __aenter__(self) -> C:
        self._opened = await self._open_it()
        return self._opened

    async def __aexit__(self, *exc_info: object) -> None:
        if self._opened is not None:
            await self._opened.close()
