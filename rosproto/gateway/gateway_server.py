"""`GatewayState` and `GatewayServer`: what the servers for other programs have in common."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import TypeVar

from rosproto.aio.pool import Pool
from rosproto.gateway.access import Access, Refused
from rosproto.gateway.client_limits import READER_BYTES, GatewayLimits
from rosproto.gateway.client_publications import ClientPublications
from rosproto.gateway.shared_subscriptions import SharedSubscriptions
from rosproto.gateway.velocity_watchdog import VelocityWatchdog
from rosproto.gateway.websocket_server import WebSocketServer
from rosproto.json_text import is_short
from rosproto.json_values import JsonValue
from rosproto.node import Node
from rosproto.watchdog import Watchdog

Self = TypeVar("Self", bound="GatewayServer")
CALLS = 256  # service calls and goals of all clients; each has a thread
LONG_CALLS = 8  # of those, with long arguments: each takes some megabytes until it ends


class GatewayState:
    """The parts of one server that its sessions share.

    Args:
        node: Subscribes, publishes, calls.
        kind: "rosbridge", "foxglove" or "robot-api".
        access: What clients may do.
        limits: Bounds for a client.
        watchdog: Process that sends zero where a client drives if this process dies.

    Attributes:
        pool: Threads for work that waits.
        json: Reads messages of clients.
        shared_subscriptions: Topics that are read.
        velocity_watchdog: Sends zero after clients that drove.
        publications: Topics that are written.
    """

    def __init__(
        self, node: Node, kind: str, access: Access, limits: GatewayLimits, watchdog: Watchdog | None
    ) -> None:
        self.node, self.access, self.limits = node, access, limits
        self.pool = Pool(limits.threads, name=f"rosproto:{kind} work")
        self.json = limits.json_reader()
        self.shared_subscriptions = SharedSubscriptions(node, limits)
        self.velocity_watchdog = VelocityWatchdog(node.clock.now)
        self.publications = ClientPublications(node, self.velocity_watchdog, watchdog=watchdog)
        self._counting = threading.Lock()
        self._waiting = self._waiting_long = 0

    @property
    def max_message_bytes(self) -> int:
        """Longest message of a client in bytes: less where nothing may be written."""
        limit = self.limits.message_bytes
        return limit if self.access.writes_anything else min(READER_BYTES, limit)

    async def read_json(self, data: str | bytes) -> JsonValue:
        """The JSON value of a client's message, None of an empty one; a long one is decoded in a thread.

        Raises:
            JsonError: It is not JSON, or has too many values.
        """
        return self.json.one(data) if is_short(data) else await self.pool.run(partial(self.json.one, data))

    @contextmanager
    def waiting(self, *, long: bool = False) -> Iterator[None]:
        """Count a call or goal that waits for its answer.

        Args:
            long: Its arguments are long.

        Raises:
            Refused: Too many wait.
        """
        with self._counting:
            if self._waiting >= CALLS:
                raise Refused(
                    f"{CALLS} calls of all clients together have not been answered; try again later"
                )
            if long and self._waiting_long >= LONG_CALLS:
                raise Refused(
                    f"{LONG_CALLS} calls and goals with long arguments, of all clients together, "
                    "have not ended; try again later"
                )
            self._waiting += 1
            self._waiting_long += long
        try:
            yield
        finally:
            with self._counting:
                self._waiting -= 1
                self._waiting_long -= long

    def close(self, timeout: float) -> None:
        """Release everything, after the sessions have ended."""
        self.publications.close()
        self.shared_subscriptions.close()
        self.pool.close()


class GatewayServer:
    """A server, as a program uses it.

    Args:
        state: Closed with the server.
        serve: Starts the server below.
    """

    def __init__(self, state: GatewayState, serve: Callable[[], WebSocketServer]) -> None:
        self.node, self.access, self.limits = state.node, state.access, state.limits
        self._gateway = state
        self._closing = threading.Lock()
        self._closed = False
        try:
            self._server = serve()
        except BaseException:
            state.close(1.0)
            raise
        self.node.before_close(self._stop_driving)
        self.node.add_closer(self.close)

    @property
    def host(self) -> str:
        """The address it listens on."""
        return self._server.host

    @property
    def port(self) -> int:
        """The port it listens on."""
        return self._server.port

    @property
    def url(self) -> str:
        """The address for clients, without the token: "ws://127.0.0.1:9090"."""
        return self._server.url

    @property
    def closed(self) -> bool:
        """True once `close` was called."""
        return self._closed

    def _stop_driving(self, reason: str) -> None:
        """Send zeros before the node closes."""
        self._gateway.velocity_watchdog.close()

    def close(self, timeout: float = 5.0) -> None:
        """Send zeros where a client drives, then end all connections. May be called again.

        Raises:
            RosTimeout: It took too long; the rest ends by itself.
        """
        with self._closing:
            closed, self._closed = self._closed, True
        if closed:
            return
        self.node.remove_closer(self.close)
        end = time.monotonic() + timeout
        self._gateway.velocity_watchdog.close()
        try:
            self._server.close(max(0.1, end - time.monotonic()))
        finally:
            self._gateway.close(max(0.1, end - time.monotonic()))

    def __enter__(self: Self) -> Self:
        return self

    def __exit__(self, *exc_info: object) -> None:
        self.close()

    def __repr__(self) -> str:
        state = "closed" if self._closed else f"{len(self._server.channels)} clients"
        return f"<{type(self).__name__} {self.url}, {state}>"
