"""A rosbridge gateway, or the server of the page, in a separate process, and many clients that send more than it can read.

The clients write prepared WebSocket frames to their sockets, in separate processes, so that only the gateway limits
their rate.
"""

from __future__ import annotations

import json
import select
import socket
import ssl
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

__all__ = ["PAYLOADS", "Crowd", "GatewayProcess", "PageProcess"]

ROOT = Path(__file__).resolve().parents[2]


class _Child:
    """A process that runs a function of this file until its input ends."""

    def __init__(self, call: str) -> None:
        self.process = subprocess.Popen(
            [
                sys.executable,
                "-c",
                f"from tests.support.gateway_flood import *; import tests.support.gateway_flood as f; f.{call}",
            ],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            cwd=ROOT,
        )

    def line(self) -> Any:
        assert self.process.stdout is not None
        return json.loads(self.process.stdout.readline())

    def memory(self, figure: str = "VmHWM") -> int:
        """The peak of resident bytes, or ("VmRSS") their number now; 0 if the system does not report it."""
        try:
            for line in Path(f"/proc/{self.process.pid}/status").read_text().splitlines():
                if line.startswith(f"{figure}:"):
                    return int(line.split()[1]) * 1024
        except OSError:
            pass
        return 0

    def __exit__(self, *exc: object) -> None:
        assert self.process.stdin is not None
        self.process.stdin.close()
        try:
            self.process.wait(20)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait(5)
            raise AssertionError("the process did not end by itself") from None


class GatewayProcess(_Child):
    """A master, and a gateway that opens `write`: "rosbridge" or "foxglove".

    Attributes:
        master_uri: The master's.
        port: Where the gateway listens.
    """

    def __init__(self, write: tuple[str, ...] = ("*",), kind: str = "rosbridge") -> None:
        super().__init__(f"serve({write!r}, {kind!r})")
        told = self.line()
        self.master_uri: str = told["master_uri"]
        self.port: int = told["port"]

    def __enter__(self) -> GatewayProcess:
        return self

    @property
    def url(self) -> str:
        return f"ws://127.0.0.1:{self.port}"


class PageProcess(_Child):
    """The server of `woosh web` for a chassis.

    Args:
        stop_seconds: How long a stop looks whether the robot stands, where another time than the usual is wanted.

    Attributes:
        port: Where it listens.
    """

    def __init__(
        self, master_uri: str, tls: tuple[str, str] | None = None, stop_seconds: float | None = None
    ) -> None:
        super().__init__(f"serve_page({master_uri!r}, {tls!r}, {stop_seconds!r})")
        self.port: int = self.line()["port"]

    def __enter__(self) -> PageProcess:
        return self


def serve(write: tuple[str, ...], kind: str) -> None:
    """The gateway's process."""
    from rosproto import Master, Node
    from rosproto.gateway import Access, GatewayLimits, Rosbridge
    from rosproto.gateway.foxglove import Foxglove

    Gateway = {"rosbridge": Rosbridge, "foxglove": Foxglove}[kind]
    with (
        Master() as master,
        Node("/gateway", master_uri=master.uri) as node,
        Gateway(node, port=0, access=Access(write=write), limits=GatewayLimits(connections=100)) as bridge,
    ):
        print(json.dumps({"master_uri": master.uri, "port": bridge.port}), flush=True)
        sys.stdin.read()


def serve_page(master_uri: str, tls: tuple[str, str] | None, stop_seconds: float | None) -> None:
    """The process of the page's server."""
    from woosh_pure import Chassis, web
    from woosh_pure.web import robot
    from woosh_pure.web.server import WebServer

    if stop_seconds is not None:
        robot.STOP_SECONDS = stop_seconds
    cert, key = tls or (None, None)
    with (
        Chassis(master_uri) as chassis,
        WebServer(web.app(chassis, allow_driving=True), port=0, tls_cert=cert, tls_key=key) as server,
    ):
        print(json.dumps({"port": server.port}), flush=True)
        sys.stdin.read()


def frame(data: bytes) -> bytes:
    """A client's text frame, masked with zeros."""
    size = len(data)
    if size < 126:
        head = bytes([0x81, 0x80 | size])
    elif size < 1 << 16:
        head = bytes([0x81, 0x80 | 126]) + size.to_bytes(2, "big")
    else:
        head = bytes([0x81, 0x80 | 127]) + size.to_bytes(8, "big")
    return head + bytes(4) + data


def control(opcode: int, data: bytes = b"") -> bytes:
    """A client's control frame, or a fragment that is not the last one, masked with zeros."""
    return bytes([opcode, 0x80 | len(data)]) + bytes(4) + data


def _message_of_frames(count: int) -> bytes:
    """A message of empty frames."""
    return control(0x01) + control(0x00) * (count - 2) + control(0x80)


def _publish(data: str) -> bytes:
    return f'{{"op":"publish","topic":"/flood","msg":{data}}}'.encode()


