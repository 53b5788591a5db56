"""The XML-RPC server of masters and nodes (wiki.ros.org/ROS/Master_API, Slave_API).

A thread per connection, keep-alive. The time for each request is limited, and a broken or hostile request
ends its own connection only.
"""

from __future__ import annotations

import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rosproto.errors import LocalProtocolError, RemoteProtocolError, RosError
from rosproto.logs import get_logger
from rosproto.protocol import xmlrpc
from rosproto.protocol.http import (
    CONTINUE,
    ContinueWanted,
    Event,
    HttpServerConnection,
    Request,
    error_status,
)
from rosproto.protocol.wire_limits import Limits
from rosproto.transport.deadline import SYSTEM, Clock, Deadline
from rosproto.transport.tcp import write_steadily
from rosproto.transport.tcp_server import Allow, TcpServer
from rosproto.transport.uri import format_address, make_uri

log = get_logger("rosproto.transport")

_PATHS = ("/", "/RPC2")
_RECV_BYTES = 1 << 16
_MIN_BYTES_PER_SECOND = 16 << 10  # of a request that takes longer than handshake_seconds
_LARGE_BYTES = 256 << 10  # of a request or reply; larger ones are read and made one at a time
_MAX_REPLY_BYTES = 64 << 20  # of one reply; and of the large ones that are being sent, and the next one
_TAGS_BYTES = 30  # around a value in a reply, approximately
_LINGER_SECONDS = 1.0
_LINGER_BYTES = 1 << 20
_REPLY_SECONDS = 0.5  # for replies that are being written when the server closes
PARSE_ERROR, INTERNAL_ERROR, MULTICALL_ERROR = -32700, 1, -32600


class Peer(str):
    """The caller, as "host:port".

    Attributes:
        host: The caller's address.
        port: The caller's port.
        local_host: Our own address that the caller connected to.
    """

    __slots__ = ("host", "local_host", "port")
    host: str
    port: int
    local_host: str

    @classmethod
    def of(cls, sock: socket.socket, address: tuple[str, int]) -> Peer:
        """The peer of an accepted socket."""
        peer = cls(format_address(*address))
        peer.host, peer.port = address
        try:
            peer.local_host = str(sock.getsockname()[0]).removeprefix("::ffff:")
        except OSError:
            peer.local_host = ""
        return peer


Dispatch = Callable[[str, list[object], Peer], object]


