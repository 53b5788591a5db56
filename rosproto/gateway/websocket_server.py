"""`WebSocketServer`: the server below the gateways, with `websockets` on an asyncio loop in its own thread.

Connections are bounded in number and time before they become clients, and their HTTP request is checked
(`Listener`, `handshake.py`). A client's session gets its messages one after the other, and
`outbox_writer.py` sends what waits in its outbox. Requests by POST: `http_requests.py`.
"""

from __future__ import annotations

import asyncio
import logging
import socket
import ssl
import threading
import time
from collections import Counter
from collections.abc import Callable, Coroutine
from concurrent.futures import Future, wait
from contextlib import suppress
from functools import partial
from http import HTTPStatus
from types import ModuleType
from typing import TYPE_CHECKING, Any

from rosproto.admission import AdmissionRefusal
from rosproto.aio.pool import Pool, notify
from rosproto.aio.read_budget import BudgetedProtocol, ReadBudget
from rosproto.errors import LocalProtocolError, RosTimeout
from rosproto.extras import optional_module
from rosproto.gateway.client_channel import ClientChannel, ClientSession
from rosproto.gateway.client_limits import GatewayLimits
from rosproto.gateway.handshake import HandshakeRules
from rosproto.gateway.http_requests import HttpRequests, PostHandler
from rosproto.gateway.outbox_writer import OutboxWriter, closed_error
from rosproto.logs import PeerLog
from rosproto.transport.connection_slots import ConnectionSlots
from rosproto.transport.listener import AT_ONCE, Listener, key_of
from rosproto.transport.uri import make_uri

if TYPE_CHECKING:
    from typing import TypeAlias

    from websockets.asyncio.server import ServerConnection
    from websockets.http11 import Request, Response

    Connection: TypeAlias = ServerConnection | HttpRequests

WRITE_BUFFER = 256 << 10  # bytes given to the system's socket ahead of what it took
FRAGMENTS = 4096
"""Of one message. Empty ones cost memory too, which no limit of bytes sees; `recv` of `websockets` counts
them only from 17.4 on, which needs Python 3.11."""
READ_AHEAD_MESSAGES = 0  # messages of a client read ahead of its session
TURN_SECONDS = 0.001  # seconds of the loop's time after which a client waits for its turn
SHARE = 0.1  # of the loop's time; a client that takes less never waits
START_SECONDS = 10.0
_TOO_BIG, _TRY_AGAIN = 1009, 1013


def need_websockets(name: str) -> ModuleType:
    """Import the library.

    Raises:
        LocalProtocolError: It is not installed or too old; the text names the extra.
    """
    extra = {"foxglove": "foxglove", "robot-api": "api"}.get(name, "bridge")
    missing = f'a {name} server needs the package websockets (14 or newer): pip install ".[{extra}]"'
    return optional_module("websockets.asyncio.server", LocalProtocolError(missing))


