"""One table of attempts to get in (token, Host, Origin, rate, half-open connections), tried at every door over sockets.

The doors are the REST API, the log-in of the page, its live connection, the rosbridge server, the Foxglove
server, and requests by POST on the port of a gateway. A new door belongs into DOORS.
"""

from __future__ import annotations

import base64
import json
import socket
import struct
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, closing, contextmanager
from http import HTTPStatus
from typing import Any, NamedTuple

import pytest

pytest.importorskip("fastapi", reason="needs the extra `web`")
pytest.importorskip("uvicorn", reason="needs the extra `web`")
pytest.importorskip("websockets", reason="needs the extras `web` and `bridge`")

from rosproto import Master, Node
from rosproto.gateway import (
    ClientChannel,
    Foxglove,
    GatewayLimits,
    HandshakeRules,
    Rosbridge,
    WebSocketServer,
)
from tests.support.robot_pool import RobotPool
from woosh_pure import Chassis, web
from woosh_pure.web.server import WebServer

TOKEN, NAME, PAGE = "kd83-hsa2-pq", "robot.test", "https://studio.example"
LET_IN = 200
Headers = dict[str, "str | list[str]"]


def web_server(chassis: Chassis, node: Node, **options: Any) -> AbstractContextManager[Any]:
    bind = options.pop("host", "127.0.0.1")
    return WebServer(web.app(chassis, **options), bind=bind, port=0)


def rosbridge(chassis: Chassis, node: Node, **options: Any) -> AbstractContextManager[Any]:
    return Rosbridge(node, port=0, **options)


def foxglove(chassis: Chassis, node: Node, **options: Any) -> AbstractContextManager[Any]:
    return Foxglove(node, port=0, **options)


class Yes:
    """A gateway's answer to each POST."""

    async def answer(self, path: str, data: bytes, address: str) -> tuple[HTTPStatus, str]:
        return HTTPStatus.OK, "{}"

    def refused(self, why: str) -> str:
        return json.dumps(why)


def posts(
    chassis: Chassis, node: Node, host: str = "127.0.0.1", limits: GatewayLimits | None = None, **rules: Any
) -> AbstractContextManager[Any]:
    """The server below the gateways as the Robot API has it, with the rules that it gets."""
    serve = WebSocketServer(Idle, HandshakeRules(host, **rules), limits=limits, name="robot-api", posts=Yes())
    return closing(serve)


class Idle:
    """A client by WebSocket of whom nothing is read."""

    max_message_bytes = 0

    def __init__(self, channel: ClientChannel) -> None: ...

    async def received(self, data: str | bytes) -> None: ...

    def ended(self) -> None: ...


def lines(method: str, path: str, headers: Headers, body: bytes = b"") -> bytes:
    """A request."""
    parts = [f"{method} {path} HTTP/1.1"]
    for name, values in headers.items():
        parts += [f"{name}: {value}" for value in ([values] if isinstance(values, str) else values)]
    return "\r\n".join([*parts, "", ""]).encode() + body


def bearer(token: str | None) -> Headers:
    return {} if token is None else {"Authorization": f"Bearer {token}"}


def rest(token: str | None, headers: Headers) -> bytes:
    return lines("POST", "/api/v1/lease", {**bearer(token), "Content-Length": "0", **headers})


def log_in(token: str | None, headers: Headers) -> bytes:
    body = json.dumps({"token": token}).encode() if token is not None else b""
    usual = {"Content-Length": str(len(body)), "Content-Type": "application/json"}
    return lines("POST", "/api/v1/login", {**usual, **headers}, body)


def upgrade(path: str, token: str | None, headers: Headers, **more: str) -> bytes:
    usual = {
        "Upgrade": "websocket",
        "Connection": "Upgrade",
        "Sec-WebSocket-Key": base64.b64encode(b"0123456789abcdef").decode(),
        "Sec-WebSocket-Version": "13",
        **more,
    }
    return lines("GET", path, {**bearer(token), **usual, **headers})


def live(token: str | None, headers: Headers) -> bytes:
    return upgrade("/api/v1/live", token, headers)


def socket_of_gateway(token: str | None, headers: Headers) -> bytes:
    path = "/" if token is None else f"/?token={token}"
    return upgrade(path, None, headers, **{"Sec-WebSocket-Protocol": "foxglove.sdk.v1"})


