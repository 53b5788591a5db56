"""The door: who connects is judged here, and then led to a server of the SDK that is there for him alone.

The SDK's server asks nobody who he is. It therefore listens where nobody is told of it, and this listens in
its place: it reads the request that opens the WebSocket (`head`), answers "no" itself, or makes a session
with its own SDK server, tells that who it is (`Guest.introduction`), and passes bytes on in both directions,
unread. As all bytes of a client go through here, here is known when he does not read: his session then keeps
the newest message of each topic instead of handing more to the SDK.

One asyncio loop in one thread for all clients; making and ending sessions, which may wait for a robot, is
done by a few other threads.
"""

from __future__ import annotations

import asyncio
import socket
import ssl
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any, Protocol, cast

from rosproto.errors import RosTimeout
from rosproto.gateway.foxglove import handshake as head
from rosproto.gateway.limits import GatewayLimits
from rosproto.logs import get_logger
from rosproto.transport.os_errors import system_errors

__all__ = ["Door", "Guest"]

_log = get_logger("rosproto.gateway")

INNER = "127.0.0.1"
HIGH_WATER = 1 << 20  # bytes that wait here for one client before his session is told
WORKERS = 8
START_SECONDS = 5.0
FAREWELL_SECONDS = 0.2


class Guest(Protocol):
    """What the door makes of a client that may come in: a session.

    Attributes:
        port: Where its SDK server listens.
        introduction: Bytes that are sent there before those of the client, as only the door can.
    """

    port: int
    introduction: bytes

    def admit(self, port: int) -> None:
        """The door is connected with its SDK server, from this port; called in a thread that may wait.

        Raises:
            Exception: The client cannot be served.
        """

    def arrived(self) -> None:
        """It is connected with its SDK server; called in a thread that may wait."""

    def clogged(self) -> None:
        """The client does not read as fast as it is sent; called in the door's thread, must not block."""

    def drained(self) -> None:
        """It has read what waited; likewise."""

    def close(self) -> None:
        """It is gone. Called once, in a thread that may wait."""


MakeGuest = Callable[[str, Callable[[], None]], Guest]
"""`make(peer, hang_up)`: in a thread that may wait; `hang_up` ends the connection, from any thread."""


