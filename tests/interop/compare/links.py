"""TCPROS links of rospy's publishers, subscribers, service servers and proxies, with a peer that is odd."""

from __future__ import annotations

import _thread
import random
import re
import socket
import struct
import threading
import time
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from unittest.mock import patch
from xmlrpc.client import ServerProxy
from xmlrpc.server import SimpleXMLRPCServer

from rosproto import message_class
from rosproto.bag import BagReader
from rosproto.cli import publish as cli_publish
from rosproto.cli.yaml_values import fields_of as fields_given
from rosproto.codec import encode
from rosproto.codec.dicts import from_dict
from rosproto.errors import RosError
from rosproto.node import Node
from rosproto.time import Time
from tests.interop.compare.comparison import Answer, Case, Kind, Peer, environment, run_command
from tests.interop.compare.values import RostopicEcho, without_now, words

STRING_MD5 = "992ce8a1687cec8c8bd883ec73ca41d1"
SETBOOL_MD5 = "09fb03525b03e7ea1fd3992bafd87e16"
QUIET_SECONDS = 0.3  # a peer that has said nothing for so long says nothing more
HEARD_SECONDS = 1.0  # what `rostopic pub -1` has published comes within this time
LAST = "the last message"  # whoever takes it unsubscribes
ECHO_SECONDS = 10.0  # an echo that cannot print a message does not count it, and never ends
ODD = [
    "",
    "*",
    "x",
    "/x",
    "std_msgs/Int32",
    "std_srvs/Trigger",
    "0",
    "1",
    "a=b",
    "\u4e2d",
    "a b",
    STRING_MD5,
    SETBOOL_MD5,
    "\n",
]


def fields_of(chance: random.Random, usual: dict[str, str]) -> list[str]:
    """Fields of a connection header, mostly as usual."""
    fields = dict(usual)
    for _ in range(chance.choice([0, 0, 1, 1, 1, 2])):
        name = chance.choice(sorted(usual))
        if chance.random() < 0.4:
            fields.pop(name, None)
        else:
            fields[name] = chance.choice(ODD)
    if chance.random() < 0.15:
        fields[
            chance.choice(["tcp_nodelay", "extra", "error", "persistent", "probe", "latching", "\u4e2d"])
        ] = chance.choice(ODD)
    words = [f"{name}={value}" for name, value in fields.items()]
    if chance.random() < 0.2:
        chance.shuffle(words)
    if chance.random() < 0.05:
        words.append(chance.choice(["noequals", "", "=x", words[0] if words else "a=b"]))
    return words


def header(words: list[str]) -> bytes:
    body = b"".join(struct.pack("<I", len(word.encode())) + word.encode() for word in words)
    return struct.pack("<I", len(body)) + body


def _exactly(link: socket.socket, count: int) -> bytes:
    data = b""
    while len(data) < count:
        part = link.recv(count - len(data))
        if not part:
            raise EOFError
        data += part
    return data


def _block(link: socket.socket) -> bytes:
    return _exactly(link, min(struct.unpack("<I", _exactly(link, 4))[0], 1 << 16))


def read_header(link: socket.socket) -> Answer:
    """The other side's header, without what differs between two nodes; "closed", or "quiet"."""
    try:
        block = _block(link)
        fields, at = {}, 0
        while at < len(block):
            size = struct.unpack_from("<I", block, at)[0]
            name, _, value = block[at + 4 : at + 4 + size].decode().partition("=")
            fields[name] = value
            at += 4 + size
    except (EOFError, ConnectionError):
        return "closed"
    except TimeoutError:
        return "quiet"
    fields.pop("callerid", None)
    return {"error": "header", "says": fields["error"]} if "error" in fields else fields


def _message(link: socket.socket) -> str:
    try:
        return _block(link).hex()
    except (EOFError, ConnectionError):
        return "closed"
    except TimeoutError:
        return "quiet"


class Link(Kind):
    """A kind with a node of each layer, on a master of its own."""

    asked = "live"

    def __init__(self, real: Peer, real_master: str, layer: Peer, layer_master: str) -> None:
        self.peer, self._layer = real, layer
        self._masters = {id(real): real_master, id(layer): layer_master}

    def theirs(self, case: Case, peer: Peer) -> Answer:
        return self._with(peer, case)

    def ours(self, case: Case) -> Answer:
        return self._with(self._layer, case)

    def _with(self, peer: Peer, case: Case) -> Answer:
        raise NotImplementedError

    def close(self) -> None:
        """Release what the kind listens on."""

    def _slave(self, peer: Peer) -> str:
        """Start the node, once, and return its address."""
        return str(peer.ask("live", {})["uri"])


