"""Calls the verbs in threads for asyncio tasks, and ends what a cancelled task has begun.

A task that is cancelled

* before its call has sent anything: nothing is sent, and the task goes at once;
* when something has begun (a goal, a velocity block): it is ended, and the task waits for that, with a bound;
* in a call that ends something (`stop`, `cancel`, `close`): that completes, and the task waits for it.

Being cancelled again changes nothing. A loop that is closed over a task counts as cancelling it.
"""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Coroutine, Generator
from typing import Any, Generic, TypeVar
from weakref import WeakSet

from rosproto.aio import Pool, notify
from rosproto.coercion import require_callback
from woosh_pure.connection.call_scope import CallScope

T = TypeVar("T")
_THREADS = 64


def in_loop(callback: Callable[[T], object]) -> Callable[[T], object]:
    """The callback for a thread, which has it called in the loop that runs now."""
    loop = asyncio.get_running_loop()
    require_callback(callback)
    return lambda value: notify(loop, callback, value)


class ThreadCalls:
    """The thread pool of one Chassis for its verbs. Usable from several event loops, one after the other.

    Args:
        request: Makes the scope of a call that is asked for now: `ActiveMotions.request`.

    Attributes:
        begun: Goals and velocity blocks that were begun here and are still referenced.
    """

    def __init__(self, request: Callable[[], CallScope]) -> None:
        self._request = request
        self.begun: WeakSet[object] = WeakSet()
        self._pool = Pool(_THREADS, name="woosh:aio")

    async def call(self, function: Callable[[], T]) -> T:
        """Call a verb. What it has begun when the task is cancelled is ended."""
        scope = self._request()

        def work() -> T:
            with scope:
                return function()

        try:
            result = await self._pool.run(work, cancel=scope.refuse, dispose=lambda _: scope.end())
        except asyncio.CancelledError:
            if scope:
                await self.finish(scope.end)
            raise
        except GeneratorExit:  # the loop is closed
            self.spawn(scope.end)
            raise
        self.begun.update(scope.things)
        return result

    async def or_end(self, function: Callable[[], T], end: Callable[[], object]) -> T:
        """Call something that continues what was begun; when cancelled, `end` ends it."""
        try:
            return await self._pool.run(function)
        except asyncio.CancelledError:
            await self.finish(end)
            raise
        except GeneratorExit:
            self.spawn(end)
            raise

    async def finish(self, function: Callable[[], T]) -> T:
        """Call something that ends something, in bounded time; it completes even if the task is cancelled."""
        return await self._pool.run(function, always=True)

    async def opened(self, function: Callable[[], T], dispose: Callable[[T], object]) -> T:
        """Call something that opens something; when cancelled, it is closed again."""
        return await self._pool.run(function, dispose=dispose)

    def spawn(self, function: Callable[[], object]) -> None:
        """Call something in a thread, for a caller that cannot await. It must not raise."""
        self._pool.spawn(function)

    def close(self) -> None:
        """End idle threads."""
        self._pool.close()


class AwaitableProperty(Awaitable[T], Generic[T]):
    """A property that is awaited: `await robot.faults`. Asked for each time it is awaited."""

    def __init__(self, ask: Callable[[], Coroutine[Any, None, T]]) -> None:
        self._ask = ask

    def __await__(self) -> Generator[Any, None, T]:
        return self._ask().__await__()
