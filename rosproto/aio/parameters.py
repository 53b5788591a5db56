"""Parameters for asyncio: get, set and subscribe."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rosproto.aio.mailbox import Closed, Mailbox
from rosproto.aio.pool import PendingOpen, Pool
from rosproto.aio.same_property import SameProperty
from rosproto.node.parameters import Parameters as ThreadedParameters
from rosproto.node.parameters import ParameterSubscription as ThreadedSubscription

_REQUIRED = object()


class Parameters:
    """`await node.params.get("/key")`; see `rosproto.node.Parameters` for what each method does."""

    def __init__(
        self,
        params: ThreadedParameters,
        pool: Pool,
        make_mailbox: Callable[[int], Mailbox[tuple[str, object]]] = Mailbox,
    ) -> None:
        self._params = params
        self._pool = pool
        self._make_mailbox = make_mailbox

    async def get(self, key: str, default: object = _REQUIRED) -> Any:
        """Value of a parameter; `default` if it is not set and one is given, else UnknownParameter."""
        if default is _REQUIRED:
            return await self._pool.run(lambda: self._params[key])
        return await self._pool.run(lambda: self._params.get(key, default))

    async def set(self, key: str, value: object) -> None:
        """Set a parameter; a dict replaces the whole namespace."""
        await self._pool.run(lambda: self._params.set(key, value))

    async def delete(self, key: str) -> None:
        """Delete a parameter or a namespace; UnknownParameter if it is not set."""
        await self._pool.run(lambda: self._params.delete(key))

    async def has(self, key: str) -> bool:
        """Whether it is set."""
        return await self._pool.run(lambda: self._params.has(key))

    async def search(self, key: str) -> str | None:
        """The nearest parameter of that name, searching upwards from the node's namespace; None if there is
        none.
        """
        return await self._pool.run(lambda: self._params.search(key))

    async def names(self) -> list[str]:
        """All keys, sorted."""
        return await self._pool.run(self._params.names)

    def subscribe(self, key: str) -> PendingOpen[ParameterSubscription]:
        """Follow a parameter or a namespace; up to a thousand changes are queued, then the oldest is dropped.

        async with node.params.subscribe("/speed") as changes:
            async for key, value in changes: ...
        """

        async def open_it() -> ParameterSubscription:
            mailbox: Mailbox[tuple[str, object]] = self._make_mailbox(1000)
            subscription = await self._pool.run(
                lambda: self._params.subscribe(key, lambda k, v: mailbox.put((k, v))),
                dispose=lambda opened: opened.close(),
            )
            return ParameterSubscription(subscription, mailbox, self._pool)

        return PendingOpen(open_it)


class ParameterSubscription:
    """Changes of one parameter or namespace, as (key, value); value None means deleted.

    Attributes:
        key: The subscribed key.
    """

    def __init__(
        self, subscription: ThreadedSubscription, mailbox: Mailbox[tuple[str, object]], pool: Pool
    ) -> None:
        self._subscription = subscription
        self.key = subscription.key
        self._mailbox = mailbox
        self._pool = pool

    value = SameProperty[Any](ThreadedSubscription.value, "_subscription")

    def __aiter__(self) -> ParameterSubscription:
        return self

    async def __anext__(self) -> tuple[str, Any]:
        try:
            return await self._mailbox.get()
        except Closed:
            raise StopAsyncIteration from None

    async def close(self) -> None:
        """End it. May be called again."""
        self._mailbox.close()
        await self._pool.run(self._subscription.close, always=True)
