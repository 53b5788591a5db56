"""`HttpRequests`: requests by POST on the port of a WebSocket server.

The first four bytes of a connection tell which of the two it is. Admission, limits, log and close are the
server's for both. A connection for POSTs keeps its slot of the listener, and a new connection may replace it
while nothing of it is answered. Of those that are answered at the same time half the slots are kept.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable
from http import HTTPStatus
from typing import TYPE_CHECKING, Any, Protocol

from rosproto.admission import AdmissionRefusal
from rosproto.aio.read_budget import BudgetedProtocol, ReadBudget
from rosproto.errors import RemoteProtocolError, TooLarge
from rosproto.protocol.http import CONTINUE, ContinueWanted, HttpServerConnection, Request, error_status
from rosproto.protocol.wire_limits import Limits
from rosproto.transport.listener import key_of

if TYPE_CHECKING:
    from rosproto.gateway.websocket_server import WebSocketServer

REQUEST_SECONDS = 10.0  # from the first byte of a request to its last
LINGER_SECONDS = 1.0
"""For which a refused client is still read: a close with unread bytes would reset the connection, and the
answer would be lost."""
_GET = b"GET "


class PostHandler(Protocol):
    """Answers the POSTs to a server; its texts are JSON."""

    async def answer(self, path: str, data: bytes, address: str) -> tuple[HTTPStatus, str]:
        """The answer to a client at this IP address; called in the server's loop."""

    def refused(self, why: str) -> str:
        """The answer to a request that does not reach `answer`."""


class HttpRequests(asyncio.Protocol):
    """One connection: its requests, each read when the answer to the one before was taken. `websocket` makes
    the protocol that takes over if it is one.

    Attributes:
        budgeted: What the transport calls.
        remote_address: The client's.
    """

    def __init__(
        self,
        server: WebSocketServer,
        handler: PostHandler,
        budget: ReadBudget,
        websocket: Callable[[], asyncio.Protocol],
    ) -> None:
        self._server, self._handler, self._websocket = server, handler, websocket
        self._http = HttpServerConnection(Limits(xml_body_bytes=server.limits.message_bytes))
        self._first = b""
        self._is_post = self._is_over = False
        self._taken = asyncio.Event()
        self._taken.set()
        self._timer: asyncio.TimerHandle | None = None
        self.budgeted = BudgetedProtocol(budget, self)

    def connection_made(self, transport: Any) -> None:
        """See asyncio."""
        self._transport = transport
        self.remote_address = transport.get_extra_info("peername")
        self._wait(self._server.limits.handshake_seconds, transport.abort)

    def connection_lost(self, error: Exception | None) -> None:
        """See asyncio."""
        self._wait()
        self._server.disconnected(self, error)
        self._http = HttpServerConnection(Limits())  # frees what was sent now, not with the cycle of objects
        self._taken.set()

    def pause_writing(self) -> None:
        """See asyncio."""
        self._taken.clear()
        self._server.write_paused(self)

    def resume_writing(self) -> None:
        """See asyncio."""
        self._server.write_resumed(self)
        self._taken.set()

    def data_received(self, data: bytes) -> None:
        """See asyncio."""
        if not self._is_post:
            data = self._first = self._first + data
            if data.startswith(_GET):
                self._wait()
                self.budgeted.protocol = chosen = self._websocket()
                chosen.connection_made(self._transport)
                chosen.data_received(data)
                return
            if _GET.startswith(data):
                return
            self._is_post = True
            self._server.connected(self, self._transport)
        if not self._is_over:
            if not self._http.mid_message:
                self._wait(REQUEST_SECONDS, self._too_slow)
            self._http.receive(data)
            self._read()

    def _wait(self, seconds: float = 0.0, late: Callable[[], object] | None = None) -> None:
        """Call `late` in so many seconds, and no longer what was to be called before."""
        if self._timer is not None:
            self._timer.cancel()
        self._timer = late and asyncio.get_running_loop().call_later(seconds, late)

    def _read(self) -> None:
        """Begin to answer the next request, if it is complete."""
        try:
            event = self._http.next_event()
        except RemoteProtocolError as error:
            why = f"it may have {error.limit} bytes" if isinstance(error, TooLarge) else str(error)
            self._refuse(HTTPStatus(error_status(error)), "request", f"the request is refused: {why}")
            return
        if isinstance(event, ContinueWanted):
            self._transport.write(CONTINUE)
        elif isinstance(event, Request):
            self._wait()
            self._transport.pause_reading()
            self._server.spawn(self._answer(event))

    async def _answer(self, request: Request) -> None:
        server, key, now = self._server, key_of(self.remote_address), time.monotonic()
        server.slots.request_begins(key, now, authorized=False)  # its end is not a missing handshake
        refusal = server.admission.check_post(request, key[0], now, secure=server.secure)
        if refusal is not None:
            self._refuse(refusal.status, refusal.reason, refusal.text)
            return
        path = request.target.partition("?")[0]
        kept = server.answering < server.limits.pending_handshakes // 2  # the others leave room for new ones
        server.answering += kept
        server.slots.request_begins(key, now, authorized=kept)
        try:
            status, text = await self._handler.answer(path, request.body, key[0])
        except Exception as error:
            server.peer_log.error(key[0], "! %s of %s", path, key[0], exc_info=error)
            self._refuse(HTTPStatus.INTERNAL_SERVER_ERROR, "error", "internal error; see the server's log")
            return
        finally:
            server.slots.request_ends(key, time.monotonic(), authorized=kept)
            server.answering -= kept
        self._write(status, text, request.keep_alive)
        async with server.turn:  # the others are served before the next request of this client
            await asyncio.sleep(0)
        await self._taken.wait()
        if request.keep_alive and not self._transport.is_closing():
            idle = server.limits.silence_seconds, self._transport.abort
            self._wait(*((REQUEST_SECONDS, self._too_slow) if self._http.mid_message else idle))
            self._transport.resume_reading()
            self._read()

    def _too_slow(self) -> None:
        why = f"the request is refused: it is not complete after {REQUEST_SECONDS:g} s"
        self._refuse(HTTPStatus.REQUEST_TIMEOUT, "request", why)

    def _refuse(self, status: HTTPStatus, reason: str, why: str) -> None:
        self._server.refuse(self, AdmissionRefusal(status, reason, why))
        self._write(status, self._handler.refused(why), keep_alive=False)

    def _write(self, status: HTTPStatus, text: str, keep_alive: bool) -> None:
        if self._transport.is_closing():
            return
        allow = "POST" if status == HTTPStatus.METHOD_NOT_ALLOWED else ""
        self._transport.write(
            self._http.encode_response(
                status, text.encode(), keep_alive=keep_alive, allow=allow, kind="application/json"
            )
        )
        if not keep_alive:
            self._is_over = True
            self._wait(LINGER_SECONDS, self._transport.abort)
            if self._transport.can_write_eof():
                self._transport.write_eof()
            self._transport.resume_reading()