class ToPublisher(Link):
    """An odd subscriber connects to rospy.Publisher."""

    def draw(self, chance: random.Random) -> Case:
        usual = {
            "callerid": "/odd", "topic": "/said", "type": "std_msgs/String", "md5sum": STRING_MD5, "message_definition": "string data\n"
        }  # fmt: skip
        return {"header": fields_of(chance, usual)}

    def _with(self, peer: Peer, case: Case) -> Answer:
        with ServerProxy(self._slave(peer)) as slave:
            _, _, found = slave.requestTopic("/odd", "/said", [["TCPROS"]])  # type: ignore[misc]
        with socket.create_connection((found[1], found[2]), 5.0) as link:  # type: ignore[index]
            link.settimeout(QUIET_SECONDS)
            link.sendall(header(case["header"]))
            reply = read_header(link)
            return {
                "reply": reply,
                "message": _message(link) if isinstance(reply, dict) and "error" not in reply else "",
            }


class ToService(Link):
    """An odd client connects to rospy.Service."""

    def draw(self, chance: random.Random) -> Case:
        usual = {"callerid": "/odd", "service": "/set", "md5sum": SETBOOL_MD5, "type": "std_srvs/SetBool"}
        words = fields_of(chance, usual)
        if chance.random() < 0.3:
            words.append("persistent=1")
        calls = [
            chance.choice(["01", "00", "01", "02", *(["", "0100"] if chance.random() < 0.1 else [])])
            for _ in range(chance.choice([1, 1, 2]))
        ]
        return {"header": words, "calls": calls}

    def _with(self, peer: Peer, case: Case) -> Answer:
        self._slave(peer)
        with ServerProxy(self._masters[id(peer)]) as master:
            _, _, uri = master.lookupService("/odd", "/set")  # type: ignore[misc]
        host, _, port = str(uri).removeprefix("rosrpc://").rpartition(":")
        with socket.create_connection((host, int(port)), 5.0) as link:
            link.settimeout(QUIET_SECONDS)
            link.sendall(header(case["header"]))
            answers = [read_header(link)]
            for name in ("request_type", "response_type"):  # ours sends them, as roscpp does
                answers[0].pop(name, None) if isinstance(answers[0], dict) else None
            if not isinstance(answers[0], dict) or "error" in answers[0]:
                return {"answers": answers}
            for data in case["calls"]:
                try:
                    link.sendall(struct.pack("<I", len(data) // 2) + bytes.fromhex(data))
                    good = _exactly(link, 1)
                    text = _block(link)
                    answers.append(
                        text.hex()
                        if good == b"\1"
                        else {"error": "service", "says": text.decode("utf-8", "replace")}
                    )
                except (EOFError, ConnectionError):
                    answers.append("closed")
                    break
                except TimeoutError:
                    answers.append("quiet")
                    break
            return {"answers": answers}


class _Server:
    """Accepts one connection after another, and answers each by a function."""

    def __init__(self) -> None:
        self._socket = socket.create_server(("127.0.0.1", 0))
        self.port: int = self._socket.getsockname()[1]
        self.answer: Callable[[socket.socket], None] = lambda link: None
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self) -> None:
        while True:
            try:
                link, _ = self._socket.accept()
            except OSError:
                return
            with link:
                link.settimeout(QUIET_SECONDS)
                try:
                    self.answer(link)
                except (OSError, EOFError):
                    pass

    def close(self) -> None:
        self._socket.shutdown(socket.SHUT_RDWR)
        self._socket.close()
        self._thread.join(5.0)


class Answering(Link):
    """A kind whose case is the server."""

    def __init__(self, *of_link: Any) -> None:
        super().__init__(*of_link)
        self.server = _Server()

    def close(self) -> None:
        self.server.close()


class FromService(Answering):
    """rospy.ServiceProxy calls an odd server."""

    def __init__(self, *of_link: Any) -> None:
        super().__init__(*of_link)
        for uri in self._masters.values():
            with ServerProxy(uri) as master:
                master.registerService(
                    "/odd", "/odd", f"rosrpc://127.0.0.1:{self.server.port}", "http://127.0.0.1:1"
                )

    def draw(self, chance: random.Random) -> Case:
        usual = {
            "callerid": "/odd",
            "md5sum": SETBOOL_MD5,
            "type": "std_srvs/SetBool",
            "request_type": "std_srvs/SetBoolRequest",
            "response_type": "std_srvs/SetBoolResponse",
        }
        good = "0106000000" + "01" + "0100000078"
        answer = chance.choice(
            [
                good,
                good,
                good,
                "0005000000" + b"wrong".hex(),
                "0000000000",
                "01",
                "",
                "0103000000010000",
                "0107000000" + "01" + "010000007878",
                "02" + good[2:],
                "01ffffffff",
            ]
        )
        return {
            "header": fields_of(chance, usual),
            "answer": answer,
            "closes": chance.choice(["never", "first", "before"]),
        }

    def _with(self, peer: Peer, case: Case) -> Answer:
        self._slave(peer)

        def answer(link: socket.socket) -> None:
            if case["closes"] == "first":
                return
            read_header(link)
            link.sendall(header(case["header"]))
            if case["closes"] == "before":
                return
            _block(link)
            link.sendall(bytes.fromhex(case["answer"]))

        self.server.answer = answer
        return peer.ask("live_call", {"service": "/odd"})


class FromPublisher(Answering):
    """rospy.Subscriber takes what an odd publisher sends, and after it perhaps a last message."""

    def __init__(self, *of_link: Any) -> None:
        super().__init__(*of_link)
        self._told: Any = None
        self._done = threading.Event()
        self._node = SimpleXMLRPCServer(("127.0.0.1", 0), logRequests=False)
        self._node.register_function(self._request_topic, "requestTopic")
        threading.Thread(target=self._node.serve_forever, daemon=True).start()

    def close(self) -> None:
        super().close()
        self._node.shutdown()
        self._node.server_close()

    def draw(self, chance: random.Random) -> Case:
        usual = {
            "callerid": "/odd",
            "topic": "/said",
            "type": "std_msgs/String",
            "md5sum": STRING_MD5,
            "message_definition": "string data\n",
        }
        frames = [
            chance.choice(
                [
                    "05000000" + "01000000" + "61",
                    "0400000000000000",
                    "00000000",
                    "0300000001000",
                    "0800000001000000" + "61626364",
                    "0500000002000000" + "61",
                ]
            )
            for _ in range(chance.randrange(1, 4))
        ]
        frames = [frame if len(frame) % 2 == 0 else frame + "0" for frame in frames]
        told = chance.choice(
            [None] * 8
            + [
                [0, "no", 0],
                [1, "", []],
                [1, "", ["UDPROS", "127.0.0.1", 1]],
                [1, "", ["TCPROS"]],
                [-1, "x", []],
                1,
            ]
        )
        return {"header": fields_of(chance, usual), "frames": frames, "told": told}

    def _request_topic(self, *_: object) -> Any:
        if self._told is None:
            return [1, "", ["TCPROS", "127.0.0.1", self.server.port]]
        self._done.set()  # it does not connect
        return self._told

    def _with(self, peer: Peer, case: Case) -> Answer:
        slave = self._slave(peer)
        self._told, self._done = case["told"], threading.Event()
        last = struct.pack("<I", len(LAST)) + LAST.encode()

        def answer(link: socket.socket) -> None:
            self.server.answer = lambda other: None  # who connects again gets nothing
            read_header(link)
            link.sendall(header(case["header"]))
            try:
                for frame in [*map(bytes.fromhex, case["frames"]), struct.pack("<I", len(last)) + last]:
                    link.sendall(frame)
                link.recv(1)  # it refuses and closes, or unsubscribes, or is quiet
            finally:
                self._done.set()

        self.server.answer = answer
        topic = str(peer.ask("live_subscribe", {"last": LAST})["topic"])
        with ServerProxy(slave) as node:
            node.publisherUpdate("/master", topic, [f"http://127.0.0.1:{self._node.server_address[1]}"])
        self._done.wait(2 * QUIET_SECONDS)
        return peer.ask("live_received", {})


class LiveEcho(RostopicEcho):
    """`rostopic echo` of messages that are published meanwhile, beside ours."""

    asked = "rostopic_live"

    def __init__(self, folder: Path, node: Node, peer: Peer) -> None:
        super().__init__(folder)
        self._node, self.peer = node, peer
        self._number = 0

    def draw(self, chance: random.Random) -> Case:
        case = super().draw(chance)
        path = "" if case["words"][0] == "-a" else case["words"][0].removeprefix("/t")
        path = re.sub(r"\[-?\d+\]", "", path)  # both wait for ever for an element that is not there
        options = [word for word in case["words"][1:] if word not in ("-n", "1")]
        return {**case, "words": [path, *options]}

    def theirs(self, case: Case, peer: Peer) -> Answer:
        return self._heard(case, lambda words: peer.ask(self.asked, {"words": words}))

    def ours(self, case: Case) -> Answer:
        with environment(ROS_MASTER_URI=self._node.master_uri):
            limit = threading.Timer(ECHO_SECONDS, _thread.interrupt_main)
            limit.start()
            try:
                return self._heard(case, lambda words: run_command("topic", *words))
            finally:
                limit.cancel()

    def _heard(self, case: Case, echo: Callable[[list[str]], Answer]) -> Answer:
        self._number += 1
        topic = f"/echo{self._number}"
        path, *options = case["words"]
        with BagReader(case["bag"]) as bag:
            messages = [message for _, message, _ in bag.read_messages()]
        if not messages:
            return {"out": ""}
        with self._node.publisher(topic, type(messages[0]), queue_size=10) as publisher:

            def talk() -> None:
                while not publisher.connections:
                    if ended.wait(0.005):
                        return
                for message in messages:
                    publisher.publish(message)

            ended = threading.Event()
            speaker = threading.Thread(target=talk)
            speaker.start()
            answer = echo(["echo", topic + path, "-n", str(len(messages)), *options])
            ended.set()
            speaker.join()
        answer = {key: answer[key] for key in ("out", "error", "says") if key in answer}
        if "out" in answer and "-p" in options:  # the time at which it came
            answer["out"] = re.sub(r"(?m)^\d+(?=,|$)", "time", answer["out"])
        return answer


class LivePub(Kind):
    """`rostopic pub -1` beside ours: what a subscriber receives."""

    asked = "rostopic_pub"

    def __init__(self, node: Node, peer: Peer) -> None:
        self._node, self.peer = node, peer
        self._number = 0
        self._heard = threading.Event()

    def draw(self, chance: random.Random) -> Case:
        kind = chance.choice(
            [
                "std_msgs/String",
                "std_msgs/Float64MultiArray",
                "geometry_msgs/PoseStamped",
                "std_msgs/Empty",
                "std_msgs/Int8",
            ]
        )
        cls: Any = message_class(kind)
        good: list[str] = []
        while not good:
            given = words(chance, cls) if cls.__slots__ else []
            try:
                encode(from_dict(cls, fields_given(given, cls), now=Time(7, 8)))
            except (RosError, ValueError):
                continue
            good = [kind, *given]
        return {"type": kind, "words": good, "options": chance.choice([[], ["-l"], ["-s"]])}

    def theirs(self, case: Case, peer: Peer) -> Answer:
        return self._came(case, lambda given: peer.ask(self.asked, {"words": given}))

    def ours(self, case: Case) -> Answer:
        def sleep(seconds: float) -> None:
            self._heard.wait(HEARD_SECONDS)  # instead of lingering for subscribers that are still connecting

        with (
            environment(ROS_MASTER_URI=self._node.master_uri),
            patch.object(cli_publish, "time", SimpleNamespace(**{**vars(time), "sleep": sleep})),
        ):
            return self._came(case, lambda given: run_command("topic", *given))

    def _came(self, case: Case, publish: Callable[[list[str]], Answer]) -> Answer:
        self._number += 1
        topic = f"/pub{self._number}"
        came: list[Any] = []
        self._heard = heard = threading.Event()

        def take(message: Any) -> None:
            without_now(message)
            # Not whether it is latched: rospy says so only to who connects after it has begun to latch.
            came.append([encode(message).hex(), dict(message._connection_header).get("type")])
            heard.set()

        with self._node.subscriber(topic, case["type"], take):
            answer = publish(["pub", "-1", *case["options"], topic, *case["words"]])
            if "error" not in answer:
                heard.wait(HEARD_SECONDS)  # the node of `rostopic pub` goes on
        return {"came": came} if "error" not in answer else answer