def post(token: str | None, headers: Headers) -> bytes:
    usual = {"Content-Length": "2", "Content-Type": "application/json"}
    return lines("POST", "/woosh/robot/Mode", {**bearer(token), **usual, **headers}, b"{}")


class Door(NamedTuple):
    """A server, a request to it, and the statuses that differ from the table."""

    server: Callable[..., AbstractContextManager[Any]]
    request: Callable[[str | None, Headers], bytes]
    statuses: dict[int, int] = {}  # noqa: RUF012 - never changed


DOORS = {
    "REST": Door(web_server, rest),
    # Without a token there is nothing to log in with, and the page is what any visitor sees.
    "log-in of the page": Door(web_server, log_in),
    # uvicorn answers a handshake that is not accepted with 403, whatever the reason.
    "live connection": Door(web_server, live, {421: 403}),
    "rosbridge": Door(rosbridge, socket_of_gateway),
    "Foxglove": Door(foxglove, socket_of_gateway),
    # Two headers of one name are read as one of both values.
    "POST": Door(posts, post, {400: 403}),
}


class Attempt(NamedTuple):
    status: int
    token: str | None = TOKEN
    headers: Headers = {}  # noqa: RUF012 - never changed


ATTEMPTS = {
    "the token": Attempt(LET_IN),
    "no token": Attempt(401, token=None),
    "a wrong token": Attempt(401, token="kd83-hsa2-pr"),
    "the beginning of the token": Attempt(401, token=TOKEN[:-1]),
    "the token in capitals": Attempt(401, token=TOKEN.upper()),
    "by the name localhost": Attempt(LET_IN, headers={"Host": "localhost:{port}"}),
    "by another address of this server": Attempt(LET_IN, headers={"Host": "10.0.0.7:8080"}),
    "by a name that was given": Attempt(LET_IN, headers={"Host": f"{NAME}:{{port}}"}),
    "by a foreign name": Attempt(421, headers={"Host": "evil.example:{port}"}),
    "by a name that begins like ours": Attempt(421, headers={"Host": f"{NAME}.evil.example"}),
    "by a name that looks like an address": Attempt(421, headers={"Host": "127.0.0.1.evil.example"}),
    "from a page of this server": Attempt(LET_IN, headers={"Origin": "http://127.0.0.1:{port}"}),
    "from a page that was named": Attempt(LET_IN, headers={"Origin": PAGE}),
    "from a foreign page": Attempt(403, headers={"Origin": "http://evil.example"}),
    "from another server of this computer": Attempt(403, headers={"Origin": "http://localhost:3000"}),
    "from another server of this address": Attempt(403, headers={"Origin": "http://127.0.0.1:3000"}),
    "from this server by another scheme": Attempt(403, headers={"Origin": "https://127.0.0.1:{port}"}),
    "from the named page by another scheme": Attempt(403, headers={"Origin": "http://studio.example"}),
    "from a page without an origin": Attempt(403, headers={"Origin": "null"}),
    "from two pages": Attempt(400, headers={"Origin": [PAGE, "http://evil.example"]}),
}


def status_of(port: int, request: bytes, address: str = "127.0.0.1") -> int:
    """The status of the answer; that of a WebSocket which is closed at once, by its code."""
    with socket.create_connection(("127.0.0.1", port), 20, (address, 0)) as sock:
        sock.sendall(request)
        answer = sock.makefile("rb")
        status = int(answer.readline().split()[1])
        while answer.readline().strip():
            pass
        if status != 101 or b"/api/v1/live" not in request:
            return LET_IN if status in (101, 201) else status
        opcode, length = answer.read(2)
        code = struct.unpack(">H", answer.read(2))[0] if opcode == 0x88 and length >= 2 else 0
        return code - 4000 if code else LET_IN


def tried(door: Door, port: int, attempt: Attempt, address: str = "127.0.0.1") -> int:
    """The status that an attempt gets."""
    headers: Headers = {"Host": "127.0.0.1:{port}", **attempt.headers}
    filled: Headers = {
        name: values.format(port=port) if isinstance(values, str) else values
        for name, values in headers.items()
    }
    return status_of(port, door.request(attempt.token, filled), address)


