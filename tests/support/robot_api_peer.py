"""`ApiPeer`: a scripted robot that answers its Robot API over HTTP, well, slowly, wrongly or not at all.

The values are the examples of the interface's documentation in our own words; no robot was asked.
"""

from __future__ import annotations

import base64
import json
import socket
import threading
from collections.abc import Callable, Mapping
from typing import Any

from woosh_pure.robot_api import wire

__all__ = ["ANSWERS", "PASSWORD", "ApiPeer", "endless", "half", "silent"]

PASSWORD = "site:word"
_POSE = {"x": 1.2, "y": -0.4, "theta": 0.7}
ANSWERS: dict[str, Any] = {
    "woosh.robot.RobotState": {"robotId": 7, "state": 2},
    "woosh.robot.Mode": {"ctrl": 1, "work": 2},
    "woosh.robot.DeviceState": {"hardware": 0, "software": 1},
    "woosh.robot.OperationState": {"nav": 0, "robot": 1},
    "woosh.robot.Scene": {"sceneName": "hall", "mapId": 1, "mapName": "ground", "version": "12"},
    "woosh.map.SceneList": {
        "scenes": [{"name": "hall", "maps": ["ground", "upper"]}, {"name": "yard", "maps": ["yard"]}]
    },
    "woosh.map.SceneDataEasy": {
        "name": "hall",
        "maps": [
            {
                "id": 1, "name": "ground", "floor": "0", "version": "12",
                "storages": {
                    "bases": [
                        {"identity": {"id": 11, "no": "A1", "desc": "shelf by the door"},
                         "pose": {"dock": {"x": 3.0, "y": 1.0, "theta": 1.5}, "real": {"x": 3.0, "y": 1.0, "theta": 1.5}}},
                        {"identity": {"id": 12, "no": "仓库 2"},
                         "pose": {"dock": {"x": "5.5", "y": 2.5, "theta": 7.0}, "real": {"x": 5.5, "y": 2.5}}},
                        {"identity": {"id": 13, "no": "nowhere"}, "pose": {"dock": {"x": "NaN", "y": 0.0, "theta": 0.0}}},
                    ],
                    "chargers": [
                        {"identity": {"id": 14, "no": "C1"},
                         "pose": {"dock": {"x": -0.9, "y": -3.0, "theta": 3.0}, "real": {"x": -2.0, "y": -3.0, "theta": 3.0}}},
                    ],
                },
            },
            {"id": 2, "name": "upper", "storages": {"bases": [{"identity": {"id": 21, "no": "U1"}, "pose": {"dock": {"x": 9.0}}}]}},
        ],
    },
    "woosh.map.SceneData": {
        "name": "hall",
        "maps": [
            {
                "id": 1, "name": "ground", "resolution": 0.05, "map_png": base64.b64encode(b"picture").decode(),
                "fieldInfo": {
                    "speedLimitFields": [
                        {"navFiled": {"id": 3, "navMode": 2, "maxSpeed": 0.3,
                                      "vertexs": [{"x": 0.0, "y": 0.0}, {"x": 2.0}, {"x": 2.0, "y": 2.0}, {"y": 2.0}]}}
                    ],
                    "oneWays": [{"navFiled": {"id": 4, "vertexs": [{"x": 0.0, "y": 0.0}, {"x": 2.0}]}}],
                },
            }
        ],
    },
    "woosh.robot.Model": {
        "model": [{"x": 0.41, "y": 0.27}, {"x": 0.41, "y": -0.27}, {"x": -0.41, "y": -0.27}, {"x": -0.41, "y": 0.27}],
        "type": 1,
    },
    "woosh.robot.General": {
        "type": 1, "modelData": {"length": 820, "width": 540, "height": 260, "weight": 88, "load": 100},
        "urdfName": "demo", "displayModel": "Demo 200", "serialNumber": 7, "serviceId": "D-0007",
        "driverMethod": 0, "version": {"system": "S1", "rc": "1.1.71"},
    },
    "woosh.robot.Setting": {
        "identity": {"name": "demo"}, "server": {"ip": "", "port": 5420}, "sound": {"mute": False, "volume": 40},
        "power": {"alarm": 8, "low": 25, "idle": 70, "full": 95}, "allow": {"autoCharge": False},
    },
    "woosh.robot.TaskHistory": {
        "tes": [
            {"robotTaskId": "140103000000", "type": 1, "state": 7, "dest": "A1", "msg": "", "time": 1790000000},
            {"robot_task_id": "-5", "type": "kCharge", "state": "kFailed", "dest": "C1", "msg": "no\x1b[31m way", "time": 1789999000},
        ]
    },
    "woosh.robot.count.StatusCodes": {
        "scs": [{"code": "110201000013", "time": "1790000000500", "msg": "急停", "robotTaskId": "4711", "level": 3}]
    },
    "woosh.robot.count.AbnormalCodes": {"scs": [{"code": "110201000013", "time": "1790000000500", "msg": "", "level": 9}]},
    "woosh.robot.SwitchMap": {},
    "woosh.robot.Battery": {"chargeState": 1, "power": 83, "health": 97},
    "woosh.robot.setting.Sound": {"mute": True, "volume": 40},
}  # fmt: skip
"""Bodies of answers by request."""

