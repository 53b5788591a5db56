"""An HTTP client that posts to one server: keep-alive, one deadline per request, errors with the peer."""

from __future__ import annotations

import socket
import threading
from collections.abc import Mapping
from typing import TYPE_CHECKING

from rosproto.errors import ConnectionLost, RosError, RosTimeout
from rosproto.protocol.http import XML, HttpClientConnection, Response
from rosproto.protocol.wire_limits import Limits
from rosproto.sentence import led, say
from rosproto.transport.deadline import SYSTEM, Clock, Deadline
from rosproto.transport.os_errors import translate
from rosproto.transport.robot_host_names import HostNames
from rosproto.transport.tcp import connect, interrupt, set_linger
from rosproto.transport.uri import DEFAULT_MASTER_URI, format_address, make_uri, parse_uri, uri_path

if TYPE_CHECKING:
    from typing_extensions import Self

_RECV_BYTES = 1 << 16
_MAX_IDLE = 4
_IDLE_SECONDS = 20.0  # less than the time after which roscpp and rosmaster close idle connections


class HttpClient:
    """A client of one server. Thread-safe: requests from several threads run in parallel.

    Connections are kept for the next request. One that the server has closed is noticed before it is used.

    Args:
        uri: "http://host:port/"; see `parse_uri` for the forms.
        limits: `xml_body_bytes` and `http_head_bytes` limit the replies (`xml_depth`: those of XML-RPC).
        timeout: Default seconds for a request; None waits for ever.
        hosts: Resolves names that the system does not know.
        headers: Of every request: the type of its body, and credentials.

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
        headers: Mapping[str, str] = XML,
    ) -> None:
        self.host, self.port = parse_uri(uri)
        self.uri = make_uri(self.host, self.port)
        self.timeout = timeout
        self._path = uri_path(uri or DEFAULT_MASTER_URI)
        self._limits = limits or Limits()
        self._clock = clock
        self._hosts, self._headers = hosts, headers
        self._lock = threading.Lock()
        self._idle: list[_Link] = []
        self._busy: set[_Link] = set()
        self._closed = False

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.uri}{' closed' if self._closed else ''}>"

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

    def post(
        self, doing: str, body: bytes, deadline: Deadline, *, path: str | None = None, retry: bool = True
    ) -> Response:
        """Post a body and return the response, whatever its status is.

        If the server closes a kept connection during the request, before a byte of the reply, the request is
        sent once more on a new one, as in roscpp.

        Args:
            doing: What it does, for errors.
            body: The body.
            deadline: For connecting, sending and receiving together.
            path: The path; None takes that of the URI.
            retry: False for a request that must not be carried out twice.

        Raises:
            ConnectionLost: It cannot be reached, or the connection broke.
            RosTimeout: The time-out passed.
            RemoteProtocolError: The reply is not HTTP, or is too large.
        """
        while True:
            link = self._take(doing, deadline)
            kept = False
            try:
                response = link.exchange(doing, path or self._path, body, deadline)
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
        link = _Link(sock, self)
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

    __slots__ = ("_client", "_http", "_sock", "answered", "idle_since", "used")

    def __init__(self, sock: socket.socket, client: HttpClient) -> None:
        self._sock = sock
        self._client = client
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

    def exchange(self, doing: str, path: str, body: bytes, deadline: Deadline) -> Response:
        """Send a request and read its response; a failed request is not delivered later either."""
        self.answered = False
        doing = f"{doing} at {self._client.uri}"
        host = format_address(self._client.host, self._client.port)
        request = self._http.encode_request(host, path, body, self._client._headers)
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
