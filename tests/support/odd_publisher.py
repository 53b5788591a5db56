"""A publisher whose slave API is real and whose TCPROS side follows a script."""

from __future__ import annotations

import socket
import threading
from collections.abc import Callable
from typing import Any

from rosproto.node import MasterClient
from rosproto.protocol.handshake import encode_header, publisher_header
from rosproto.protocol.xmlrpc import Fault
from rosproto.transport import XmlRpcServer
from tests.support import attacks

__all__ = ["OddPublisher", "Script", "good_header", "message"]

Script = Callable[[socket.socket, "OddPublisher"], None]


def good_header(**fields: str) -> bytes:
    """What a publisher of std_msgs/String answers; fields changed, or ("") left out."""
    header = publisher_header(
        topic="/t", type_name="std_msgs/String", md5sum=attacks.STRING_MD5, callerid="/odd",
        message_definition="string data\n", latching=False,
    )  # fmt: skip
    return encode_header({key: value for key, value in {**header, **fields}.items() if value})


def message(text: str) -> bytes:
    """A std_msgs/String frame."""
    data = text.encode()
    size = len(data)
    return (size + 4).to_bytes(4, "little") + size.to_bytes(4, "little") + data


class OddPublisher:
    """Registered at a master; each subscriber's connection is given to `script(sock, self)` and closed afterwards.

    Attributes:
        script: May be replaced at any time.
        requests: requestTopic calls so far.
        connections: Connections accepted so far.
        answer: What requestTopic returns as value; None: the real address.
        ended: Set when it closes; scripts wait for this.
    """

    def __init__(
        self, master_uri: str, script: Script, *, topic: str = "/t", name: str = "/odd", port: int = 0
    ) -> None:
        self.script = script
        self.requests = 0
        self.connections = 0
        self.answer: Any = None
        self.code = 1
        self.ended = threading.Event()
        self._topic = topic
        self._server = socket.create_server(("127.0.0.1", 0), backlog=64)
        self._slave = XmlRpcServer("127.0.0.1", port, self._dispatch, name="odd")
        self.uri = self._slave.uri
        self._master = MasterClient(master_uri, name)
        threading.Thread(target=self._accept, name="odd publisher", daemon=True).start()
        self._master.register_publisher(topic, "std_msgs/String", self.uri)

    def __enter__(self) -> OddPublisher:
        return self

    def __exit__(self, *exc: object) -> None:
        self.ended.set()
        self._server.close()
        self._slave.close()
        with self._master:
            self._master.unregister_publisher(self._topic, self.uri)

    def _dispatch(self, method: str, params: list[Any], peer: object) -> Any:
        if method != "requestTopic":
            raise Fault(-1, "no")
        self.requests += 1
        if self.answer is not None:
            return [self.code, "", self.answer]
        return [1, "", ["TCPROS", "127.0.0.1", self._server.getsockname()[1]]]

    def _accept(self) -> None:
        while not self.ended.is_set():
            try:
                sock, _ = self._server.accept()
            except OSError:
                return
            self.connections += 1
            threading.Thread(target=self._serve, args=(sock,), name="odd link", daemon=True).start()

    def _serve(self, sock: socket.socket) -> None:
        with sock:
            sock.settimeout(60)
            try:
                self.script(sock, self)
            except (OSError, AssertionError):
                pass  # the subscriber has disconnected