@pytest.fixture(scope="module")
def graph() -> Iterator[tuple[Chassis, Node]]:
    """A chassis, and a node for the gateways."""
    with RobotPool(full_graph=False) as pool, Master() as master:
        robot = pool.take(8.0)
        with Chassis(robot.sim.master_uri) as chassis, Node("/gateway", master_uri=master.uri) as node:
            yield chassis, node
        pool.give_back(robot)


@pytest.fixture(scope="module")
def served(graph: tuple[Chassis, Node]) -> Iterator[Callable[[Door], int]]:
    """The port of a door's server, one for all attempts."""
    with ExitStack() as stack:
        ports: dict[Any, int] = {}

        def port_of(door: Door) -> int:
            if door.server not in ports:
                server = door.server(*graph, token=TOKEN, hosts=[NAME], origins=[PAGE])
                ports[door.server] = stack.enter_context(server).port
            return ports[door.server]

        yield port_of


@contextmanager
def fresh(door: Door, graph: tuple[Chassis, Node], **options: Any) -> Iterator[int]:
    """The port of a server that nobody has tried yet."""
    with door.server(*graph, token=TOKEN, **options) as server:
        yield server.port


every_door = pytest.mark.parametrize("door", [pytest.param(door, id=name) for name, door in DOORS.items()])


@pytest.mark.promise(
    "admit clients by the same rules",
    "is refused by its `Origin`",
    "Other servers of this computer are other sites",
)
@every_door
@pytest.mark.parametrize("attempt", [pytest.param(one, id=name) for name, one in ATTEMPTS.items()])
def test_every_door_answers_an_attempt_alike(
    served: Callable[[Door], int], door: Door, attempt: Attempt
) -> None:
    if attempt.token is None and door.request is log_in:
        attempt = attempt._replace(status=422)  # a log-in without its body
    assert tried(door, served(door), attempt) == door.statuses.get(attempt.status, attempt.status)


@pytest.mark.promise("answered ten times, then once every six seconds")
@every_door
def test_the_eleventh_wrong_token_of_an_address_is_one_too_many(
    graph: tuple[Chassis, Node], door: Door
) -> None:
    """Whoever has the token is still let in, and so is another address that mistypes it."""
    wrong = Attempt(401, token="not-the-token")
    with fresh(door, graph) as port:
        assert [tried(door, port, wrong) for _ in range(12)] == [401] * 10 + [429] * 2
        assert tried(door, port, Attempt(LET_IN)) == LET_IN
        if sys.platform == "linux":  # which has all of 127.0.0.0/8
            assert tried(door, port, wrong, "127.0.0.2") == 401


@pytest.mark.promise("So one address locks nobody else out")
@every_door
@pytest.mark.parametrize("sent", [b"", b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n"], ids=["nothing", "half"])
def test_half_open_connections_lock_nobody_out(graph: tuple[Chassis, Node], door: Door, sent: bytes) -> None:
    """More than the server keeps, from one address: it gives up the oldest of that address, not a new one."""
    with fresh(door, graph) as port, ExitStack() as stack:
        crowd = []
        for _ in range(300):
            crowd.append(stack.enter_context(socket.create_connection(("127.0.0.1", port), 20)))
            crowd[-1].sendall(sent)
        began = time.monotonic()
        assert tried(door, port, Attempt(LET_IN)) == LET_IN
        if sys.platform == "linux":
            assert tried(door, port, Attempt(LET_IN), "127.0.0.2") == LET_IN
        assert time.monotonic() - began < 10.0, "not by waiting until the others had run out of time"
        crowd[0].settimeout(20)
        try:
            assert crowd[0].recv(100) == b""
        except ConnectionError:
            pass


@pytest.mark.promise("A token has at least 8 characters")
@every_door
@pytest.mark.parametrize("token", ["", "a", "kd83-hs"])
def test_a_token_that_can_be_guessed_opens_no_door(
    graph: tuple[Chassis, Node], door: Door, token: str
) -> None:
    with pytest.raises(ValueError, match=rf"too short \(length {len(token)}\); use at least 8 random"):
        door.server(*graph, token=token)


@pytest.mark.promise("on another address it does not start without a token")
@every_door
@pytest.mark.parametrize("host", ["0.0.0.0", "::"])
def test_no_door_is_open_to_other_computers_without_a_token(
    graph: tuple[Chassis, Node], door: Door, host: str
) -> None:
    with pytest.raises(ValueError, match="--token-file"):
        door.server(*graph, host=host)
