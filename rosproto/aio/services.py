"""Service client and server for asyncio: wrappers of the threaded ones."""

from __future__ import annotations

import asyncio
import inspect
import threading
from collections.abc import Callable
from typing import Any

from rosproto.aio.pool import Pool
from rosproto.node.services.client import ServiceClient as ThreadedClient
from rosproto.node.services.link import Cancellation
from rosproto.node.services.server import ServiceServer as ThreadedServer


class ServiceClient:
    """Calls one service; any number of tasks may call at the same time.

    A call uses one of the node's pool of threads while it waits. Cancelling the task closes that call's
    connection: a request that is not sent yet is not sent, otherwise the provider may still carry it out.

    Attributes:
        client: The wrapped threaded client: `name`, `type_name`, `md5sum`, `stats()`.
    """

    def __init__(self, client: ThreadedClient, pool: Pool) -> None:
        self.client = client
        self._pool = pool

    async def call(self, request: object = None, timeout: float | None = 10.0, **fields: object) -> Any:
        """Call the service; arguments, result and errors as for `rosproto.node.ServiceClient.call`."""
        cancellation = Cancellation()
        return await self._pool.run(
            lambda: self.client.call_cancellable(cancellation, request, timeout, **fields),
            cancel=cancellation.cancel,
        )

    __call__ = call

    async def wait(self, timeout: float | None = 10.0) -> None:
        """Wait until a provider answers a probe.

        Raises:
            RosTimeout: None did in time.
        """
        stop = threading.Event()
        await self._pool.run(lambda: self.client.wait(timeout, stop=stop), cancel=stop.set)

    async def close(self) -> None:
        """Close; calls in progress raise ConnectionLost. May be called again."""
        await self._pool.run(self.client.close, always=True)


class ServiceServer:
    """Provides one service.

    Attributes:
        server: The wrapped threaded server: `name`, `type_name`, `md5sum`, `stats()`.
    """

    def __init__(self, server: ThreadedServer, pool: Pool) -> None:
        self.server = server
        self._pool = pool

    async def close(self, timeout: float = 2.0) -> None:
        """Stop providing the service. Running calls may be answered within `timeout`. May be called again."""
        await self._pool.run(lambda: self.server.close(timeout), always=True)


def handler_in_loop(handler: Callable[[Any], object]) -> Callable[[object], object]:
    """A handler for a threaded server that calls `handler` in the running loop.

    A coroutine function becomes a task there; a plain function must not block. The return value is that of a
    threaded handler.
    """
    loop = asyncio.get_running_loop()

    async def answer(request: object) -> object:
        result = handler(request)
        return await result if inspect.isawaitable(result) else result

    def in_thread(request: object) -> object:
        return asyncio.run_coroutine_threadsafe(answer(request), loop).result()

    return in_thread