Script = Callable[[str, dict[str, Any]], Any]
"""Called with the request and its body: the answer's body, or an exception of `Refused`, or raw bytes to send."""


class Refused(Exception):
    """`ok` is false, with this text."""


def silent(request: str, body: Mapping[str, Any]) -> None:
    """A script that never answers: None holds the connection."""


def endless(request: str, body: Mapping[str, Any]) -> bytes:
    """A head that announces chunks; `ApiPeer` sends them until nobody reads."""
    return b"HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n"


def half(request: str, body: Mapping[str, Any]) -> bytes:
    """A body that ends too early, with the connection."""
    return b'HTTP/1.1 200 OK\r\nContent-Length: 1000\r\n\r\n{"ok":true,'


class ApiPeer:
    """A robot on 127.0.0.1 that answers as `answers` says; `asked` has what it was asked.

    Args:
        answers: Body, or a `Script`, by request; others are refused.
        wait: Called before each answer with the request; may block.
        password: "user:password" that it wants; "" for none.

    Attributes:
        asked: (request, body) in their order.
        connections: How many were made.
        pause: Seconds between two pieces of an endless answer.
    """

    def __init__(
        self, answers: Mapping[str, Any] = ANSWERS, *, wait: Callable[[str], object] = str, password: str = ""
    ) -> None:
        self.answers, self.wait, self.password = dict(answers), wait, password
        self.asked: list[tuple[str, dict[str, Any]]] = []
        self.connections = 0
        self.pause = 0.0
        self.closing = threading.Event()
        self._server = socket.create_server(("127.0.0.1", 0))
        self._open: list[socket.socket] = []
        self._thread = threading.Thread(target=self._accept, daemon=True)
        self._thread.start()

    @property
    def port(self) -> int:
        return int(self._server.getsockname()[1])

    @property
    def address(self) -> str:
        return f"{self.password}@127.0.0.1:{self.port}" if self.password else f"127.0.0.1:{self.port}"

    @property
    def requests(self) -> list[str]:
        """The last words of what it was asked."""
        return [request.rpartition(".")[2] for request, _ in self.asked]

    def __enter__(self) -> ApiPeer:
        return self

    def __exit__(self, *exc: object) -> None:
        self.closing.set()
        for sock in (self._server, *self._open):
            try:
                sock.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass
            sock.close()
        self._thread.join(5.0)

    def drop(self) -> None:
        """End all connections, as a robot that restarts."""
        for sock in self._open:
            try:
                sock.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass

    def _accept(self) -> None:
        while True:
            try:
                sock = self._server.accept()[0]
            except OSError:
                return
            self.connections += 1
            self._open.append(sock)
            threading.Thread(target=self._serve, args=(sock,), daemon=True).start()

    def _serve(self, sock: socket.socket) -> None:
        try:
            with sock, sock.makefile("rb") as lines:
                while (line := lines.readline()) not in (b"", b"\r\n"):
                    path = line.split()[1].decode()
                    headers = {}
                    while line := lines.readline().strip():
                        name, _, value = line.decode().partition(":")
                        headers[name.lower()] = value.strip()
                    body = json.loads(lines.read(int(headers["content-length"])))
                    self._answer(sock, path.removeprefix("/").replace("/", "."), body, headers)
        except (OSError, ValueError):
            pass

    def _answer(
        self, sock: socket.socket, request: str, body: dict[str, Any], headers: Mapping[str, str]
    ) -> None:
        self.asked.append((request, body))
        wanted = f"Basic {base64.b64encode(self.password.encode()).decode()}"
        if self.password and headers.get("authorization") != wanted:
            sock.sendall(b"HTTP/1.1 401 Unauthorized\r\nContent-Length: 0\r\n\r\n")
            return
        self.wait(request)
        known = wire.requests().get(request)
        document: dict[str, Any] = {
            "body": {},
            "msg": "",
            "ok": True,
            "type": known.answer if known else request,
        }
        try:
            made = self.answers[request]
            made = made(request, body) if callable(made) else made
        except KeyError:
            document.update(ok=False, msg="no such request")
        except Refused as refused:
            document.update(ok=False, msg=str(refused))
        else:
            if made is None:
                self.closing.wait(30.0)
                return
            if isinstance(made, bytes):
                sock.sendall(made)
                while made.endswith(b"chunked\r\n\r\n"):
                    self.closing.wait(self.pause)
                    sock.sendall(b"10000\r\n" + b" " * 0x10000 + b"\r\n")
                raise OSError("the connection ends here")
            document["body"] = made
        text = json.dumps(document).encode()
        sock.sendall(b"HTTP/1.1 200 OK\r\nContent-Length: %d\r\n\r\n%b" % (len(text), text))
