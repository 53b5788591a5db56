"""A served robot, and a page without a browser: an HTTP client and a client of the live connection."""

from __future__ import annotations

import http.client
import itertools
import json
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from rosproto import Node
from tests.support.websocket import connect
from woosh_pure import Chassis

LATEST = 10.0
"""Seconds to wait for a missing zero, to tell a late one from a lost one."""

__all__ = ["Answer", "PageClient", "Served", "Velocities", "serving"]


@dataclass(frozen=True)
class Answer:
    """An HTTP response."""

    status: int
    headers: dict[str, str]
    body: bytes

    @property
    def json(self) -> Any:
        return json.loads(self.body)

    @property
    def problem(self) -> str:
        """The sentence of a problem document; fails for other responses."""
        assert self.headers["content-type"] == "application/problem+json", self
        document = self.json
        assert document["status"] == self.status
        assert document["type"].startswith("urn:woosh:")
        return str(document["detail"])


class Served:
    """HTTP client of a server."""

    def __init__(self, port: int, token: str | None = None) -> None:
        self.port, self.token = port, token

    def ask(
        self,
        method: str,
        path: str,
        body: Any = None,
        *,
        headers: dict[str, str] | None = None,
        timeout: float = 30.0,
    ) -> Answer:
        """Send one request; a body other than bytes is sent as JSON."""
        sent = {"authorization": f"Bearer {self.token}"} if self.token else {}
        if body is not None and not isinstance(body, bytes):
            body, sent["content-type"] = json.dumps(body).encode(), "application/json"
        sent.update(headers or {})
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=timeout)
        try:
            connection.request(method, path if path.startswith("/") else f"/api/v1/{path}", body, sent)
            response = connection.getresponse()
            return Answer(response.status, {k.lower(): v for k, v in response.getheaders()}, response.read())
        finally:
            connection.close()

    def get(self, path: str, **more: Any) -> Answer:
        return self.ask("GET", path, **more)

    def post(self, path: str, body: Any = None, **more: Any) -> Answer:
        return self.ask("POST", path, body, **more)

    def delete(self, path: str, **more: Any) -> Answer:
        return self.ask("DELETE", path, **more)


@contextmanager
def serving(chassis: Chassis | dict[str, Chassis], **options: Any) -> Iterator[Served]:
    """Run a server on a free port of this computer."""
    from woosh_pure import web
    from woosh_pure.web.server import WebServer

    with WebServer(web.app(chassis, **options), port=0) as server:
        served = Served(server.port, options.get("token"))
        served.app, served.loop = server.app, lambda: server.loop  # type: ignore[attr-defined]
        yield served


