"""A server that speaks what the page listens to, without a robot: it can lose the robot, be silent, refuse.

The page's tests of what a real server does rarely run against it; all else runs against `woosh --sim web`.
"""

from __future__ import annotations

import asyncio
import io
import json
import math
import struct
import threading
import time
from pathlib import Path
from typing import Any

import uvicorn
from fastapi import FastAPI, Request, WebSocket, WebSocketDisconnect
from fastapi.responses import FileResponse, JSONResponse, Response
from PIL import Image, ImageDraw

from woosh_pure.missions import KINDS, STEP_KEYS
from woosh_pure.web.snapshot import plain

PAGE = Path(__file__).parents[2] / "woosh_pure" / "web" / "page"
CSP = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob:; connect-src 'self'; "
    "form-action 'none'; frame-ancestors 'none'; base-uri 'none'"
)
MARKS: list[dict[str, Any]] = [
    {"name": "A1", "x": 3.0, "y": 1.0, "yaw": 1.57, "charger": False, "note": "shelf"},
    {"name": "B1", "x": -2.0, "y": 2.0, "yaw": 0.0, "charger": False, "note": ""},
    {"name": "C1", "x": -3.0, "y": -2.0, "yaw": 0.0, "charger": True, "note": ""},
    {"name": "D9", "x": None, "y": None, "yaw": None, "charger": False, "note": ""},
]


def map_png() -> bytes:
    image = Image.new("L", (240, 180), 205)
    draw = ImageDraw.Draw(image)
    draw.rectangle((10, 10, 229, 169), fill=254, outline=0, width=3)
    draw.rectangle((100, 40, 110, 110), fill=0)
    draw.rectangle((170, 110, 200, 116), fill=0)
    out = io.BytesIO()
    image.save(out, "PNG")
    return out.getvalue()


def jpeg() -> bytes:
    image = Image.effect_noise((320, 240), 40).convert("RGB")
    out = io.BytesIO()
    image.save(out, "JPEG")
    return out.getvalue()


def mission_file(file: str, name: str) -> dict[str, Any]:
    """A round with a question, as GET missions has it."""
    steps: list[dict[str, Any]] = [
        {"do": "go_to_mark", "mark": "$shelf", "name": "there", "retries": 2},
        {"do": "ask", "text": "Is it loaded?", "answers": {"Yes": "next", "No": "there"}},
        {"do": "wait", "seconds": 5},
    ]
    mission = {"mission": 1, "name": name, "description": name, "parameters": {"shelf": "A1"}, "step": steps}
    return {"file": file, "problem": None, "mission": mission}


def mission_run(state: str, **more: Any) -> dict[str, Any]:
    """A run of that round at its question, as GET mission-runs has it."""
    steps = [
        {"do": "go_to_mark", "values": {"mark": "A1"}, "state": "done"},
        {"do": "ask", "values": {"text": "Is it loaded?"}, "state": ""},
    ]
    question = {
        "text": "Is it loaded?",
        "answers": ["Yes", "No"],
        "default": "",
        "unknown": False,
        "seconds_left": None,
    }
    return {
        "id": "7", "mission": "Delivery", "who": "page 1", "state": state, "done": False, "step": 1, "steps": steps,
        "question": question if state == "asking" else None, "said": None, **more,
    }  # fmt: skip


