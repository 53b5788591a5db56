"""One client's connection to the proxy: its handshake is checked, then bytes pass in both directions."""

from __future__ import annotations

import asyncio
import socket
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, cast

from rosproto.gateway.foxglove import handshake
from rosproto.gateway.foxglove.proxied_session import ProxiedSession
from rosproto.gateway.foxglove.upstream_connection import UpstreamConnection
from rosproto.logs import get_logger

if TYPE_CHECKING:
    from rosproto.gateway.foxglove.proxy import Proxy

__all__ = ["ClientConnection"]

_log = get_logger("rosproto.gateway")

LOOPBACK = "127.0.0.1"
HIGH_WATER = 1 << 20  # bytes waiting here for one client before its session is told to pause


class ClientConnection(asyncio.Protocol):
    """Everything here runs in the proxy's thread.

    Args:
        proxy: Whose client it is.

    Attributes:
        peer: The client's address.
        session: Its session, once it has been let in.
        paused: The client reads more slowly than it is sent to.
    """

    def __init__(self, proxy: Proxy) -> None:
        self._proxy = proxy
        self.peer = "?"
        self.session: ProxiedSession | None = None
        self.paused = False
        self._transport: asyncio.Transport | None = None
        self._upstream: UpstreamConnection | None = None
        self._buffer = bytearray()
        self._opening: asyncio.Task[None] | None = None
        self._timer: asyncio.TimerHandle | None = None
        self._unread = 0  # bytes that were waiting when the client's progress was last checked
        self._gone = False

    # -- the connection -------------------------------------------------------------------------------------

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        proxy = self._proxy
        self._transport = made = cast(asyncio.Transport, transport)
        made.set_write_buffer_limits(HIGH_WATER)
        address = made.get_extra_info("peername")
        self.peer = f"{address[0]}:{address[1]}" if address else "?"
        sock = made.get_extra_info("socket")
        if sock is not None:
            sock.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
        proxy.connections.add(self)
        if len(proxy.connections) > proxy.limits.connections + proxy.limits.pending_handshakes:
            self._refuse(handshake.BadRequest(503, "too many connections; close some"))
            return
        self._timer = proxy.loop.call_later(proxy.limits.handshake_seconds, self._handshake_timed_out)

    def data_received(self, data: bytes) -> None:
        if self._upstream is not None and self._opening is None:
            self._upstream.write(data)
            return
        self._buffer += data
        if self._opening is not None or self._gone:
            return
        place = self._buffer.find(handshake.HEAD_END)
        if place < 0:
            if len(self._buffer) > handshake.MAX_HEAD_BYTES:
                self._refuse(handshake.BadRequest(431, "the request's head is too long"))
            return
        head = bytes(self._buffer[: place + 4])
        del self._buffer[: place + 4]
        try:
            request = handshake.parse_request(head)
            protocol = self._proxy.check(request)
            most = self._proxy.limits.connections
            if sum(other.session is not None for other in self._proxy.connections) >= most:
                raise handshake.BadRequest(503, f"{most} clients are connected: no more")
        except handshake.BadRequest as problem:
            self._refuse(problem)
            return
        self.reading(False)
        self._opening = self._proxy.loop.create_task(self._open(request, protocol))

    def connection_lost(self, error: Exception | None) -> None:
        self._gone = True
        self._stop_timer()
        self._proxy.connections.discard(self)
        if self._opening is not None:
            self._opening.cancel()
        if self._upstream is not None:
            self._upstream.end()
        session, self.session = self.session, None
        if session is not None:
            self._in_pool(session.close)

    def _in_pool(self, function: Callable[[], object]) -> None:
        try:
            self._proxy.pool.submit(function)
        except RuntimeError:  # the proxy is closed, and whoever closed it ends the sessions
            pass

    def hang_up(self) -> None:
        """Cut the connection now."""
        if self._transport is not None:
            self._transport.abort()

    def finish(self) -> None:
        """Send what is waiting (a close frame, for example), then close; cut a client that is too slow."""
        if self._transport is not None:
            self._transport.close()
            self._proxy.loop.call_later(self._proxy.limits.close_seconds, self.hang_up)

    def _handshake_timed_out(self) -> None:
        self._refuse(handshake.BadRequest(400, "the request did not come in time"))

    def _refuse(self, problem: handshake.BadRequest) -> None:
        self._proxy.refused += 1
        _log.info("! foxglove: %s may not connect: %s", self.peer, problem.text)
        self._gone = True
        self._stop_timer()
        if self._transport is not None:
            self._transport.write(handshake.error_response(problem))
            self._transport.close()
            self._timer = self._proxy.loop.call_later(self._proxy.limits.close_seconds, self.hang_up)

    def _stop_timer(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    # -- letting a client in --------------------------------------------------------------------------------

    async def _open(self, request: handshake.Request, protocol: str) -> None:
        proxy = self._proxy
        try:
            session, upstream = await self._connect_upstream(request, protocol)
        except handshake.BadRequest as problem:
            self._opening = None
            self._refuse(problem)
            return
        except asyncio.CancelledError:
            raise
        except Exception as problem:
            _log.warning("! foxglove: %s could not be served: %s", self.peer, problem)
            self._opening = None
            self._refuse(handshake.BadRequest(503, "the server cannot serve another client now"))
            return
        self._opening = None
        self._stop_timer()
        proxy.accepted += 1
        self._in_pool(session.client_connected)
        _log.info("= foxglove: %s has connected", self.peer)
        if self._buffer:
            upstream.write(bytes(self._buffer))
            self._buffer.clear()
        self.reading(True)

    async def _connect_upstream(
        self, request: handshake.Request, protocol: str
    ) -> tuple[ProxiedSession, UpstreamConnection]:
        """Make the session, repeat the handshake at its SDK server, and give the client the answer."""
        proxy = self._proxy
        making = proxy.loop.run_in_executor(
            proxy.pool, proxy.make_session, self.peer, lambda: proxy.call(self.hang_up)
        )
        try:
            session = await asyncio.shield(making)
        except asyncio.CancelledError:
            making.add_done_callback(self._discard)
            raise
        self.session = session
        _, upstream = await proxy.loop.create_connection(
            lambda: UpstreamConnection(proxy.loop, self), LOOPBACK, session.port
        )
        self._upstream = upstream
        upstream.write(handshake.upstream_request(request, session.port))
        answer, rest = await upstream.answer
        response = handshake.client_response(answer, protocol) + rest
        upstream.write(session.introduction)
        await proxy.loop.run_in_executor(proxy.pool, session.upstream_connected, upstream.port)
        assert self._transport is not None
        self._transport.write(response)
        upstream.reading(True)
        return session, upstream

    def _discard(self, making: Any) -> None:
        """Close a session whose client hung up while it was being made."""
        if not making.cancelled() and making.exception() is None:
            self._in_pool(making.result().close)

    # -- passing bytes on -----------------------------------------------------------------------------------

    def write(self, data: bytes) -> None:
        """Send bytes to the client."""
        if self._transport is not None:
            self._transport.write(data)

    def reading(self, wanted: bool) -> None:
        """Go on reading from the client, or pause."""
        if self._transport is None or self._transport.is_closing():
            return
        if wanted:
            self._transport.resume_reading()
        else:
            self._transport.pause_reading()

    def pause_writing(self) -> None:
        self.paused = True
        if self._upstream is not None:
            self._upstream.reading(False)
        if self.session is not None:
            self.session.pause_sending()
        self._watch_progress()

    def resume_writing(self) -> None:
        self.paused = False
        self._stop_timer()
        if self._upstream is not None:
            self._upstream.reading(True)
        if self.session is not None:
            self.session.resume_sending()

    def _watch_progress(self) -> None:
        """Check later whether the client has read anything at all."""
        assert self._transport is not None
        self._stop_timer()
        self._unread = self._transport.get_write_buffer_size()
        self._timer = self._proxy.loop.call_later(self._proxy.limits.silence_seconds, self._check_progress)

    def _check_progress(self) -> None:
        assert self._transport is not None
        if self._transport.get_write_buffer_size() >= self._unread:
            _log.warning(
                "! foxglove: %s has read nothing for %g s and is cut off",
                self.peer,
                self._proxy.limits.silence_seconds,
            )
            self._proxy.stalled += 1
            self.hang_up()
        else:
            self._watch_progress()