class Door:
    """Listens, judges, passes on.

    Args:
        host, port: Where to listen; 0 is a free port.
        tls: For wss.
        judge: Says under which name a request's client speaks the protocol, or raises `BadRequest`.
        make: Makes the session of a client.
        limits: Bounds.
        prepare: Called with this before anybody can come.

    Raises:
        ConnectionLost: It cannot listen there.
    """

    def __init__(
        self,
        host: str,
        port: int,
        *,
        tls: ssl.SSLContext | None,
        judge: Callable[[head.Request], str],
        make: MakeGuest,
        limits: GatewayLimits,
        prepare: Callable[[Door], object],
    ) -> None:
        self.host, self.port = host, port
        self.limits = limits
        self.judge = judge
        self.make = make
        self.tls = tls
        self.accepted = self.refused = self.stalled = 0
        self.visitors: set[Visitor] = set()
        self.pool = ThreadPoolExecutor(WORKERS, "rosproto:foxglove work")
        self.loop = asyncio.new_event_loop()
        self._server: asyncio.Server | None = None
        self._problem: BaseException | None = None
        self._ready = threading.Event()
        self._closing = False
        prepare(self)
        self._thread = threading.Thread(target=self._run, name="rosproto:foxglove door", daemon=True)
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
            lambda: Visitor(self),
            self.host,
            self.port,
            ssl=self.tls,
            backlog=128,
            ssl_handshake_timeout=None if self.tls is None else self.limits.handshake_seconds,
        )

    def _unexpected(self, loop: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:
        error = context.get("exception")
        if not isinstance(error, (OSError, ssl.SSLError)):  # a peer that went away is nothing unexpected
            _log.error("! foxglove: %s", context.get("message"), exc_info=error)

    def call(self, function: Callable[..., object], *arguments: object) -> None:
        """Have it called in the door's thread; nothing when that has ended."""
        try:
            self.loop.call_soon_threadsafe(function, *arguments)
        except RuntimeError:
            pass  # the loop is closed: nobody is left to be told

    def close(self, timeout: float) -> None:
        """End every connection and the thread, within some seconds."""
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
        # The SDK has said goodbye to them; what is still there after a moment is cut off.
        self.loop.call_later(FAREWELL_SECONDS if self.visitors else 0.0, self._cut_off)

    def _cut_off(self) -> None:
        for visitor in tuple(self.visitors):
            visitor.hang_up()
        self.loop.call_later(0.02, self.loop.stop)


class Visitor(asyncio.Protocol):
    """One connection from outside; first its request is read, then bytes go to its `_Inside` and back."""

    def __init__(self, door: Door) -> None:
        self.door = door
        self.peer = "?"
        self.guest: Guest | None = None
        self.transport: asyncio.Transport | None = None
        self.inside: _Inside | None = None
        self._buffer = bytearray()
        self._opening: asyncio.Task[None] | None = None
        self._timer: asyncio.TimerHandle | None = None
        self._left = 0  # bytes that waited when the client was looked at last
        self.clogged = False
        self.gone = False

    # -- the connection -------------------------------------------------------------------------------------

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        door = self.door
        self.transport = made = cast(asyncio.Transport, transport)
        made.set_write_buffer_limits(HIGH_WATER)
        address = made.get_extra_info("peername")
        self.peer = f"{address[0]}:{address[1]}" if address else "?"
        sock = made.get_extra_info("socket")
        if sock is not None:
            sock.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
        door.visitors.add(self)
        if len(door.visitors) > door.limits.connections + door.limits.pending_handshakes:
            self._refuse(head.BadRequest(503, "too many connections; close some"))
            return
        self._timer = door.loop.call_later(door.limits.handshake_seconds, self._too_slow)

    def data_received(self, data: bytes) -> None:
        if self.inside is not None and self._opening is None:
            self.inside.write(data)
            return
        self._buffer += data
        if self._opening is not None or self.gone:
            return
        place = self._buffer.find(head.END)
        if place < 0:
            if len(self._buffer) > head.MOST_BYTES:
                self._refuse(head.BadRequest(431, "the request's head is too long"))
            return
        first = bytes(self._buffer[: place + 4])
        del self._buffer[: place + 4]
        try:
            request = head.parsed(first)
            offered = self.door.judge(request)
            if sum(other.guest is not None for other in self.door.visitors) >= self.door.limits.connections:
                raise head.BadRequest(503, f"{self.door.limits.connections} clients are connected: no more")
        except head.BadRequest as problem:
            self._refuse(problem)
            return
        self.reading(False)
        self._opening = self.door.loop.create_task(self._open(request, offered))

    def connection_lost(self, error: Exception | None) -> None:
        self.gone = True
        self._stop_timer()
        self.door.visitors.discard(self)
        if self._opening is not None:
            self._opening.cancel()
        if self.inside is not None:
            self.inside.end()
        guest, self.guest = self.guest, None
        if guest is not None:
            self._in_pool(guest.close)

    def _in_pool(self, function: Callable[[], object]) -> None:
        try:
            self.door.pool.submit(function)
        except RuntimeError:  # the door is closed, and whoever closed it ends the sessions
            pass

    def hang_up(self) -> None:
        """End it now."""
        if self.transport is not None:
            self.transport.abort()

    def _too_slow(self) -> None:
        self._refuse(head.BadRequest(400, "the request did not come in time"))

    def _refuse(self, problem: head.BadRequest) -> None:
        self.door.refused += 1
        _log.info("! foxglove: %s may not connect: %s", self.peer, problem.text)
        self.gone = True
        self._stop_timer()
        if self.transport is not None:
            self.transport.write(head.answer(problem))
            self.transport.close()
            self._timer = self.door.loop.call_later(self.door.limits.close_seconds, self.hang_up)

    def _stop_timer(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    # -- coming in ------------------------------------------------------------------------------------------

    async def _open(self, request: head.Request, offered: str) -> None:
        door = self.door
        try:
            making = door.loop.run_in_executor(
                door.pool, door.make, self.peer, lambda: door.call(self.hang_up)
            )
            try:
                guest = await asyncio.shield(making)
            except asyncio.CancelledError:
                making.add_done_callback(self._not_wanted)
                raise
            self.guest = guest
            _, inside = await door.loop.create_connection(lambda: _Inside(self), INNER, guest.port)
            self.inside = inside
            inside.write(head.forwarded(request, guest.port))
            answer, rest = await inside.answer
            first = head.accepted(answer, offered) + rest
            inside.write(guest.introduction)
            await door.loop.run_in_executor(door.pool, guest.admit, inside.port)
            assert self.transport is not None
            self.transport.write(first)
            inside.reading(True)
        except head.BadRequest as problem:
            self._opening = None
            self._refuse(problem)
            return
        except asyncio.CancelledError:
            raise
        except Exception as problem:
            _log.warning("! foxglove: %s could not be served: %s", self.peer, problem)
            self._opening = None
            self._refuse(head.BadRequest(503, "the server cannot serve another client now"))
            return
        self._opening = None
        self._stop_timer()
        door.accepted += 1
        self._in_pool(guest.arrived)
        _log.info("= foxglove: %s has come", self.peer)
        if self._buffer:
            inside.write(bytes(self._buffer))
            self._buffer.clear()
        self.reading(True)

    def _not_wanted(self, making: Any) -> None:
        """Made for a client that has gone meanwhile."""
        if not making.cancelled() and making.exception() is None:
            self._in_pool(making.result().close)

    # -- passing on -----------------------------------------------------------------------------------------

    def write(self, data: bytes) -> None:
        """From the SDK to the client."""
        if self.transport is not None:
            self.transport.write(data)

    def reading(self, wanted: bool) -> None:
        """Take what the client sends, or let it wait."""
        if self.transport is None or self.transport.is_closing():
            return
        if wanted:
            self.transport.resume_reading()
        else:
            self.transport.pause_reading()

    def pause_writing(self) -> None:
        self.clogged = True
        if self.inside is not None:
            self.inside.reading(False)
        if self.guest is not None:
            self.guest.clogged()
        self._look()

    def resume_writing(self) -> None:
        self.clogged = False
        self._stop_timer()
        if self.inside is not None:
            self.inside.reading(True)
        if self.guest is not None:
            self.guest.drained()

    def _look(self) -> None:
        """A client that takes nothing at all for long has gone, or may as well go."""
        assert self.transport is not None
        self._stop_timer()
        self._left = self.transport.get_write_buffer_size()
        self._timer = self.door.loop.call_later(self.door.limits.silence_seconds, self._look_again)

    def _look_again(self) -> None:
        assert self.transport is not None
        if self.transport.get_write_buffer_size() >= self._left:
            _log.warning(
                "! foxglove: %s has read nothing for %g s and is cut off",
                self.peer,
                self.door.limits.silence_seconds,
            )
            self.door.stalled += 1
            self.hang_up()
        else:
            self._look()


class _Inside(asyncio.Protocol):
    """Our connection to the SDK's server of one client."""

    def __init__(self, visitor: Visitor) -> None:
        self._visitor = visitor
        self._buffer = bytearray()
        self._transport: asyncio.Transport | None = None
        self.answer: asyncio.Future[tuple[bytes, bytes]] = visitor.door.loop.create_future()

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self._transport = cast(asyncio.Transport, transport)

    def data_received(self, data: bytes) -> None:
        if self.answer.done():
            self._visitor.write(data)
            return
        self._buffer += data
        place = self._buffer.find(head.END)
        if place >= 0:
            self.reading(False)  # what comes after it waits until the visitor has its answer
            self.answer.set_result((bytes(self._buffer[: place + 4]), bytes(self._buffer[place + 4 :])))
            self._buffer.clear()

    def connection_lost(self, error: Exception | None) -> None:
        if not self.answer.done():
            self.answer.set_exception(ConnectionResetError("the SDK's server hung up"))
            self.answer.exception()  # somebody may have stopped waiting for it
        if self._visitor.transport is not None:
            self._visitor.transport.close()  # what waits for the client (a close frame) still goes out
            self._visitor.door.loop.call_later(self._visitor.door.limits.close_seconds, self._visitor.hang_up)

    @property
    def port(self) -> int:
        """Ours of this connection."""
        assert self._transport is not None
        return int(self._transport.get_extra_info("sockname")[1])

    def write(self, data: bytes) -> None:
        if self._transport is not None:
            self._transport.write(data)

    def pause_writing(self) -> None:
        self._visitor.reading(False)

    def resume_writing(self) -> None:
        self._visitor.reading(True)

    def reading(self, wanted: bool) -> None:
        if self._transport is None or self._transport.is_closing():
            return
        if wanted:
            self._transport.resume_reading()
        else:
            self._transport.pause_reading()

    def end(self) -> None:
        if self._transport is not None:
            self._transport.abort()