class XmlRpcServer:
    """Answers XML-RPC calls with `dispatch(method, params, peer)`, called in the connection's thread.

    The result of `dispatch` is the reply; `xmlrpc.Fault` becomes a fault; any other exception is logged and
    becomes fault 1 with its text. `system.multicall` is handled here (rospy unregisters with it).

    Args:
        host: The only address to listen on.
        port: Port, 0 for a free one.
        dispatch: The method table.
        limits: Limits of sizes, times and connections.
        allow: Who may connect: addresses, or a function of the address; None for everybody.
        name: For thread names and log lines.
        advertise: Host in `uri` if it is not `host` (which may be 0.0.0.0).

    Attributes:
        host: As given.
        port: The actual port.
        uri: "http://host:port/".
        stats: Counters of the connections.
    """

    def __init__(
        self,
        host: str,
        port: int,
        dispatch: Dispatch,
        *,
        limits: Limits | None = None,
        allow: Allow = None,
        name: str = "xmlrpc",
        advertise: str | None = None,
        clock: Clock = SYSTEM,
    ) -> None:
        self._dispatch = dispatch
        self._limits = limits or Limits()
        self._clock = clock
        self._name = name
        self._large = threading.Lock()
        self._sending = 0  # bytes of large replies
        self._sent = threading.Condition()
        self._answering: set[int] = set()  # threads
        self._answered = threading.Condition()
        self._constructed = threading.Lock()
        with self._constructed:  # peers that wait for the port connect before the constructor has finished
            self._server = TcpServer(
                host, port, self._serve, limits=self._limits, allow=allow, name=name, clock=clock
            )
            self.stats = self._server.stats
            self.host = host
            self.port = self._server.port
            self.uri = make_uri(advertise or host, self.port)

    def __enter__(self) -> XmlRpcServer:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<XmlRpcServer {self._name} {self.uri}{' closed' if self._server.closed else ''}>"

    @property
    def connections(self) -> int:
        """Number of open connections."""
        return self._server.connections

    def close(self, timeout: float = 5.0) -> None:
        """Stop listening, drop all connections, wait for running calls up to `timeout` seconds.

        Replies that are being written get a moment to finish, because the call may be the one that requested
        this shutdown.
        """
        own = {threading.get_ident()}
        with self._answered:
            self._answered.wait_for(lambda: self._answering <= own, min(timeout, _REPLY_SECONDS))
        self._server.close(timeout)

    def _serve(self, sock: socket.socket, address: tuple[str, int]) -> None:
        with self._constructed:
            pass  # the constructor has finished
        _HttpConnection(self, sock, Peer.of(sock, address)).run()

    # The rest is called by _HttpConnection.

    @contextmanager
    def answering(self) -> Iterator[None]:
        """Context of a reply, from the call until it is written."""
        thread = threading.get_ident()
        with self._answered:
            self._answering.add(thread)
        try:
            yield
        finally:
            with self._answered:
                self._answering.discard(thread)
                self._answered.notify_all()

    def answer(self, body: bytes, peer: Peer) -> bytes:
        """The response document for a call document; never raises for an error of the peer or the handler.

        Call `sent` when it has been sent, or cannot be.

        A large call takes seconds of processor time. Several at a time would delay the small ones of others
        by all of that, because a thread waits for each running one whenever it continues; so they take turns.
        """
        if len(body) < _LARGE_BYTES:
            return self._answer(body, peer)
        if not self._large.acquire(timeout=self._limits.idle_seconds):
            return xmlrpc.encode_fault(INTERNAL_ERROR, "other large requests take too long; try again later")
        try:
            return self._answer(body, peer, has_turn=True)
        finally:
            self._large.release()

    def sent(self, reply: bytes) -> None:
        """A result of `answer` is no longer needed."""
        if len(reply) >= _LARGE_BYTES:
            with self._sent:
                self._sending -= len(reply)
                self._sent.notify_all()

    def _reply(self, method: str, result: object, has_turn: bool) -> bytes:
        """The document for a result; a large one is made alone, and when those being sent leave room."""
        size = _size_in_reply(result)
        if size > _MAX_REPLY_BYTES:
            raise LocalProtocolError(
                f"the result has more than {_MAX_REPLY_BYTES} bytes; ask for parts of it"
            )
        if size < _LARGE_BYTES or has_turn:
            return self._counted(xmlrpc.encode_response(result))
        deadline = Deadline(self._limits.idle_seconds, self._clock)
        while self._large.acquire(timeout=deadline.remaining() or 0.0):
            try:
                if self._sending < _MAX_REPLY_BYTES:
                    return self._counted(xmlrpc.encode_response(result))
            finally:
                self._large.release()
            with self._sent:
                if not self._sent.wait_for(
                    lambda: self._sending < _MAX_REPLY_BYTES, deadline.remaining() or 0.0
                ):
                    break
        raise xmlrpc.Fault(INTERNAL_ERROR, f"{method}: other large replies take too long; try again later")

    def _counted(self, reply: bytes) -> bytes:
        if len(reply) >= _LARGE_BYTES:
            with self._sent:
                self._sending += len(reply)
        return reply

    def _answer(self, body: bytes, peer: Peer, *, has_turn: bool = False) -> bytes:
        try:
            method, params = xmlrpc.decode_call(body, self._limits)
        except RemoteProtocolError as error:
            log.debug("! %s: call from %s: %s", self._name, peer, error)
            return xmlrpc.encode_fault(PARSE_ERROR, str(error))
        log.debug("< %s: %s from %s", self._name, method, peer)
        try:
            result = (
                self._multicall(params, peer)
                if method == "system.multicall"
                else self._call(method, params, peer)
            )
            return self._reply(method, result, has_turn)
        except xmlrpc.Fault as fault:
            return xmlrpc.encode_fault(fault.code, fault.text)
        except RosError as error:  # a result that XML-RPC cannot encode
            log.warning("! %s: %s: the result cannot be sent: %s", self._name, method, error)
            return xmlrpc.encode_fault(INTERNAL_ERROR, f"{method}: {error}")

    def _call(self, method: str, params: list[object], peer: Peer) -> object:
        try:
            return self._dispatch(method, params, peer)
        except xmlrpc.Fault:
            raise
        except Exception as error:
            log.exception("! %s: %s from %s failed", self._name, method, peer)
            raise xmlrpc.Fault(INTERNAL_ERROR, f"{method}: {type(error).__name__}: {error}") from error

    def _multicall(self, params: list[object], peer: Peer) -> list[object]:
        calls = params[0] if len(params) == 1 else None
        if not isinstance(calls, list):
            raise xmlrpc.Fault(MULTICALL_ERROR, "system.multicall: expected one array of calls")
        return [self._multicall_entry(call, peer) for call in calls]

    def _multicall_entry(self, call: object, peer: Peer) -> object:
        """One result in a list, or a fault's struct, as xmlrpc.client's MultiCall expects."""
        try:
            method = call.get("methodName") if isinstance(call, dict) else None
            params = call.get("params", []) if isinstance(call, dict) else None
            if not isinstance(method, str) or not isinstance(params, list) or method == "system.multicall":
                raise xmlrpc.Fault(
                    MULTICALL_ERROR, "system.multicall: expected {methodName, params}, not nested"
                )
            result = self._call(method, params, peer)
            xmlrpc.encode_response(result)  # one bad result must not spoil the others
            return [result]
        except xmlrpc.Fault as fault:
            return {"faultCode": fault.code, "faultString": fault.text}
        except RosError as error:
            return {"faultCode": INTERNAL_ERROR, "faultString": str(error)}


