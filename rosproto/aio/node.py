"""`Node` for asyncio: a wrapper of the threaded node."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Generator
from functools import partial
from typing import Any, TypeVar
from weakref import WeakSet

from rosproto.action import ActionClient as ThreadedClient
from rosproto.action import ActionServer as ThreadedServer
from rosproto.aio.actions import ActionClient, ActionServer
from rosproto.aio.mailbox import Mailbox
from rosproto.aio.parameters import Parameters
from rosproto.aio.pool import Closable, PendingOpen, Pool
from rosproto.aio.services import ServiceClient, ServiceServer, handler_in_loop
from rosproto.aio.topics import Publisher, Subscriber
from rosproto.codec import Message
from rosproto.errors import ConnectionLost
from rosproto.node import Node as ThreadedNode
from rosproto.node.definitions.type_argument import ServiceTypeGiven, TypeGiven

T = TypeVar("T")
V = TypeVar("V", bound=Closable)


class Node:
    """A node whose blocking calls are awaited.

        async with aio.Node("/laptop", master_uri=...) as node:
            async with node.subscriber("/scan", LaserScan) as scans:
                async for scan in scans: ...

    Arguments are those of `rosproto.Node`. Everything that it opens belongs to the loop in which it is
    opened. Publishers, subscribers, clients and servers are opened by awaiting (`sub = await
    node.subscriber(...)`) or by `async with`, because registering them calls the master.

    Attributes:
        node: The wrapped threaded node; None before it is opened.
    """

    def __init__(self, name: str, *, max_threads: int = 64, **options: Any) -> None:
        self._arguments: tuple[str, dict[str, Any]] = (name, options)
        self._pool = Pool(max_threads, name=f"rosproto:aio {name}")
        self._shared = False
        self._closed = False
        self._opening = asyncio.Lock()
        self._mailboxes: WeakSet[Mailbox[Any]] = WeakSet()
        self.node: ThreadedNode | None = None

    async def _open(self) -> Node:
        async with self._opening:  # two tasks that open it get the same node
            if self.node is None:
                name, options = self._arguments
                try:
                    node = await self._pool.run(lambda: ThreadedNode(name, **options), dispose=_close)
                except BaseException:
                    self._pool.close()  # keeps no idle threads; opening may be tried again
                    raise
                if self._closed:
                    await self._pool.run(node.close, always=True)
                    raise ConnectionLost(f"{name}: closed by another task while it was being opened")
                self._attach(node)
        return self

    def __await__(self) -> Generator[object, None, Node]:
        return self._open().__await__()

    async def __aenter__(self) -> Node:
        return await self._open()

    async def __aexit__(self, *exc_info: object) -> None:
        await self.close()

    @property
    def _threaded(self) -> ThreadedNode:
        if self.node is None:
            raise RuntimeError("open the node first: `async with aio.Node(...) as node`, or `await` it")
        return self.node

    @property
    def name(self) -> str:
        """Full name in the graph."""
        return self._threaded.name

    @property
    def params(self) -> Parameters:
        """The parameters of the graph."""
        return Parameters(self._threaded.params, self._pool, self._mailbox)

    def _mailbox(self, size: int) -> Mailbox[T]:
        """A mailbox that closes with the node, whoever closes that."""
        mailbox: Mailbox[T] = Mailbox(size)
        self._mailboxes.add(mailbox)
        if self._threaded.closed:
            mailbox.close()
        return mailbox

    def _end(self, reason: str) -> None:
        for mailbox in list(self._mailboxes):
            mailbox.close()

    def _attach(self, node: ThreadedNode) -> None:
        self.node = node
        node.on_shutdown(self._end)

    def _opens(self, view: Callable[[T, Pool], V], prepare: Callable[[], Callable[[], T]]) -> PendingOpen[V]:
        """Awaiting the result calls `prepare` in the loop, then in a thread the function that it returned,
        and wraps with `view` what that returns.
        """

        async def opened() -> V:
            return view(await self._pool.run(prepare(), dispose=_close), self._pool)

        return PendingOpen(opened)

    def publisher(self, topic: str, type: TypeGiven, **options: Any) -> PendingOpen[Publisher]:
        """Publish a topic; arguments as `rosproto.Node.publisher`."""
        node = self._threaded
        return self._opens(Publisher, lambda: partial(node.publisher, topic, type, **options))

    def subscriber(
        self, topic: str, type: TypeGiven = None, *, queue_size: int = 10, **options: Any
    ) -> PendingOpen[Subscriber]:
        """Subscribe to a topic; arguments as `rosproto.Node.subscriber`, without a callback."""
        node = self._threaded

        async def open_it() -> Subscriber:
            mailbox: Mailbox[Message] = self._mailbox(queue_size)
            subscriber = await self._pool.run(
                lambda: node.subscriber(topic, type, callback=mailbox.put, queue_size=queue_size, **options),
                dispose=_close,
            )
            return Subscriber(subscriber, mailbox, self._pool)

        return PendingOpen(open_it)

    def service_client(
        self, name: str, type: ServiceTypeGiven, *, persistent: bool = False
    ) -> PendingOpen[ServiceClient]:
        """A client of a service; arguments as `rosproto.Node.service_client`."""
        node = self._threaded
        return self._opens(
            ServiceClient, lambda: partial(node.service_client, name, type, persistent=persistent)
        )

    def service_server(
        self, name: str, type: ServiceTypeGiven, handler: Callable[[Any], object]
    ) -> PendingOpen[ServiceServer]:
        """Provide a service; `handler`, a coroutine function or a fast plain function, is called in this
        loop.
        """
        node = self._threaded
        return self._opens(
            ServiceServer, lambda: partial(node.service_server, name, type, handler_in_loop(handler))
        )

    def action_client(self, name: str, type: Any, **options: Any) -> PendingOpen[ActionClient]:
        """A client of an action; arguments as `rosproto.ActionClient`."""
        node = self._threaded
        return self._opens(ActionClient, lambda: partial(ThreadedClient, node, name, type, **options))

    def action_server(
        self, name: str, type: Any, handler: Callable[[Any], object], **options: Any
    ) -> PendingOpen[ActionServer]:
        """Provide an action; `handler`, a coroutine function, is called in this loop with each ServerGoal."""
        node = self._threaded
        return self._opens(
            ActionServer,
            lambda: partial(ThreadedServer, node, name, type, handler_in_loop(handler), **options),
        )

    async def wait_for_service(self, name: str, timeout: float | None = 10.0) -> None:
        """Wait until the service has a provider.

        Raises:
            RosTimeout: It has none in time.
        """
        node = self._threaded
        await self._pool.run(lambda: node.wait_for_service(name, timeout=timeout))

    async def close(self) -> None:
        """Close the node and everything opened with it; a view leaves its node open.

        May be called again. Closing always completes: a task that is cancelled meanwhile waits for it.
        """
        self._closed = True
        try:
            if self.node is not None and not self._shared:
                await self._pool.run(self.node.close, always=True)
        finally:
            self._pool.close()


def _close(opened: Any) -> None:
    """Close an object opened for a task that has been cancelled meanwhile."""
    opened.close()


def view(node: ThreadedNode, *, max_threads: int = 64) -> Node:
    """An asyncio wrapper of an existing node; both may be used at the same time.

    Closing the view does not close the node: close what you opened in the view yourself (`async with`).
    """
    seen = Node(node.name, max_threads=max_threads)
    seen._attach(node)
    seen._shared = True
    return seen
