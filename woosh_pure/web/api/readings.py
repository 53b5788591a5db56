"""The routes that read: the state, feeds and their streams, the map, the cameras."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable
from functools import partial
from typing import Literal

import numpy as np
from fastapi import APIRouter, Depends, Query, Request, Response
from starlette.concurrency import run_in_threadpool
from starlette.types import Receive, Scope, Send

from rosproto.errors import RosError, RosTimeout
from rosproto.logs import get_logger
from rosproto.numeric import encode_png
from rosproto.sentence import say
from woosh_pure import interface
from woosh_pure.feed.feed import PICTURES
from woosh_pure.feed.feed import Feed as ChassisFeed
from woosh_pure.maps.gridmap import grid_from_message
from woosh_pure.web import models
from woosh_pure.web.api.dependencies import (
    PROBLEMS,
    check_command,
    connected,
    context_of,
    problems,
    robot_of,
)
from woosh_pure.web.camera import COSTMAP, jpeg_of
from woosh_pure.web.context import WebContext
from woosh_pure.web.goals import command
from woosh_pure.web.http_errors import Problem, worded
from woosh_pure.web.live import robot_state
from woosh_pure.web.missions import RobotMissions
from woosh_pure.web.robot_site import FIRST_SECONDS
from woosh_pure.web.snapshot import ages, faults_part, plain, pose_part, readiness_part, text_of

# -- the state, the journal, and the robots of this server --------------------------------------------

_ASKS_ROBOT = [Depends(connected)]
state = APIRouter(tags=["state"], responses=PROBLEMS, dependencies=_ASKS_ROBOT)
journal, robots = APIRouter(tags=["state"], responses=PROBLEMS), APIRouter(tags=["robots"])


@state.get("/status", response_model=models.Status)
def get_status(request: Request) -> dict[str, object]:
    """The state in brief."""
    robot = robot_of(request)
    robot.listen()
    chassis, readiness = robot.chassis, robot.chassis.readiness()
    status, battery, pose = chassis.status.known, chassis.battery.known, chassis.pose.known
    known = [age for age in ages(robot.readings()).values() if age is not None]
    document: dict[str, object] = {
        "robot": robot.name,
        "state": None if status is None else status.value.robot_state.name,
        "activity": robot_state.activity(robot),
        "battery_percent": None if battery is None else battery.value.percent,
        "pose": None if pose is None else pose_part(pose.value),
        "ready": readiness.answer.value,
        "text": say(str(readiness)),
        "age": min(known, default=None),
    }
    return worded(document, request.headers)


@state.get("/snapshot", response_model=models.Snapshot)
def get_snapshot(request: Request) -> dict[str, object]:
    """The whole state at once, with the age of each part."""
    return worded(robot_state.snapshot(robot_of(request)), request.headers)


@state.get("/readiness", response_model=models.Readiness)
def get_readiness(request: Request) -> dict[str, object]:
    """Whether the robot would move now, and if not, why."""
    return worded(readiness_part(robot_of(request).chassis.readiness()), request.headers)


@state.get("/faults", response_model=models.Faults)
def get_faults(request: Request) -> dict[str, object]:
    """The faults that are active now."""
    return worded(faults_part(robot_of(request).chassis.faults), request.headers)


@journal.get("/journal", response_model=list[models.Entry])
def get_journal(request: Request) -> list[dict[str, object]]:
    """What was done, by whom, and how it ended; the oldest first."""
    robot = robot_of(request)
    robot.missions.note_runs()
    return worded([entry.model_dump() for entry in robot.journal.entries()], request.headers)


@robots.get("/robots", response_model=list[models.RobotEntry])
def list_robots(request: Request) -> list[dict[str, object]]:
    """The robots of this server. Paths without a robot's name mean the first one."""
    root = str(request.scope.get("root_path", ""))
    return [
        {"name": name, "page": f"{root}/robots/{name}/", "api": f"{root}/api/v1/robots/{name}/"}
        for name in context_of(request).robots
    ]


_logger = get_logger("woosh_pure.web")
# -- feeds: the newest value of one, and its stream of Server-Sent Events ------------------------------------

feeds = APIRouter(tags=["feeds"], responses=PROBLEMS, dependencies=_ASKS_ROBOT)
MAX_STREAMS, STUCK_SECONDS, BEAT_SECONDS, LOOK_SECONDS = 32, 10.0, 5.0, 0.25
EVENTS: dict[int | str, dict[str, object]] = {
    200: {
        "content": {"text/event-stream": {}},
        "description": "one event for each new value, as GET returns it",
    }
}