def _size_in_reply(value: object) -> int:
    """Approximate size of a value in a reply; of a larger one than allowed, only that it is."""
    total, todo = 0, [value]
    while todo and total <= _MAX_REPLY_BYTES:
        item = todo.pop()
        total += _TAGS_BYTES
        if isinstance(item, (str, bytes, bytearray)):
            total += len(item)
        elif isinstance(item, dict):
            total += sum(_TAGS_BYTES + len(str(name)) for name in item)
            todo += item.values()
        elif isinstance(item, (list, tuple)):
            todo += item
    return total


class _HttpConnection:
    """One connection: requests in, responses out, until either side closes."""

    def __init__(self, server: XmlRpcServer, sock: socket.socket, peer: Peer) -> None:
        self._server = server
        self._tcp = server._server
        self._limits = server._limits
        self._clock = server._clock
        self._sock = sock
        self._peer = peer
        self._http = HttpServerConnection(server._limits)

    def run(self) -> None:
        """Serve until the connection ends."""
        first = True
        while not self._tcp.closed:
            try:
                request = self._read_request(first)
            except RemoteProtocolError as error:
                self._refuse(error_status(error), error)
                return
            if request is None or not self._respond(request):
                return
            first = False

    def _read_request(self, first: bool) -> Request | None:
        """The next request; None if the peer closed, or was idle or slow for too long."""
        received, begun = 0, self._clock.monotonic()
        while True:
            event: Event | None = self._http.next_event()
            if isinstance(event, Request):
                self._tcp.established(self._sock)
                return event
            if isinstance(event, ContinueWanted):
                self._send(CONTINUE)
                continue
            if event is not None:
                return None
            waiting = not first and not self._http.mid_message
            if waiting:
                self._tcp.idle(self._sock)
                budget, begun = self._limits.idle_seconds, self._clock.monotonic()
            else:
                budget = self._limits.handshake_seconds + received / _MIN_BYTES_PER_SECOND
            data = self._receive(begun + budget - self._clock.monotonic())
            if data is None:
                return None
            if waiting:
                self._tcp.established(self._sock)
                received, begun = 0, self._clock.monotonic()
            received += len(data)
            self._http.receive(data)

    def _receive(self, seconds: float) -> bytes | None:
        """Bytes; b"" at the end of the stream; None on a time-out or reset."""
        if seconds <= 0:
            return None
        try:
            self._sock.settimeout(seconds)
            return self._sock.recv(_RECV_BYTES)
        except OSError:
            return None

    def _respond(self, request: Request) -> bool:
        """Answer one request; return whether the connection stays open."""
        if request.method != "POST":
            status, allow = (405, "POST") if request.method in ("GET", "HEAD", "PUT", "DELETE") else (501, "")
            self._send(self._http.encode_response(status, keep_alive=False, allow=allow))
            return False
        if request.target.partition("?")[0] not in _PATHS:
            self._send(self._http.encode_response(404, keep_alive=request.keep_alive))
            return request.keep_alive
        with self._server.answering():
            body = self._server.answer(request.body, self._peer)
            try:
                self._send(self._http.encode_response(200, body, keep_alive=request.keep_alive))
            finally:
                self._server.sent(body)
        return request.keep_alive

    def _send(self, data: bytes) -> None:
        self._sock.settimeout(self._limits.handshake_seconds)
        write_steadily(self._sock, data)

    def _refuse(self, status: int, error: RemoteProtocolError) -> None:
        log.debug("! %s: request from %s refused: %s", self._server._name, self._peer, error)
        try:
            self._send(self._http.encode_response(status, str(error).encode(), keep_alive=False))
            self._linger()
        except (OSError, RosError):
            pass  # the peer has gone, and the connection ends anyway

    def _linger(self) -> None:
        """Read for a moment: closing with unread bytes resets the connection, and the reply is lost."""
        self._sock.shutdown(socket.SHUT_WR)
        deadline, left = Deadline(_LINGER_SECONDS, self._clock), _LINGER_BYTES
        while left > 0:
            data = self._receive(deadline.remaining() or 0.0)
            if not data:
                return
            left -= len(data)
