"""A reverse proxy in front of the SDK's servers: checks who connects, gives each client its own server.

The SDK's server lets everybody in. It therefore listens on a port that is not published, and this proxy
listens in its place: it reads the request that opens the WebSocket (`handshake`), refuses it or makes a
session with its own SDK server, proves to that server who it is (`ProxiedSession.introduction`), and passes
bytes on in both directions, unread. Since all bytes of a client go through here, the proxy notices when it
does not read: its session then keeps the newest message of each topic and hands the SDK no more.

One asyncio loop in one thread serves all clients. Making and closing sessions may have to wait for the robot,
so a few worker threads do that.
"""

from __future__ import annotations

import asyncio
import ssl
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from rosproto.errors import RosTimeout
from rosproto.gateway.foxglove import handshake
from rosproto.gateway.foxglove.client_connection import ClientConnection
from rosproto.gateway.foxglove.proxied_session import MakeSession
from rosproto.gateway.limits import GatewayLimits
from rosproto.logs import get_logger
from rosproto.transport.os_errors import system_errors

__all__ = ["Proxy"]

_log = get_logger("rosproto.gateway")

WORKERS = 8
START_SECONDS = 5.0
FAREWELL_SECONDS = 0.2


class Proxy:
    """Accepts connections and ends them; each one is a `ClientConnection`.

    Args:
        host, port: Where to listen; 0 is a free port.
        tls: For wss.
        check: Returns the name under which a client speaks the protocol, or raises `BadRequest`.
        make_session: Makes the session of a client; called in a worker thread.
        limits: What a client may cost.
        prepare: Called with this object before anybody can connect.

    Raises:
        ConnectionLost: The address cannot be listened on.
    """

    def __init__(
        self,
        host: str,
        port: int,
        *,
        tls: ssl.SSLContext | None,
        check: Callable[[handshake.Request], str],
        make_session: MakeSession,
        limits: GatewayLimits,
        prepare: Callable[[Proxy], object],
    ) -> None:
        self.host, self.port = host, port
        self.limits = limits
        self.check = check
        self.make_session = make_session
        self.tls = tls
        self.accepted = self.refused = self.stalled = 0
        self.connections: set[ClientConnection] = set()
        self.pool = ThreadPoolExecutor(WORKERS, "rosproto:foxglove work")
        self.loop = asyncio.new_event_loop()
        self._server: asyncio.Server | None = None
        self._problem: BaseException | None = None
        self._ready = threading.Event()
        self._closing = False
        prepare(self)
        self._thread = threading.Thread(target=self._run, name="rosproto:foxglove proxy", daemon=True)
        self._thread.start()
        if not self._ready.wait(START_SECONDS):
            raise RosTimeout(f"listening at {host}:{port} did not begin within {START_SECONDS:g} s")
        if self._problem is not None:
            self._thread.join(START_SECONDS)
            self.pool.shutdown(wait=False)
            raise self._problem

    # -- the thread -----------------------------------------------------------------------------------------

    def _run(self) -> None:
        loop = self.loop
        asyncio.set_event_loop(loop)
        loop.set_exception_handler(self._unexpected)
        try:
            where = f"{self.host}:{self.port}"
            with system_errors(f"listen at {where}", where):
                self._server = loop.run_until_complete(self._listen())
            self.port = self._server.sockets[0].getsockname()[1]
        except BaseException as problem:
            self._problem = problem
            loop.close()
            self._ready.set()
            return
        self._ready.set()
        try:
            loop.run_forever()
            loop.run_until_complete(loop.shutdown_asyncgens())
        finally:
            loop.close()

    async def _listen(self) -> asyncio.Server:
        return await self.loop.create_server(
            lambda: ClientConnection(self),
            self.host,
            self.port,
            ssl=self.tls,
            backlog=128,
            ssl_handshake_timeout=None if self.tls is None else self.limits.handshake_seconds,
        )

    def _unexpected(self, loop: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:
        error = context.get("exception")
        if not isinstance(error, (OSError, ssl.SSLError)):  # peers do go away
            _log.error("! foxglove: %s", context.get("message"), exc_info=error)

    def call(self, function: Callable[..., object], *arguments: object) -> None:
        """Call a function in the proxy's thread; does nothing once that has ended."""
        try:
            self.loop.call_soon_threadsafe(function, *arguments)
        except RuntimeError:
            pass  # the loop is closed: nobody is left to be told

    def close(self, timeout: float) -> None:
        """End every connection and the thread, within `timeout` seconds."""
        if self._closing:
            return
        self._closing = True
        self.call(self._end)
        self._thread.join(timeout)
        self.pool.shutdown(wait=False, cancel_futures=True)
        if self._thread.is_alive():
            raise RosTimeout(f"the Foxglove server at {self.host}:{self.port} did not end in {timeout:g} s")

    def _end(self) -> None:
        if self._server is not None:
            self._server.close()
        # The SDK has sent close frames; connections still open after a moment are cut.
        self.loop.call_later(FAREWELL_SECONDS if self.connections else 0.0, self._cut_off)

    def _cut_off(self) -> None:
        for connection in tuple(self.connections):
            connection.hang_up()
        self.loop.call_later(0.02, self.loop.stop)
