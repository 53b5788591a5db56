"""A master, its nodes, a publisher and a service that send terminal control sequences in every text."""

from __future__ import annotations

import contextlib
import socket
import threading
import unicodedata
from pathlib import Path

from rosproto import BagWriter
from rosproto.codec import define
from rosproto.protocol.handshake import encode_header
from rosproto.time import Time
from rosproto.transport import XmlRpcServer

__all__ = ["EVIL", "HostilePeer", "hostile_bag", "wrongs_of"]

EVIL = "/evil\x7f\x85\u202egnp.\u200b\u2066\u2028\u2029\ufeff\nFORGED by a peer\rFORGED\tx"
"""What XML can carry; `RAW` has the rest."""
RAW = "\x1b]0;owned\x07\x1b[2J\x1b[31m\x9b31m\x08" + EVIL
"""For headers, bags and messages."""


def wrongs_of(text: str) -> list[str]:
    """Return the errors in a command's output with a hostile peer; indented lines belong to a text."""
    bad = sorted({f"U+{ord(c):04X}" for c in text if c not in "\n\t" and not _harmless(c)})
    return [*bad, *(line for line in text.split("\n") if line.startswith("FORGED"))]


def _harmless(character: str) -> bool:
    return unicodedata.category(character) not in ("Cc", "Cf", "Cs", "Zl", "Zp")


class HostilePeer:
    """Answers calls to a master and a node, and TCPROS, with hostile texts, until `close`.

    Attributes:
        uri: Of the master, and of every node it names.
    """

    def __init__(self) -> None:
        self._tcp = socket.create_server(("127.0.0.1", 0))
        self._server = XmlRpcServer("127.0.0.1", 0, self._answer, name="hostile")
        self.uri = self._server.uri
        threading.Thread(target=self._accept, daemon=True).start()

    def close(self) -> None:
        self._tcp.close()
        self._server.close()

    def __enter__(self) -> HostilePeer:
        return self

    def __exit__(self, *exc: object) -> None:
        self.close()

    @property
    def _port(self) -> int:
        return int(self._tcp.getsockname()[1])

    def _answer(self, method: str, params: object, *more: object) -> object:
        nodes = [EVIL, "/node"]
        names = [EVIL, "/t", "/srv", "/robot_status", "/tf"]
        answers: dict[str, object] = {
            "getSystemState": [[[name, nodes] for name in names]] * 3,
            "getTopicTypes": [["/t", "std_msgs/String"], [EVIL, EVIL], ["/srv", EVIL]],
            "getPublishedTopics": [[EVIL, EVIL], ["/t", "std_msgs/String"]],
            "lookupNode": self.uri,
            "lookupService": f"rosrpc://127.0.0.1:{self._port}",
            "getParamNames": [EVIL, "/p"],
            "getParam": {EVIL: EVIL, "list": [EVIL], "text": EVIL},
            "searchParam": EVIL,
            "getUri": self.uri,
            "getPid": 1,
            "getName": EVIL,
            "getBusInfo": [[1, EVIL, "o", "TCPROS", EVIL, 1, EVIL]],
            "getBusStats": [[], [], []],
            "getPublications": [[EVIL, EVIL]],
            "getSubscriptions": [[EVIL, EVIL]],
            "registerSubscriber": [self.uri],
            "registerPublisher": [],
            "registerService": 1,
            "requestTopic": ["TCPROS", "127.0.0.1", self._port],
        }
        if method in answers:
            return [1, EVIL, answers[method]]
        return [0, EVIL, 0]

    def _accept(self) -> None:
        with contextlib.suppress(OSError):
            while True:
                connection = self._tcp.accept()[0]
                threading.Thread(target=self._shake, args=(connection,), daemon=True).start()

    def _shake(self, connection: socket.socket) -> None:
        with connection, contextlib.suppress(OSError):
            connection.settimeout(3.0)
            asked = connection.recv(65536)
            probe = {"callerid": RAW, "type": RAW, "md5sum": RAW}
            fields = probe if b"probe=1" in asked else {"error": RAW}
            connection.sendall(encode_header(fields))


def hostile_bag(path: Path) -> Path:
    """A bag whose topics, type, definition and values are hostile."""
    kind = define("evil_msgs/Evil", f"string data\n# {RAW.splitlines()[0]}\n")
    with BagWriter(path) as bag:
        for topic in ("/t", RAW):
            for second in range(3):
                bag.write(topic, kind(data=RAW), Time(1 + second, 0))
    return path
