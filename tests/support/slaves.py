"""Stand-ins for nodes for tests of the master: a slave API that records its calls."""

from __future__ import annotations

import socket
import threading
from collections.abc import Callable

from rosproto.protocol.handshake import publisher_header
from rosproto.protocol.wire_limits import Limits
from rosproto.protocol.xmlrpc import Fault
from rosproto.transport import Deadline, TcpServer, XmlRpcServer, read_header, write_header

DEADLINE = 60.0


class RecordingNode:
    """A node with only the slave API.

    Attributes:
        calls: (method, parameters without caller id), in order of arrival.
        name: Answer of getName; None: no such method, as in roscpp.
        publications: Topics of getPublications.
        subscriptions: Topics of getSubscriptions.
        callerid: Sent in TCPROS headers; None: requestTopic returns nothing.
        hold: If an Event, publisherUpdate and paramUpdate answer only after it is set.
    """

    def __init__(
        self,
        *,
        name: str | None = None,
        callerid: str | None = None,
        publications: tuple[str, ...] = (),
        subscriptions: tuple[str, ...] = (),
        port: int = 0,
    ) -> None:
        self.calls: list[tuple[str, list[object]]] = []
        self.name = name
        self.callerid = callerid
        self.publications = publications
        self.subscriptions = subscriptions
        self.hold: threading.Event | None = None
        self._changed = threading.Condition()
        self._tcpros = TcpServer("127.0.0.1", 0, self._greet, name="recording tcpros")
        self._server = XmlRpcServer("127.0.0.1", port, self._dispatch, name="recording")
        self.uri = self._server.uri
        self.port = self._server.port

    def __enter__(self) -> RecordingNode:
        return self

    def __exit__(self, *exc: object) -> None:
        self.close()

    def close(self) -> None:
        if self.hold is not None:
            self.hold.set()
        self._server.close()
        self._tcpros.close()

    def told(self, method: str) -> list[list[object]]:
        """Parameters of all calls of a method so far."""
        with self._changed:
            return [params for name, params in self.calls if name == method]

    def wait_for(self, condition: Callable[[RecordingNode], bool]) -> None:
        """Wait until `condition(self)` holds; fail after a minute."""
        with self._changed:
            assert self._changed.wait_for(lambda: condition(self), DEADLINE), self.calls

    def _dispatch(self, method: str, params: list[object], peer: object) -> object:
        with self._changed:
            self.calls.append((method, params[1:]))
            self._changed.notify_all()
        if method in ("publisherUpdate", "paramUpdate", "shutdown"):
            if self.hold is not None:
                self.hold.wait(DEADLINE)
            return [1, "", 0]
        if method == "getName" and self.name is not None:
            return [1, "", self.name]
        if method == "getPublications":
            return [1, "", [[topic, "a/B"] for topic in self.publications]]
        if method == "getSubscriptions":
            return [1, "", [[topic, "a/B"] for topic in self.subscriptions]]
        if method == "requestTopic":
            if self.callerid is None:
                return [0, "no supported protocol implementations", 0]
            return [1, "", ["TCPROS", "127.0.0.1", self._tcpros.port]]
        raise Fault(-1, f"{method}: unknown method name")

    def _greet(self, sock: socket.socket, address: tuple[str, int]) -> None:
        deadline = Deadline(DEADLINE)
        fields = read_header(sock, Limits(), deadline)
        assert fields["topic"] in self.publications
        reply = publisher_header(
            topic=fields["topic"], type_name="a/B", md5sum="0" * 32, callerid=self.callerid or "",
            message_definition="", latching=False,
        )  # fmt: skip
        write_header(sock, reply, deadline)


class BlackHole:
    """A listening socket that never answers: the kernel accepts connections, nothing reads them."""

    def __init__(self, backlog: int = 64) -> None:
        self._socket = socket.socket()
        self._socket.bind(("127.0.0.1", 0))
        self._socket.listen(backlog)
        self.uri = f"http://127.0.0.1:{self._socket.getsockname()[1]}/"

    def __enter__(self) -> BlackHole:
        return self

    def __exit__(self, *exc: object) -> None:
        self._socket.close()