class PageClient:
    """A page: acknowledges each frame, and drives the robot on request."""

    def __init__(self, port: int, path: str = "/api/v1/live", *, acks: bool = True, **options: Any) -> None:
        self._context = connect(
            f"{'wss' if 'ssl' in options else 'ws'}://127.0.0.1:{port}{path}",
            open_timeout=10,
            close_timeout=1,
            max_queue=None,
            **options,
        )
        self.socket = self._context.__enter__()
        self.heard: list[dict[str, Any]] = []
        self.frames: list[bytes] = []
        self.count = 0
        self.session = ""
        self.error: Exception | None = None
        self._acks = acks
        self._seq = itertools.count(1)
        self._condition = threading.Condition()
        self._let_go = threading.Event()
        self._beating: threading.Thread | None = None
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def __enter__(self) -> PageClient:
        return self

    def __exit__(self, *_: object) -> None:
        self._let_go.set()
        try:
            self._context.__exit__(None, None, None)
        except OSError:
            pass  # the connection was cut
        self._reader.join(5)

    def _read(self) -> None:
        try:
            for message in self.socket:
                self.count += 1
                if self._acks:
                    self.say(t="ack", n=self.count)
                with self._condition:
                    if isinstance(message, bytes):
                        self.frames.append(message)
                    else:
                        self.heard.append(json.loads(message))
                        self.session = self.heard[-1].get("session", self.session)
                    self._condition.notify_all()
        except Exception as error:
            self.error = error
        with self._condition:
            self._condition.notify_all()

    def say(self, **document: Any) -> None:
        self.socket.send(json.dumps(document))

    def wait(self, accept: Callable[[dict[str, Any]], Any], timeout: float = 10.0) -> dict[str, Any]:
        """The first received or future message that `accept` accepts."""
        until, seen = time.monotonic() + timeout, 0
        with self._condition:
            while True:
                for document in self.heard[seen:]:
                    if accept(document):
                        return document
                seen = len(self.heard)
                left = until - time.monotonic()
                assert left > 0, self._not_heard(timeout)
                self._condition.wait(left)

    def _not_heard(self, timeout: float) -> str:
        told = [d for d in self.heard if d["t"] in ("drive", "lease", "lost")][-12:]
        return f"not heard within {timeout} s; of the drive: {told}; last: {self.heard[-2:]}; {self.error!r}"

    def of(self, kind: str, **fields: Any) -> dict[str, Any]:
        """Wait for the first message of that kind with those fields."""
        return self.wait(lambda d: d["t"] == kind and all(d.get(k) == v for k, v in fields.items()))

    def frame(self, kind: int, timeout: float = 10.0) -> bytes:
        """Wait for the first binary frame of that kind."""
        until = time.monotonic() + timeout
        with self._condition:
            while True:
                for found in self.frames:
                    if found[0] == kind:
                        return found
                assert time.monotonic() < until, f"no frame of kind {kind} within {timeout} s"
                self._condition.wait(0.1)

    def forget(self) -> None:
        """Forget all received messages and frames."""
        with self._condition:
            self.heard.clear()
            self.frames.clear()

    def ready(self) -> None:
        """Acquire the lease and confirm the warning."""
        self.say(t="lease", op="ask")
        self.of("lease", yours=True)
        self.say(t="confirm")

    def press(self, vx: float = 0.2, wz: float = 0.0, **more: Any) -> None:
        self.say(t="press", **{"seq": next(self._seq), "at": time.monotonic(), "vx": vx, "wz": wz, **more})

    def beat(self, vx: float = 0.2, wz: float = 0.0, **more: Any) -> None:
        self.say(t="beat", **{"seq": next(self._seq), "at": time.monotonic(), "vx": vx, "wz": wz, **more})

    def hold(self, vx: float = 0.2, wz: float = 0.0) -> None:
        """Press, and send heartbeats ten times a second until `let_go` or the end of the connection."""
        self._let_go = threading.Event()
        self.press(vx, wz)

        def beating(let_go: threading.Event) -> None:
            while not let_go.wait(0.1):
                try:
                    self.beat(vx, wz)
                except Exception:
                    return

        self._beating = threading.Thread(target=beating, args=(self._let_go,), daemon=True)
        self._beating.start()

    def drive(self, vx: float = 0.2, state: str = "driving") -> dict[str, Any]:
        """Hold until the robot is driven, or the press is accepted ("opening"); return the server's message. Releases and
        presses again if the server ends the drive first, which may happen on a busy computer.
        """
        said: dict[str, Any] = {}
        for _ in range(20):
            self.forget()
            self.hold(vx)
            said = self._came_of_press(state)
            if said["state"] == state:
                return said
            assert said["reason"] not in ("not allowed", "no lease", "not confirmed", "stopped"), said
            self.let_go()
            time.sleep(0.2)
        raise AssertionError(f"never {state}: {said}")

    def _came_of_press(self, state: str) -> dict[str, Any]:
        """The server's message after it accepted the press; earlier ones may belong to the previous press."""
        opening = False

        def accept(document: dict[str, Any]) -> bool:
            nonlocal opening
            if document["t"] != "drive":
                return False
            if document["state"] == "opening":
                opening = True
                return state == "opening"
            return opening or document["state"] == "refused"

        return self.wait(accept, 30.0)

    def stop_beating(self) -> None:
        self._let_go.set()
        if self._beating is not None:
            self._beating.join(5)

    def let_go(self) -> None:
        self.stop_beating()
        self.say(t="release")


class Velocities:
    """Records the velocities sent to the robot, with their times, on a separate node."""

    def __init__(self, master_uri: str) -> None:
        self.node = Node("velocity_witness", master_uri=master_uri, anonymous=True)
        self.heard: list[tuple[float, float, float]] = []
        self._condition = threading.Condition()
        self.subscriber = self.node.subscriber(
            "/smooth_cmd_vel", "geometry_msgs/Twist", callback=self._take, queue_size=1000
        )

    def __enter__(self) -> Velocities:
        return self

    def __exit__(self, *_: object) -> None:
        self.node.close()

    def _take(self, message: Any) -> None:
        with self._condition:
            self.heard.append((time.monotonic(), message.linear.x, message.angular.z))
            self._condition.notify_all()

    def moves(self, since: float) -> bool:
        """True if a velocity of at least 0.05 m/s comes within three seconds."""
        try:
            self.wait_moving(since, timeout=3.0)
        except AssertionError:
            return False
        return True

    def wait_moving(self, since: float, least: float = 0.05, timeout: float = 20.0) -> None:
        """Wait for a velocity of at least `least` m/s."""
        until = time.monotonic() + timeout
        with self._condition:
            while not any(at > since and abs(vx) >= least for at, vx, _ in self.heard):
                assert time.monotonic() < until, f"never told to move; last: {self.heard[-3:]}"
                self._condition.wait(0.1)

    def seconds_to_zero(self, since: float, watch: float = 1.0) -> float:
        """Seconds from `since` to the zero that no other velocity follows for `watch` s; infinite without one.

        0.0 if the robot had already stopped: on a busy computer the heartbeats may pause before the connection is cut.
        """
        time.sleep(max(0.0, since + watch - time.monotonic()))
        with self._condition:
            self._condition.wait_for(lambda: self._to_zero(since) < float("inf"), LATEST)
            return self._to_zero(since)

    def _to_zero(self, since: float) -> float:
        after = [(at, vx, wz) for at, vx, wz in self.heard if at >= since]
        moving = [at for at, vx, wz in after if vx or wz]
        if not moving and self.heard and not any(self.heard[-1][1:]):
            return max(0.0, self.heard[-1][0] - since) if not after else after[0][0] - since
        zeros = [at for at, vx, wz in after if not (vx or wz) and at > max(moving, default=since)]
        return zeros[0] - since if zeros else float("inf")
