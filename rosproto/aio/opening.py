"""What `node.subscriber(...)` and its sisters give: awaitable, and a context manager."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Generator
from typing import Any, Generic, Protocol, TypeVar


class Closable(Protocol):
    """What can be opened can be closed again."""

    async def close(self) -> None: ...


T = TypeVar("T", bound=Closable)


class PendingOpen(Generic[T]):
    """`sub = await node.subscriber(...)`, or `async with node.subscriber(...) as sub:`, which closes it.

    A task that is cancelled meanwhile has opened nothing; leaving the block closes to the end, also then.
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
