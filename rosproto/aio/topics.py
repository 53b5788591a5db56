"""Publisher and subscriber for asyncio: wrappers of the threaded ones."""

from __future__ import annotations

import asyncio
from typing import Any

from rosproto.aio.mailbox import Closed, Mailbox
from rosproto.aio.pool import Pool
from rosproto.aio.same_property import SameProperty
from rosproto.codec import Message
from rosproto.errors import ConnectionLost, RosTimeout
from rosproto.node import Publisher as ThreadedPublisher
from rosproto.node import Subscriber as ThreadedSubscriber


class Publisher:
    """A publisher; `publish` does not block and so is not a coroutine.

    Attributes:
        publisher: The wrapped threaded publisher: `topic`, `type_name`, `md5sum`, `stats()`.
    """

    def __init__(self, publisher: ThreadedPublisher, pool: Pool) -> None:
        self.publisher = publisher
        self._pool = pool

    def publish(self, message: object = None, **fields: object) -> None:
        """Queue a message for every subscriber; it is encoded before this returns."""
        self.publisher.publish(message, **fields)

    connections = SameProperty[int](ThreadedPublisher.connections, "publisher")

    async def wait_for_connection(self, timeout: float | None = 5.0, count: int = 1) -> None:
        """Wait until `count` subscribers are connected.

        Raises:
            RosTimeout: They are not connected in time.
        """
        await self._pool.run(lambda: self.publisher.wait_for_connection(timeout=timeout, count=count))

    async def close(self) -> None:
        """Stop publishing. May be called again."""
        await self._pool.run(self.publisher.close, always=True)


class Subscriber:
    """A subscriber: `async for message in subscriber`, or `await subscriber.next(timeout)`.

    Messages wait in one queue of `queue_size`; when it is full, the oldest is dropped and counted.

    Attributes:
        subscriber: The wrapped threaded subscriber: `topic`, `type_name`, `md5sum`, `stats()`.
    """

    def __init__(self, subscriber: ThreadedSubscriber, mailbox: Mailbox[Message], pool: Pool) -> None:
        self.subscriber = subscriber
        self._mailbox = mailbox
        self._pool = pool

    def __aiter__(self) -> Subscriber:
        return self

    async def __anext__(self) -> Any:
        try:
            return await self._mailbox.get()
        except Closed:
            raise StopAsyncIteration from None

    async def next(self, timeout: float | None = 10.0) -> Any:
        """The next message.

        Raises:
            RosTimeout: None came within `timeout` seconds.
            ConnectionLost: The subscriber was closed.
        """
        topic = self.subscriber.topic
        try:
            return await self._mailbox.get(timeout)
        except Closed:
            raise ConnectionLost(f"{topic}: the subscriber is closed") from None
        except asyncio.TimeoutError:
            raise RosTimeout(
                f"{topic}: no message within {timeout} s ({self.connections} publishers connected)",
                what=f"message on {topic}",
                seconds=timeout,
            ) from None

    connections = SameProperty[int](ThreadedSubscriber.connections, "subscriber")
    latest = SameProperty[Any](ThreadedSubscriber.latest, "subscriber")

    @property
    def dropped(self) -> int:
        """Messages dropped because the queue was full."""
        return self._mailbox.dropped

    async def close(self) -> None:
        """End the subscription; waiting tasks are told so. May be called again."""
        self._mailbox.close()
        await self._pool.run(self.subscriber.close, always=True)