def _fragments(data: bytes) -> bytes:
    size = 8000
    pieces = [data[at : at + size].decode() for at in range(0, len(data), size)]
    return b"".join(
        frame(
            json.dumps(
                {"op": "fragment", "id": "f", "num": num, "total": len(pieces), "data": piece}
            ).encode()
        )
        for num, piece in enumerate(pieces)
    )


PAYLOADS = {
    "sixteen megabytes of numbers": lambda: frame(_publish("[" + "0," * (8 << 20) + "0]")),
    "a megabyte of numbers": lambda: frame(_publish("[" + "0," * 500_000 + "0]")),
    "many numbers": lambda: frame(_publish("[" + "0.123456," * 95_000 + "0]")),
    "many keys": lambda: frame(_publish("{" + ",".join(f'"key{i:010d}":0' for i in range(48_000)) + "}")),
    "a long text": lambda: frame(_publish('{"data":"' + "x" * 1_000_000 + '"}')),
    "many objects": lambda: frame(
        _publish('{"poses":[' + ",".join(['{"position":{"x":1}}'] * 18_000) + "]}")
    ),
    "fragments": lambda: _fragments(_publish("[" + "0.123456," * 95_000 + "0]")),
    "tiny messages": lambda: frame(_publish('{"data":"x"}')) * 20_000,
    "tiny invalid messages": lambda: frame(b"x") * 40_000,
    "messages of 3000 frames": lambda: _message_of_frames(3000) * 20,
    "pings": lambda: control(0x89) * 40_000,
    "pings of 125 bytes": lambda: control(0x89, b"x" * 125) * 8_000,
    "pongs": lambda: control(0x8A) * 40_000,
    "raw types": lambda: (
        frame(b'{"op":"call_service","service":"/rosapi/topics_and_raw_types","id":"raw"}') * 100
    ),
}
"""What one client sends again and again."""


class Crowd(_Child):
    """Clients that send one of `PAYLOADS` without end, and connect again when they are cut off."""

    def __init__(
        self, port: int, what: str, clients: int, path: str = "/", protocol: str = "", tls: bool = False
    ) -> None:
        super().__init__(f"flood({port}, {what!r}, {clients}, {path!r}, {protocol!r}, {tls})")
        assert self.line() == "begun"

    def __enter__(self) -> Crowd:
        return self


class _Client:
    def __init__(self, port: int, payload: bytes, path: str, protocol: str, tls: bool) -> None:
        self._port = port
        self._path = path
        self._protocol = protocol
        self._payload = payload
        self._tls = ssl.create_default_context() if tls else None
        if self._tls:
            self._tls.check_hostname, self._tls.verify_mode = False, ssl.CERT_NONE
        self._begin()

    def _begin(self) -> None:
        self.socket = socket.create_connection(("127.0.0.1", self._port), 20)
        if self._tls:
            self.socket = self._tls.wrap_socket(self.socket)
        protocol = f"Sec-WebSocket-Protocol: {self._protocol}\r\n" if self._protocol else ""
        self.socket.sendall(
            f"GET {self._path} HTTP/1.1\r\n{protocol}".encode()
            + b"Host: 127.0.0.1\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            b"Sec-WebSocket-Key: MDEyMzQ1Njc4OWFiY2RlZg==\r\nSec-WebSocket-Version: 13\r\n\r\n"
        )
        self.socket.settimeout(20)
        self.socket.recv(4096)
        if self._path == "/" and not self._protocol:  # of a rosbridge server
            advertise = b'{"op":"advertise","topic":"/flood","type":"geometry_msgs/PoseArray"}'
            self.socket.sendall(frame(advertise))
        self.socket.setblocking(False)
        self._left = memoryview(self._payload)

    def write(self) -> None:
        try:
            sent = self.socket.send(self._left[: 1 << 20])
            self._left = self._left[sent:] or memoryview(self._payload)
        except (BlockingIOError, ssl.SSLWantReadError, ssl.SSLWantWriteError):
            pass
        except OSError:
            self._again()

    def read(self) -> None:
        try:
            if not self.socket.recv(1 << 16):
                self._again()
        except (BlockingIOError, ssl.SSLWantReadError, ssl.SSLWantWriteError):
            pass
        except OSError:
            self._again()

    def _again(self) -> None:
        self.socket.close()
        try:
            self._begin()
        except ConnectionRefusedError:
            sys.exit()  # the server has ended


def flood(port: int, what: str, clients: int, path: str, protocol: str, tls: bool) -> None:
    """The clients' process."""
    payload = PAYLOADS[what]()
    crowd = [_Client(port, payload, path, protocol, tls) for _ in range(clients)]
    print(json.dumps("begun"), flush=True)
    while True:
        sockets = {client.socket.fileno(): client for client in crowd}
        readable, writable, _ = select.select([sys.stdin, *sockets], list(sockets), [], 1.0)
        if sys.stdin in readable:
            return
        for number in writable:
            sockets[number].write()
        for number in readable:
            sockets[number].read()
        time.sleep(0)
