"""An XML-RPC client for masters and nodes: keep-alive, one deadline per call, errors that name the peer."""

from __future__ import annotations

import socket
import threading

from rosproto.errors import ConnectionLost, MasterError, RemoteProtocolError, RosError, RosTimeout, TooLarge
from rosproto.protocol import xmlrpc
from rosproto.protocol.http import HttpClientConnection, Response
from rosproto.protocol.wire_limits import Limits
from rosproto.sentence import both, led, say
from rosproto.transport.deadline import SYSTEM, Clock, Deadline
from rosproto.transport.os_errors import translate
from rosproto.transport.robot_host_names import HostNames
from rosproto.transport.tcp import connect, interrupt, set_linger
from rosproto.transport.uri import DEFAULT_MASTER_URI, format_address, make_uri, parse_uri, uri_path

_RECV_BYTES = 1 << 16
_MAX_IDLE = 4
_IDLE_SECONDS = 20.0  # less than the time after which roscpp and rosmaster close idle connections


class LastReply:
    """The last reply to a question that is asked again and again, to decode it only when it has changed.

    Attributes:
        body: Its bytes.
        value: What they mean; not to be changed.
    """

    def __init__(self) -> None:
        self.body = b""
        self.value: object = None


class XmlRpcClient:
    """A client of one server. Thread-safe: calls from several threads run in parallel.

    Connections are kept for the next call. One that the server has closed is noticed before it is used. If it
    closes during the call, before a byte of the reply, the call is sent once more on a new connection, as in
    roscpp: the calls of the master and slave API may be repeated safely.

    Args:
        uri: "http://host:port/"; see `parse_uri` for the forms.
        limits: `xml_body_bytes`, `xml_depth` and `http_head_bytes` limit the replies.
        timeout: Default seconds for a call; None waits for ever.
        hosts: Resolves names that the system does not know.

    Raises:
        ValueError: The URI is invalid.
    """

    def __init__(
        self,
        uri: str,
        *,
        limits: Limits | None = None,
        timeout: float | None = 10.0,
        clock: Clock = SYSTEM,
        hosts: HostNames | None = None,
    ) -> None:
        self.host, self.port = parse_uri(uri)
        self.uri = make_uri(self.host, self.port)
        self.timeout = timeout
        self._path = uri_path(uri or DEFAULT_MASTER_URI)
        self._limits = limits or Limits()
        self._clock = clock
        self._hosts = hosts
        self._lock = threading.Lock()
        self._idle: list[_Link] = []
        self._busy: set[_Link] = set()
        self._closed = False

    def __enter__(self) -> XmlRpcClient:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<XmlRpcClient {self.uri}{' closed' if self._closed else ''}>"

    def call(
        self,
        method: str,
        *params: object,
        timeout: float | None = None,
        retry: bool = True,
        last: LastReply | None = None,
    ) -> object:
        """Call a method and return its value.

        Args:
            method: XML-RPC method name.
            params: Its arguments.
            timeout: Seconds for connecting, sending and receiving together; None takes the client's.
            retry: Send once more if a kept connection turns out to be closed; False for a method that must
                not run twice.
            last: The reply before; if this one has the same bytes, its value is returned again.

        Raises:
            MasterError: The server replied with a fault.
            ConnectionLost: It cannot be reached, or the connection broke.
            RosTimeout: The time-out passed.
            RemoteProtocolError: The reply is not an XML-RPC response.
            LocalProtocolError: An argument cannot be sent.
        """
        deadline = Deadline(self.timeout if timeout is None else timeout, self._clock)
        body = xmlrpc.encode_call(method, params)
        try:
            response = self._exchange(method, body, deadline, retry)
            if response.status != 200:
                raise RemoteProtocolError(f"HTTP {response.status} {response.reason}, expected 200 OK")
            if last is not None and last.body == response.body:
                return last.value
            value = xmlrpc.decode_response(response.body, self._limits)
            if last is not None:
                last.body, last.value = response.body, value
            return value
        except RemoteProtocolError as error:
            hint = () if isinstance(error, TooLarge) else ("is this a ROS master or node?",)
            error.peer, error.why = self.uri, both(str(error), *hint)
            text = say("{method} at {uri}: {error}", method=method, uri=self.uri, error=error.why)
            error.args = (text, *error.args[1:])
            raise
        except xmlrpc.Fault as fault:
            raise MasterError(method, fault.code, fault.text, uri=self.uri) from fault

    def abandon(self) -> None:
        """Close in a forked child, without taking locks that threads of the parent held."""
        self._lock, self._closed = threading.Lock(), True
        self._idle, self._busy = [], set()

    def close(self) -> None:
        """Close all connections; running calls raise ConnectionLost."""
        with self._lock:
            self._closed = True
        self.reconnect()

    def reconnect(self) -> None:
        """Drop all connections, because this computer has a new address. Running calls on kept connections
        are sent again.
        """
        with self._lock:
            busy = list(self._busy)
        self._drop_idle()
        for link in busy:
            link.abort()

    def _exchange(self, method: str, body: bytes, deadline: Deadline, retry: bool) -> Response:
        while True:
            link = self._take(method, deadline)
            kept = False
            try:
                response = link.exchange(method, body, deadline)
                kept = response.keep_alive
                return response
            except ConnectionLost:
                if not (retry and link.used and not link.answered) or self._closed:
                    raise
                self._drop_idle()  # others of its age are closed as well; a new connection is not `used`
            finally:
                self._give_back(link, kept)

    def _take(self, method: str, deadline: Deadline) -> _Link:
        """A kept connection that is still open, or a new one."""
        while True:
            with self._lock:
                if self._closed:
                    raise ConnectionLost(f"{method}: this client of {self.uri} is closed", peer=self.uri)
                link = self._idle.pop() if self._idle else None
                if link is not None:
                    self._busy.add(link)
            if link is None:
                return self._open(method, deadline)
            if link.fresh(self._clock.monotonic()):
                return link
            self._give_back(link, False)

    def _open(self, method: str, deadline: Deadline) -> _Link:
        try:
            sock = connect(self.host, self.port, deadline, hosts=self._hosts)
        except RosError as error:
            text = say("{method} at {uri}: {error}", method=method, uri=self.uri, error=error)
            why = error.why or str(error)
            if isinstance(error, RosTimeout):
                seconds = error.seconds
                raise RosTimeout(text, what=method, seconds=seconds, peer=self.uri, why=why) from error
            raise ConnectionLost(text, peer=self.uri, why=why) from error
        link = _Link(sock, self, self._path)
        with self._lock:
            self._busy.add(link)
            closed = self._closed
        if closed:
            link.abort()  # closed while we connected: the exchange then fails at once
        return link

    def _give_back(self, link: _Link, keep: bool) -> None:
        with self._lock:
            self._busy.discard(link)
            keep = keep and not self._closed and len(self._idle) < _MAX_IDLE
            if keep:
                link.idle_since = self._clock.monotonic()
                self._idle.append(link)
        if not keep:
            link.close()

    def _drop_idle(self) -> None:
        with self._lock:
            idle, self._idle = self._idle, []
        for link in idle:
            link.close()