@feeds.get("/feeds", response_model=list[models.Feed])
def list_feeds() -> list[dict[str, object]]:
    """The feeds that can be read here. Camera pictures have their own addresses."""
    return [
        {
            "name": row.feed,
            "topic": row.name,
            "type": row.type,
            "meaning": row.meaning,
            "unit": row.unit,
            "on_change": row.on_change,
        }
        for row in interface.feeds()
        if row.type not in PICTURES
    ]


def _feed(name: str, request: Request) -> ChassisFeed[object]:
    row = interface.find(name)
    if row.type in PICTURES:
        text = "{name} is too large for this; see camera/color.jpg and camera/depth.png"
        raise Problem(415, text, "picture", name=name)
    return robot_of(request).feed(name)


def _value(name: str, feed: ChassisFeed[object]) -> dict[str, object]:
    reading = feed.known
    if reading is None:
        return {"name": name, "value": None, "age": None, "stamp": None}
    age = round(reading.age, 3)
    return {"name": name, "value": plain(reading.value), "age": age, "stamp": reading.stamp}


@feeds.get("/feeds/{feed}", response_model=models.FeedValue, responses=problems(415))
def get_feed(feed: str, request: Request) -> dict[str, object]:
    """The newest value of a feed; null if nothing was heard yet."""
    found = _feed(feed, request)
    found.connect()
    return _value(feed, found)


@feeds.get("/feeds/{feed}/stream", response_class=Response, responses={**EVENTS, **problems(415)})
def stream_feed(
    feed: str, request: Request, rate: float = Query(10.0, gt=0.0, le=20.0, description="events a second")
) -> Response:
    """New values as Server-Sent Events. A slow reader gets fewer of them, and always the newest."""
    found = _feed(feed, request)
    found.open()
    return EventStream(context_of(request), feed, found, partial(_value, feed, found), rate)


class EventStream(Response):
    """A stream of the documents of a feed, or of the missions. It ends if the reader accepts nothing for ten
    seconds.
    """

    media_type = "text/event-stream"

    def __init__(
        self,
        context: WebContext,
        name: str,
        feed: ChassisFeed[object] | RobotMissions,
        document: Callable[[], object],
        rate: float,
    ) -> None:
        super().__init__()
        del self.headers["content-length"]
        self._context, self._name, self._feed, self._rate = context, name, feed, rate
        self._document = document

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if self._context.streams >= MAX_STREAMS:  # here, where it is counted: many may be asked for at once
            raise Problem(
                429, "{max_streams} streams are open already; close one first", max_streams=MAX_STREAMS
            )
        self._context.streams += 1
        gone = asyncio.ensure_future(_gone(receive))
        try:
            await send({"type": "http.response.start", "status": 200, "headers": self.raw_headers})
            await self._events(send, gone)
        except (RosError, asyncio.TimeoutError) as error:  # too late for a status: end the stream
            _logger.debug("! the stream of %s ends: %s", self._name, error or "nobody takes it")
        finally:
            gone.cancel()
            self._context.streams -= 1

    async def _events(self, send: Send, gone: asyncio.Future[None]) -> None:
        count, sent_at = -1, 0.0
        await run_in_threadpool(self._feed.connect)
        while not (gone.done() or self._feed.closed or self._context.closed):
            if self._feed.count != count and self._feed.known is not None:
                count = self._feed.count
                text = text_of(await run_in_threadpool(self._document))
                sent_at = await _tell(send, f"event: {self._name}\nid: {count}\ndata: {text}\n\n")
            elif time.monotonic() - sent_at > BEAT_SECONDS:
                sent_at = await _tell(send, ": nothing new\n\n")
            await self._rest(gone)
        if not gone.done():
            await send({"type": "http.response.body", "body": b""})

    async def _rest(self, gone: asyncio.Future[None]) -> None:
        """Wait until the next event is due, the reader has disconnected, or the server ends."""
        until = time.monotonic() + 1.0 / self._rate
        while (left := until - time.monotonic()) > 0.0 and not (gone.done() or self._context.closed):
            await asyncio.wait([gone], timeout=min(left, LOOK_SECONDS))


async def _gone(receive: Receive) -> None:
    while (await receive())["type"] != "http.disconnect":
        pass


async def _tell(send: Send, text: str) -> float:
    body = {"type": "http.response.body", "body": text.encode(), "more_body": True}
    await asyncio.wait_for(send(body), STUCK_SECONDS)
    return time.monotonic()


# -- the map, the plan, the costmap --------------------------------------------------------------------------