class WebSocketServer:
    """Serves until `close`.

    Args:
        open_session: Called in the loop for each new client.
        admission: Its address to listen on, and who may connect.
        port: Port, 0 for a free one.
        limits: Bounds.
        tls: Certificate and key; None for none.
        name: For threads and errors.
        posts: Answers requests by POST; None refuses them.

    Raises:
        LocalProtocolError: `websockets` is missing.
        ConnectionLost: The address cannot be listened on.

    Attributes:
        host, port: Where it listens.
        admission: As given.
        refused: Refused connections by reason.
        accepted: Clients so far.
        stalled: Clients disconnected so far because they read nothing.
        slots: Connections that are not clients.
        answering: Connections for POSTs that no new one replaces, because a request of them is answered.
        turn: Of a client that took more than its share of the loop's time.
    """

    def __init__(
        self,
        open_session: Callable[[ClientChannel], ClientSession],
        admission: HandshakeRules,
        *,
        port: int = 0,
        limits: GatewayLimits | None = None,
        tls: ssl.SSLContext | None = None,
        name: str = "gateway",
        posts: PostHandler | None = None,
    ) -> None:
        self._websockets = need_websockets(name)
        self.host = admission.bound
        self.limits = limits or GatewayLimits()
        self.secure = tls is not None
        self.refused: Counter[str] = Counter()
        self.accepted = self.stalled = self.answering = 0
        self.pool = Pool(self.limits.threads, name=f"rosproto:{name}")
        self.peer_log = PeerLog("rosproto.gateway")
        self._open_session = open_session
        self._tls = tls
        self.admission = admission
        self._name = name
        self._posts = posts
        self._lock = threading.Lock()
        self._channels: dict[Connection, ClientChannel] = {}  # by connection; of WebSockets
        self._tasks: set[asyncio.Task[None]] = set()
        self._transports: dict[Connection, asyncio.Transport] = {}
        self._unread: dict[Connection, asyncio.TimerHandle] = {}
        self._leaving: set[Future[None]] = set()
        self._closing = False
        self.slots = ConnectionSlots(self.limits.pending_handshakes)
        self._listener = Listener(self.host, port, self.slots, self.refused)
        self.port: int = self._listener.getsockname()[1]
        self._started: Future[None] = Future()
        self._loop = asyncio.SelectorEventLoop()  # calls `Listener.accept`; Windows' proactor loop does not
        self._outbox_writer = OutboxWriter(self._loop, self.pool, self.peer_log, name)
        self._stop = asyncio.Event()
        self.turn = asyncio.Lock()
        self._served = 0  # messages so far
        self._thread = threading.Thread(target=self._run, name=f"rosproto:{name}", daemon=True)
        self._thread.start()
        try:
            self._started.result(START_SECONDS)
        except BaseException:
            self.close(1.0)
            raise

    @property
    def url(self) -> str:
        """Where clients connect."""
        host = {"": "127.0.0.1", "0.0.0.0": "127.0.0.1", "::": "::1"}.get(self.host, self.host)
        return make_uri(host, self.port, "wss" if self.secure else "ws").rstrip("/")

    @property
    def channels(self) -> tuple[ClientChannel, ...]:
        """The connected clients."""
        with self._lock:
            return tuple(self._channels.values())

    # -- the loop -------------------------------------------------------------------------------------------

    def _run(self) -> None:
        asyncio.set_event_loop(self._loop)
        try:
            self._loop.run_until_complete(self._main())
        except BaseException as error:
            if not self._started.done():
                self._started.set_exception(error)
            else:
                raise
        finally:
            self._listener.close()
            self._loop.run_until_complete(self._loop.shutdown_asyncgens())
            self._loop.close()

    async def _main(self) -> None:
        limits = self.limits
        budget = ReadBudget(self._log_flood)
        connection_class = connection_type(
            self._websockets.ServerConnection, self, WRITE_BUFFER + limits.answer_bytes
        )
        # Its log about refused connections is not bounded: it is off.
        quiet = logging.Logger("websockets", logging.CRITICAL + 1)
        server = await self._websockets.serve(
            self._serve,
            sock=self._listener,
            backlog=AT_ONCE,
            ssl=self._tls,
            **({"ssl_handshake_timeout": limits.handshake_seconds} if self._tls is not None else {}),
            process_request=self._check_request,
            subprotocols=list(self.admission.subprotocols) or None,
            create_connection=lambda *given, **options: self._new_connection(
                budget, partial(connection_class, *given, **options)
            ),
            compression=None,
            open_timeout=limits.handshake_seconds,
            ping_interval=limits.silence_seconds,
            ping_timeout=limits.silence_seconds,
            close_timeout=limits.close_seconds,
            max_size=limits.message_bytes,
            max_queue=READ_AHEAD_MESSAGES,
            write_limit=WRITE_BUFFER,
            server_header=None,
            logger=quiet,
        )
        self._started.set_result(None)
        await self._stop.wait()
        server.close()
        self.slots.drop_all()
        with suppress(asyncio.TimeoutError):  # the rest is aborted below
            await asyncio.wait_for(server.wait_closed(), limits.close_seconds + 0.5)
        for transport in list(self._transports.values()):
            transport.abort()
        tasks = [task for task in self._tasks if task is not asyncio.current_task()]
        if tasks:
            _, left = await asyncio.wait(tasks, timeout=1.0)
            for task in left:
                task.cancel()
            await asyncio.gather(*left, return_exceptions=True)

    # -- events of connections ------------------------------------------------------------------------------

    def _new_connection(
        self, budget: ReadBudget, websocket: Callable[[], asyncio.Protocol]
    ) -> BudgetedProtocol:
        if self._posts is None:
            return BudgetedProtocol(budget, websocket())
        return HttpRequests(self, self._posts, budget, websocket).budgeted

    def connected(self, connection: Connection, transport: asyncio.Transport) -> None:
        """A connection has its transport (with TLS, the one above TLS)."""
        self._transports[connection] = transport

    def disconnected(self, connection: Connection, error: Exception | None) -> None:
        """A connection has ended, with `error` if it broke."""
        self._transports.pop(connection, None)
        self.write_resumed(connection)
        channel = self._channels.get(connection)
        if channel is not None:
            channel.gone = True
            channel.lost = error is not None

    def _check_request(self, connection: ServerConnection, request: Request) -> Response | None:
        """The HTTP answer to a refused request; None for an accepted one."""
        now, key = time.monotonic(), key_of(connection.remote_address)
        header = request.headers.get_all
        refusal = self.admission.check(request.path, header, key[0], now, secure=self.secure)
        if refusal is None and len(self._channels) >= self.limits.connections:
            why = f"{self.limits.connections} clients are connected, which is the limit"
            refusal = AdmissionRefusal(HTTPStatus.SERVICE_UNAVAILABLE, "connections", why)
        if refusal is None:
            return None
        self.refuse(connection, refusal)
        return connection.respond(refusal.status, f"{refusal.text}\n")

    def refuse(self, connection: Connection, refusal: AdmissionRefusal) -> None:
        """Count and log a refused request."""
        self.slots.request_begins(key_of(connection.remote_address), time.monotonic(), authorized=False)
        self.refused[refusal.reason] += 1
        self.peer_log.warning(
            refusal.reason, "! %s: refused %s: %s", self._name, peer_of(connection), refusal.text
        )

    def spawn(self, work: Coroutine[Any, Any, None]) -> None:
        """Run something in the loop, which `close` ends."""
        task = asyncio.ensure_future(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    # -- clients --------------------------------------------------------------------------------------------

    async def _serve(self, connection: ServerConnection) -> None:
        task = asyncio.current_task()
        assert task is not None
        self.slots.release(key_of(connection.remote_address))  # `_channels` counts it from now on
        transport = self._transports.get(connection)
        if transport is None:
            return  # it ended during its handshake
        self._tasks.add(task)
        channel = ClientChannel(
            peer_of(connection),
            self.limits,
            self._outbox_writer.wake,
            lambda channel: notify(self._loop, self._close_channel, connection, channel),
            self._later,
            connection.subprotocol,
        )
        with self._lock:
            full = len(self._channels) >= self.limits.connections or self._closing
            if not full:
                self._channels[connection] = channel
        try:
            if full:  # several connected at once
                self.refused["connections"] += 1
                await connection.close(_TRY_AGAIN, "too many clients")
            else:
                self.accepted += 1
                await self._serve_client(connection, channel, transport)
        finally:
            self._tasks.discard(task)

    async def _serve_client(
        self, connection: ServerConnection, channel: ClientChannel, transport: asyncio.Transport
    ) -> None:
        self._outbox_writer.add(channel, connection, transport)
        session: ClientSession | None = None
        try:
            session = self._open_session(channel)
            await self._read(connection, channel, session)
        except closed_error() as end:  # however it ended
            if end.sent is not None and end.sent.code == _TOO_BIG:
                self._log_too_long(channel, self.limits.message_bytes)
        except Exception as error:
            self.peer_log.error(
                channel.peer, "! %s: %s is disconnected", self._name, channel.peer, exc_info=error
            )
            channel.close(1011, "an error of the gateway")
        finally:
            with self._lock:
                del self._channels[connection]
            channel.outbox.close()
            self._outbox_writer.remove(channel)
            if session is not None:
                self._end_session(session)

    async def _read(
        self, connection: ServerConnection, channel: ClientChannel, session: ClientSession
    ) -> None:
        """Pass a client's messages to its session.

        A client that takes more than its share of the loop's time waits for its turn. All other clients are
        served between two such turns.
        """
        spent, before = 0.0, time.monotonic()
        while True:
            data = await read_message(connection)
            if channel.lost:
                return
            if data is None:
                why = f"a message may have {FRAGMENTS} fragments"
                self.peer_log.warning(
                    "fragments", "! %s: %s is disconnected: %s", self._name, channel.peer, why
                )
                await self._close_connection(connection, _TOO_BIG, why)
                return
            max_bytes = session.max_message_bytes
            if len(data) > max_bytes:
                self._log_too_long(channel, max_bytes)
                await self._close_connection(
                    connection, _TOO_BIG, f"a message may have {max_bytes} bytes here"
                )
                return
            channel.received += 1
            self._served += 1
            mine, began = self._served, time.thread_time()
            await session.received(data)
            now = time.monotonic()
            spent = max(0.0, spent - SHARE * (now - before))
            if self._served == mine:  # else the session waited, and other clients used the time
                spent += time.thread_time() - began
            before = now
            if spent >= TURN_SECONDS:
                async with self.turn:
                    await asyncio.sleep(0)
                spent = 0.0
                self._look_for_reset(connection, channel)

    def _look_for_reset(self, connection: ServerConnection, channel: ClientChannel) -> None:
        """Abort a connection that was reset: the system would still deliver its earlier data."""
        transport = self._transports.get(connection)
        if transport is None or transport.is_closing():
            return
        try:
            error = transport.get_extra_info("socket").getsockopt(socket.SOL_SOCKET, socket.SO_ERROR)
        except OSError as problem:
            error = problem.errno
        if error:
            channel.gone = channel.lost = True
            transport.abort()

    def _log_too_long(self, channel: ClientChannel, max_bytes: int) -> None:
        self.peer_log.warning(
            "too long",
            "! %s: %s is disconnected: a message has more than %d bytes (--message-bytes, "
            "GatewayLimits.message_bytes; less where nothing may be written)",
            self._name,
            channel.peer,
            max_bytes,
        )

    def _log_flood(self, transport: asyncio.Transport) -> None:
        host, port, *_ = transport.get_extra_info("peername") or ("?", 0)
        self.peer_log.warning(
            "flood",
            "! %s: %s:%s is disconnected: it sends nothing but control frames",
            self._name,
            host,
            port,
        )

    def _end_session(self, session: ClientSession) -> None:
        done: Future[None] = Future()
        self._leaving.add(done)

        def leave() -> None:
            try:
                session.ended()
            except Exception as error:
                self.peer_log.error("ended", "! %s: a session failed", self._name, exc_info=error)
            finally:
                self._leaving.discard(done)
                done.set_result(None)

        self.pool.spawn(leave)

    # -- clients that read nothing --------------------------------------------------------------------------

    def write_paused(self, connection: Connection) -> None:
        """The write buffer is full: check for progress later, as the library's pings wait behind it."""
        transport = self._transports.get(connection)
        if transport is not None:
            unread = transport.get_write_buffer_size()
            self._unread[connection] = self._loop.call_later(
                self.limits.silence_seconds, self._look_for_progress, connection, transport, unread
            )

    def write_resumed(self, connection: Connection) -> None:
        """The client has caught up."""
        timer = self._unread.pop(connection, None)
        if timer is not None:
            timer.cancel()

    def _look_for_progress(self, connection: Connection, transport: asyncio.Transport, unread: int) -> None:
        if transport.get_write_buffer_size() < unread:
            self.write_paused(connection)
            return
        self.peer_log.warning(
            "stalled",
            "! %s: %s has read nothing for %g s and is disconnected",
            self._name,
            peer_of(connection),
            self.limits.silence_seconds,
        )
        self.stalled += 1
        transport.abort()

    # -- from any thread ------------------------------------------------------------------------------------

    def _later(self, seconds: float, function: Callable[[], object]) -> None:
        notify(self._loop, self._loop.call_later, seconds, function)

    def _close_channel(self, connection: ServerConnection, channel: ClientChannel) -> None:
        if connection not in self._channels or channel.ending is None:
            return
        self.spawn(self._close_connection(connection, *channel.ending))

    async def _close_connection(self, connection: ServerConnection, code: int, reason: str) -> None:
        """Close with the WebSocket handshake, or abort if the client does not answer."""
        with suppress(asyncio.TimeoutError, TimeoutError, closed_error()):
            await asyncio.wait_for(connection.close(code, reason), self.limits.close_seconds)
        transport = self._transports.get(connection)
        if transport is not None:
            transport.abort()

    # -- closing --------------------------------------------------------------------------------------------

    def close(self, timeout: float = 5.0) -> None:
        """End all connections, in bounded time. May be called again.

        Raises:
            RosTimeout: A session did not end in time.
        """
        with self._lock:
            self._closing = True
        notify(self._loop, self._stop.set)
        if threading.current_thread() is self._thread:
            return
        self._thread.join(timeout)
        _, left = wait(list(self._leaving), timeout)
        self.pool.close()
        if left or self._thread.is_alive():
            raise RosTimeout(
                f"{self._name}: {len(left)} sessions have not ended after {timeout:g} s",
                what=f"the end of {self._name}",
                seconds=timeout,
            )


# -- a connection of the library ---------------------------------------------------------------------------


async def read_message(connection: ServerConnection) -> str | bytes | None:
    """The next message of a client; None if it has more than `FRAGMENTS` fragments."""
    fragments: list[Any] = []  # texts or bytes
    async for fragment in connection.recv_streaming():
        if len(fragments) == FRAGMENTS:
            return None
        fragments.append(fragment)
    whole: str | bytes = fragments[0] if len(fragments) == 1 else type(fragments[0])().join(fragments)
    return whole


def connection_type(
    base: type[ServerConnection], server: WebSocketServer, max_unsent: int
) -> type[ServerConnection]:
    """A subclass of the library's connection class that reports to our server.

    Args:
        base: `websockets.asyncio.server.ServerConnection`.
        server: Gets the events.
        max_unsent: Bytes that may wait in a connection's transport; beyond that it is aborted.
    """

    def connection_made(self: ServerConnection, transport: asyncio.Transport) -> None:
        bounded: Any = _Transport(transport, max_unsent)  # passes on all that it does not have itself
        base.connection_made(self, bounded)
        server.connected(self, bounded)

    def connection_lost(self: ServerConnection, error: Exception | None) -> None:
        server.disconnected(self, error)
        base.connection_lost(self, error)

    def pause_writing(self: ServerConnection) -> None:
        base.pause_writing(self)
        server.write_paused(self)

    def resume_writing(self: ServerConnection) -> None:
        base.resume_writing(self)
        server.write_resumed(self)

    own = connection_made, connection_lost, pause_writing, resume_writing
    return type("Connection", (base,), {each.__name__: each for each in own})


class _Transport:
    """A client's transport that drops what is written while it closes, and is aborted above `limit` bytes.

    Before `connection_lost` the library goes on writing, and asyncio would log each of 40,000 pongs.
    """

    def __init__(self, transport: asyncio.Transport, limit: int) -> None:
        self._transport, self._limit = transport, limit
        self.is_closing, self.get_write_buffer_size = transport.is_closing, transport.get_write_buffer_size

    def __getattr__(self, name: str) -> Any:
        return getattr(self._transport, name)

    def write(self, data: bytes) -> None:
        """Write; while the transport closes, drop the data."""
        if self.get_write_buffer_size() > self._limit:
            self._transport.abort()
        if not self.is_closing():
            self._transport.write(data)


def peer_of(connection: Connection) -> str:
    """ "10.0.0.7:51234"; "?" if it is unknown."""
    address = connection.remote_address
    return f"{address[0]}:{address[1]}" if address else "?"