class _Link:
    """One connection of a client.

    Attributes:
        used: An exchange has succeeded on it, so the server may have closed it since.
        answered: Part of the reply to the current call has arrived.
        idle_since: When its last call ended.
    """

    __slots__ = ("_client", "_http", "_path", "_sock", "answered", "idle_since", "used")

    def __init__(self, sock: socket.socket, client: XmlRpcClient, path: str) -> None:
        self._sock = sock
        self._client = client
        self._path = path
        self._http = HttpClientConnection(client._limits)
        self.used = False
        self.answered = False
        self.idle_since = 0.0

    def fresh(self, now: float) -> bool:
        """Whether it was not idle for long and has nothing to read (readable would mean closed)."""
        if now - self.idle_since > _IDLE_SECONDS or self._http.mid_message:
            return False
        try:
            self._sock.setblocking(False)
            self._sock.recv(1, socket.MSG_PEEK)
        except BlockingIOError:
            return True
        except OSError:
            pass  # reset meanwhile
        return False

    def exchange(self, method: str, body: bytes, deadline: Deadline) -> Response:
        """Send a request and read its response; a failed request is not delivered later either."""
        self.answered = False
        doing = f"{method} at {self._client.uri}"
        host = format_address(self._client.host, self._client.port)
        request = self._http.encode_request(host, self._path, body)
        try:
            self._sock.settimeout(deadline.for_socket())
            self._sock.sendall(request)
            response = self._read(doing, deadline)
        except BaseException as error:
            # After an outage the network would deliver the old request behind newer ones, and register a
            # publisher for ever that was unregistered meanwhile.
            set_linger(self._sock, False)
            if isinstance(error, OSError) and not isinstance(error, ConnectionLost):
                raise translate(error, doing, self._client.uri, deadline) from error
            raise
        self.used = True
        return response

    def _read(self, doing: str, deadline: Deadline) -> Response:
        while (event := self._http.next_event()) is None:
            self._sock.settimeout(deadline.for_socket())
            data = self._sock.recv(_RECV_BYTES)
            self.answered = self.answered or bool(data)
            self._http.receive(data)
        if isinstance(event, Response):
            return event
        why = "the server closed the connection without an answer"
        raise ConnectionLost(led(doing, why), peer=self._client.uri, why=why)

    def abort(self) -> None:
        """Wake the thread that uses this connection; it then closes it."""
        interrupt(self._sock)

    def close(self) -> None:
        """Close the socket."""
        self._sock.close()


def unpack(method: str, reply: object, uri: str = "") -> object:
    """The value of a ROS reply `[code, statusMessage, value]`.

    Peers are inexact: a missing value is None, a code may be a bool.

    Raises:
        MasterError: The code is not 1 (-1: the caller's error, 0: the other side failed).
        RemoteProtocolError: The reply has no code.
    """
    if not isinstance(reply, list) or not reply or not isinstance(reply[0], int):
        raise RemoteProtocolError(
            f"{method}{' at ' + uri if uri else ''}: reply {reply!r:.80}, "
            "expected [code, statusMessage, value]"
        )
    text = reply[1] if len(reply) > 1 else ""
    if reply[0] != 1:
        raise MasterError(method, int(reply[0]), str(text), uri=uri)
    return reply[2] if len(reply) > 2 else None