class Fake:
    """What the robot is, and what the tests look at afterwards."""

    def __init__(self, *, allow_driving: bool = True) -> None:
        self.allow_driving = allow_driving
        self.pose = [0.0, 0.0, 0.4]
        self.lost: float | None = None
        self.silent = False
        self.stands: bool | None = True
        self.moves = True
        self.stop_delay = 0.0
        self.deaf = False  # to a stop over the live connection
        self.knows_session = True
        self.ready: dict[str, Any] = {"answer": "yes", "text": "", "reasons": []}
        self.faults: dict[str, Any] = {"known": True, "present": False, "text": "", "active": []}
        self.robots = ["woosh-42"]
        self.robot_state, self.charging, self.percent = "IDLE", False, 76
        self.needs_token = False
        self.takes_pose: bool | None = True  # None: it says nothing more
        self.goals: list[dict[str, Any]] = []
        self.recordings: list[dict[str, Any]] = []
        self.runs: list[dict[str, Any]] = []
        self.missions = [mission_file("round", "Delivery")]
        self.driver: str | None = None
        self.drive: dict[str, Any] = {"state": "driving"}  # answer to a press
        self.calls: list[tuple[str, str, Any]] = []
        self.heard: list[dict[str, Any]] = []
        self.looks: dict[str, Any] = {}
        self.holder: str | None = None
        self.asking: list[str] = []
        self.viewers = 0
        self.sockets: list[WebSocket] = []
        self._tasks: list[asyncio.Future[None]] = []
        self.app = self._make()

    def lease_for(self, you: str) -> dict[str, Any]:
        return {
            "t": "lease", "holder": self.holder, "seconds": 60.0, "asking": self.asking, "you": you,
            "yours": self.holder == you,
        }  # fmt: skip

    def state(self) -> dict[str, Any]:
        status = {
            "robot_state": self.robot_state,
            "robot_mode": "AUTOMATIC",
            "work_mode": "TASK",
            "task": {"id": 0},
        }
        battery = {"percent": self.percent, "charging": self.charging, "voltage": 48.2, "current": -3.1}
        ages = dict.fromkeys(("pose", "velocity", "battery", "scan", "status", "odometer"), 0.1)
        if self.takes_pose is None:
            ages["pose"] = 99.0
        return {
            "t": "state", "status": status, "battery": battery, "odometer": 1234.5,
            "velocity": {"vx": self.moves * 0.2 * math.sin(time.time()), "vy": 0.0, "wz": self.moves * 0.1},
            "readiness": self.ready, "faults": self.faults, "goals": self.goals, "recordings": self.recordings,
            "missions": {"paused": False, "problem": None, "runs": self.runs},
            "activity": "driven" if self.driver else self.robot_state.lower().replace("_", " "),
            "rates": {"pose": 19.8, "scan": 9.9}, "ages": ages,
        }  # fmt: skip

    def report(self) -> dict[str, Any]:
        text = "the robot stands still; cancelled pick task 1286666406 to A1; not done: registerPublisher"
        problems = [] if self.stands else ["registerPublisher: no answer"]
        return {
            "stands_still": self.stands, "text": text, "cancelled": ["pick task 1286666406 to A1"],
            "problems": problems, "pending": problems, "looked": True,
        }  # fmt: skip

    async def _stop(self, socket: WebSocket, number: int) -> None:
        self.calls.append(("live", "stop", None))
        await socket.send_text(json.dumps({"t": "stop", "n": number, "state": "begun"}))
        await asyncio.sleep(self.stop_delay)
        await socket.send_text(json.dumps({"t": "stop", "n": number, "state": "done", **self.report()}))

    def scan(self) -> bytes:
        x, y, yaw = self.pose
        ranges = []
        for i in range(360):
            angle = yaw + math.radians(i - 180)
            c, s = math.cos(angle), math.sin(angle)
            wall = min(
                (5.4 - x) / c if c > 1e-9 else (-5.4 - x) / c if c < -1e-9 else 9e9,
                (3.9 - y) / s if s > 1e-9 else (-3.9 - y) / s if s < -1e-9 else 9e9,
            )
            ranges.append(int(100 * wall))
        head = struct.pack("<BBH5f", 1, 0, 360, x, y, yaw, -math.pi, math.radians(1))
        return head + struct.pack("<360H", *ranges)

    def _make(self) -> FastAPI:
        app = FastAPI()

        @app.middleware("http")
        async def policy(request: Request, call_next: Any) -> Any:
            answer = await call_next(request)
            answer.headers["Content-Security-Policy"] = CSP
            return answer

        @app.get("/")
        def index() -> FileResponse:
            return FileResponse(PAGE / "index.html")

        @app.get("/api/v1/map.png")
        def picture() -> Response:
            return Response(map_png(), media_type="image/png")

        @app.get("/api/v1/missions")
        def missions() -> dict[str, Any]:
            kinds = {name: plain(keys) for name, keys in KINDS.items()}
            return {"missions": self.missions, "kinds": kinds, "common": plain(STEP_KEYS)}

        @app.get("/api/v1/status")
        def status() -> JSONResponse:
            return JSONResponse({}, 401 if self.needs_token else 200)

        @app.post("/api/v1/stop")
        async def stop(request: Request) -> Any:
            mode = request.headers.get("sec-fetch-mode", "")
            way = "beacon" if mode == "no-cors" else "POST"
            if "x-woosh-session" in request.headers and not self.knows_session:
                self.calls.append(("refused", "stop", None))
                return JSONResponse({"detail": "this session is over"}, 403)
            self.calls.append((way, "stop", None))
            await asyncio.sleep(self.stop_delay)
            return self.report()

        @app.api_route("/api/v1/{path:path}", methods=["POST", "PUT", "DELETE"])
        async def other(path: str, request: Request) -> Any:
            text = await request.body()
            body = json.loads(text) if text else None
            self.calls.append((request.method, path, body))
            if path == "goals" and str(body.get("mark")).startswith("D9"):
                problem = {"title": "refused", "detail": "the chassis knows no mark 'D9'"}
                return JSONResponse(problem, 409, media_type="application/problem+json")
            if path == "goals":
                goal = {
                    "id": str(len(self.goals) + 1), "kind": body["kind"], "who": "page 1",
                    "key": body["kind"], "values": body, "start": {"x": 0.0, "y": 0.0}, "target": None,
                    "description": f"pick task 1286666406 to {body.get('mark')}", "state": "running", "done": False,
                    "arrived": None, "percent": 40.0, "progress": "1.9 m left", "text": "", "can_pause": True,
                }  # fmt: skip
                self.goals.append(goal)
                return JSONResponse(goal, 201)
            if path == "pose" and self.takes_pose:
                self.pose = [body["x"], body["y"], body["yaw"]]
            return {}

        @app.websocket("/api/v1/live")
        async def live(socket: WebSocket) -> None:
            await socket.accept()
            if self.needs_token:
                await socket.close(4401)
                return
            self.viewers += 1
            you = f"page {self.viewers}"
            self.sockets.append(socket)
            sending = asyncio.ensure_future(self._send(socket, you))
            try:
                while True:
                    await self._hear(json.loads(await socket.receive_text()), socket, you)
            except (WebSocketDisconnect, RuntimeError):
                pass
            finally:
                sending.cancel()
                self.sockets.remove(socket)

        @app.get("/{path:path}")
        def files(path: str) -> Response:
            found = (PAGE / path).resolve()
            if not found.is_relative_to(PAGE) or not found.is_file():
                return Response(status_code=404)
            return FileResponse(found)

        return app

    async def _hear(self, message: dict[str, Any], socket: WebSocket, you: str) -> None:
        if message["t"] == "ack":
            return
        self.heard.append({**message, "time": time.monotonic(), "you": you})
        if message["t"] == "look":
            self.looks = message
        elif message["t"] == "lease":
            if message["op"] == "ask" and self.holder in (None, you):
                self.holder = you
            elif message["op"] == "ask":
                self.asking.append(you)
            elif message["op"] == "give" and self.holder == you:
                self.holder = None
            elif message["op"] == "grant":
                self.holder, self.asking = message["to"], []
            elif message["op"] == "keep":
                self.asking = []
        elif message["t"] == "stop" and not self.deaf:
            self._tasks.append(asyncio.ensure_future(self._stop(socket, message["n"])))
        elif message["t"] == "press":
            await socket.send_text(json.dumps({"t": "drive", **self.drive}))

    async def _send(self, socket: WebSocket, you: str) -> None:
        limits = {"vx": 0.3, "wz": 0.5}
        hello = {
            "t": "hello", "robot": self.robots[0], "robots": self.robots, "session": you, "you": you,
            "allow_driving": self.allow_driving, "limits": limits, "simulator": {"speed": 1.0},
        }  # fmt: skip
        map_facts = {
            "width": 240,
            "height": 180,
            "resolution": 0.05,
            "origin": {"x": -6, "y": -4.5, "yaw": 0},
        }
        entry = {
            "id": 1,
            "at": time.time(),
            "who": "page 1",
            "what": "go to A1",
            "key": "mark",
            "values": {"mark": "A1"},
            "state": "arrived",
            "text": "",
        }
        first = [
            hello, {"t": "map", "version": "1", **map_facts}, {"t": "marks", "marks": MARKS},
            {"t": "journal", "entries": [entry]},
        ]  # fmt: skip
        for message in first:
            await socket.send_text(json.dumps(message))
        count = 0
        while True:
            await asyncio.sleep(0.05)
            if self.silent:
                continue
            count += 1
            if self.lost is not None:
                since = time.monotonic() - self.lost
                text = "nothing was heard of the robot"
                await socket.send_text(json.dumps({"t": "lost", "text": text, "since": since}))
                continue
            x, y, yaw = self.pose
            texts = [{"t": "pose", "x": x, "y": y, "yaw": yaw, "age": 0.02}]
            if self.takes_pose is None:
                texts = []
            if count % 10 == 1:
                texts += [self.state(), self.lease_for(you), {"t": "lost", "text": None, "since": 0}]
                texts.append({"t": "plan", "points": [[x, y], [1.5, 0.5], [3, 1]] if self.goals else []})
            for message in texts:
                await socket.send_text(json.dumps(message))
            if count % 2 == 0:
                await socket.send_bytes(self.scan())
            if self.looks.get("camera") and count % 4 == 0:
                await socket.send_bytes(bytes((2, 0 if self.looks["camera"] == "color" else 1)) + jpeg())


class Served:
    """A fake on a port of its own, until the end of the block."""

    def __init__(self, fake: Fake) -> None:
        self.fake = fake
        config = uvicorn.Config(
            fake.app, host="127.0.0.1", port=0, log_level="warning", ws="websockets-sansio"
        )
        self._server = uvicorn.Server(config)
        self._thread = threading.Thread(target=self._server.run, daemon=True)

    def __enter__(self) -> Served:
        self._thread.start()
        deadline = time.monotonic() + 20.0
        while not self._server.started:
            if time.monotonic() > deadline:
                raise TimeoutError("the fake server did not start within 20 s")
            time.sleep(0.02)
        return self

    def __exit__(self, *_: object) -> None:
        self._server.force_exit = True
        self._server.should_exit = True
        self._thread.join(10.0)

    @property
    def url(self) -> str:
        port = self._server.servers[0].sockets[0].getsockname()[1]
        return f"http://127.0.0.1:{port}/"