maps = APIRouter(tags=["map"], responses=PROBLEMS, dependencies=_ASKS_ROBOT)
_PNG: dict[int | str, dict[str, object]] = {
    200: {"content": {"image/png": {}}, "description": "a picture, north up"}
}
_YAML: dict[int | str, dict[str, object]] = {
    200: {"content": {"application/yaml": {}}, "description": "map_server's"}
}


@maps.get("/map", response_model=models.MapFacts)
def get_map(request: Request) -> dict[str, object]:
    """Size, resolution and origin of the map."""
    return robot_of(request).map.get().as_json()


@maps.get(
    "/map.png",
    response_class=Response,
    responses={**_PNG, 304: {"description": "not changed: If-None-Match had its ETag"}},
)
def get_map_png(request: Request) -> Response:
    """The map as PNG, north up: white is free, black is occupied, grey is not known."""
    known = robot_of(request).map.get()
    tag = f'"{known.version}"'
    if request.headers.get("if-none-match") == tag:
        return Response(status_code=304, headers={"etag": tag})
    return Response(known.png, media_type="image/png", headers={"etag": tag, "cache-control": "no-cache"})


@maps.get("/map.yaml", response_class=Response, responses=_YAML)
def get_map_yaml(request: Request) -> Response:
    """The map's YAML file for map_server; it names map.png as the image."""
    return Response(robot_of(request).map.get().yaml(), media_type="application/yaml")


scenes = APIRouter(tags=["map"], responses=PROBLEMS)


@scenes.get("/scenes", response_model=models.Scenes)
def get_scenes(request: Request) -> dict[str, object]:
    """The robot's maps by name, and the zones of the one in use; empty for a robot without a Robot API."""
    return robot_of(request).site.known(FIRST_SECONDS).as_json()


@scenes.post("/scenes/current", response_model=models.SwitchedMap, responses=problems(409))
def switch_map(body: models.SwitchMapRequest, request: Request) -> dict[str, object]:
    """Let the robot use another of its maps, and wait until it does. It may then not be localised."""
    robot, client = check_command(request, connected=False)
    if robot.site.known(FIRST_SECONDS).scene is None:
        raise Problem(
            409, "this robot names no maps: it has no Robot API, or does not answer there", "no-maps"
        )
    what = command("switch_map", scene=body.scene, map=body.map)
    entry = robot.journal.begin(client.name, what)
    try:
        now = robot.site.switch(body.scene, body.map)
    except Exception as error:
        robot.journal.end(entry, "failed", str(error))
        raise
    robot.journal.end(entry, "done", f"localised: {now.localised}")
    return {"scene": now.name, "map": now.current_map, "localised": now.localised}


@maps.get("/plan", response_model=models.Points)
def get_plan(request: Request) -> dict[str, object]:
    """The path that is being driven; empty if there is none."""
    robot = robot_of(request)
    robot.feed("plan").open()
    return {"points": robot_state.path_points(robot)}


@maps.get("/costmap.png", response_class=Response, responses=_PNG)
def get_costmap_png(request: Request) -> Response:
    """The navigation's costmap as PNG, if the navigation publishes one."""
    try:
        message = robot_of(request).costmap.value()
    except RosTimeout:
        text = "nothing came on {costmap_topic}: this chassis does not publish its costmap there"
        raise Problem(504, text, "costmap", costmap_topic=COSTMAP.name) from None
    cells = grid_from_message(message).cells
    grey = np.where(cells < 0, 205, 254 - np.clip(cells, 0, 100).astype(np.int16) * 254 // 100)
    return Response(encode_png(grey.astype(np.uint8)[::-1]), media_type="image/png")


# -- the cameras: one picture, for which a camera is subscribed ----------------------------------------------

pictures = APIRouter(tags=["camera"], responses=PROBLEMS, dependencies=_ASKS_ROBOT)
_PICTURE: dict[int | str, dict[str, object]] = {
    200: {"content": {"image/jpeg": {}, "image/png": {}}, "description": "depth: near is bright"}
}


@pictures.get("/camera/{source}.{form}", response_class=Response, responses=_PICTURE)
def get_picture(
    source: Literal["color", "depth"],
    form: Literal["jpg", "png"],
    request: Request,
    width: int = Query(640, ge=16, le=4096, description="of a JPEG, at most"),
) -> Response:
    """One picture. Waits for it for up to three seconds."""
    image = robot_of(request).cameras[source].value()
    if form == "png":
        return Response(encode_png(image.visible()), media_type="image/png")
    return Response(jpeg_of(image, width), media_type="image/jpeg")
