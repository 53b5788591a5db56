"""The result of `node.subscriber(...)` and similar methods: awaitable, and an async context manager."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Generator
from typing import Any, Generic, Protocol, TypeVar


class Closable(Protocol):
    """An object with an awaited `close`."""

    async def close(self) -> None: ...


T = TypeVar("T", bound=Closable)


class PendingOpen(Generic[T]):
    """`sub = await node.subscriber(...)`, or `async with node.subscriber(...) as sub:`, which closes it.

    A task that is cancelled while opening has opened nothing. Leaving the block always closes completely,
    also when cancelled.
    """

    def __init__(self, open_it: Callable[[], Awaitable[T]]) -> None:
        self._open_it = open_it
        self._opened: T | None = None

    def __await__(self) -> Generator[Any, None, T]:
        return self._open_it().__await__()

    async def __aenter__(self) -> T:
        self._opened = await self._open_it()
        return self._opened

    async def __aexit__(self, *exc_info: object) -> None:
        if self._opened is not None:
            await self._opened.close()
