"""GET feeds, the newest value of one, and its stream of Server-Sent Events."""

from __future__ import annotations

import asyncio
import time
from typing import Any

from fastapi import APIRouter, Query, Request, Response
from starlette.concurrency import run_in_threadpool
from starlette.types import Receive, Scope, Send

from rosproto.errors import RosError
from rosproto.logs import get_logger
from woosh_pure import interface
from woosh_pure.feed.feed import PICTURES
from woosh_pure.feed.feed import Feed as ChassisFeed
from woosh_pure.web import models
from woosh_pure.web.api.dependencies import PROBLEMS, context_of, problems, robot_of
from woosh_pure.web.context import WebContext
from woosh_pure.web.problems import Problem
from woosh_pure.web.snapshot import plain, text_of

__all__ = ["router"]

_logger = get_logger("woosh_pure.web")
router = APIRouter(tags=["feeds"], responses=PROBLEMS)
MOST_STREAMS, STUCK_SECONDS, BEAT_SECONDS, LOOK_SECONDS = 32, 10.0, 5.0, 0.25
_EVENTS: dict[int | str, dict[str, Any]] = {
    200: {"content": {"text/event-stream": {}}, "description": "one event for each new value, as FeedValue"}
}


def list_feeds() -> list[dict[str, Any]]:
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


def _feed(name: str, request: Request) -> ChassisFeed[Any]:
    row = interface.find(name)
    if row.type in PICTURES:
        raise Problem(
            415, f"{name} is too large for this; see camera/color.jpg and camera/depth.jpg", "picture"
        )
    return robot_of(request).feed(name)


def _value(name: str, feed: ChassisFeed[Any]) -> dict[str, Any]:
    reading = feed.known
    if reading is None:
        return {"name": name, "value": None, "age": None, "stamp": None}
    age = round(reading.age, 3)
    return {"name": name, "value": plain(reading.value), "age": age, "stamp": reading.stamp}


def get_feed(feed: str, request: Request) -> dict[str, Any]:
    """The newest value of a feed; null if nothing was heard yet."""
    found = _feed(feed, request)
    found.connect()
    return _value(feed, found)


def stream_feed(
    feed: str, request: Request, rate: float = Query(10.0, gt=0.0, le=20.0, description="events a second")
) -> Response:
    """New values as Server-Sent Events. A slow reader gets fewer of them, and always the newest."""
    found, context = _feed(feed, request), context_of(request)
    found.open()
    if context.streams >= MOST_STREAMS:
        raise Problem(429, f"{MOST_STREAMS} streams are open already; close one first")
    return _Events(context, feed, found, rate)


class _Events(Response):
    """The stream of events. It ends if the reader accepts nothing for ten seconds."""

    media_type = "text/event-stream"

    def __init__(self, context: WebContext, name: str, feed: ChassisFeed[Any], rate: float) -> None:
        super().__init__()
        del self.headers["content-length"]
        self._context, self._name, self._feed, self._rate = context, name, feed, rate

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        await send({"type": "http.response.start", "status": 200, "headers": self.raw_headers})
        self._context.streams += 1
        gone = asyncio.ensure_future(_gone(receive))
        try:
            await self._events(send, gone)
        except (RosError, asyncio.TimeoutError) as error:  # too late for a status: the stream just ends
            _logger.debug("! the stream of %s ends: %s", self._name, error or "nobody takes it")
        finally:
            gone.cancel()
            self._context.streams -= 1

    async def _events(self, send: Send, gone: asyncio.Future[None]) -> None:
        count, said = -1, 0.0
        await run_in_threadpool(self._feed.connect)
        while not (gone.done() or self._feed.closed or self._context.closed):
            if self._feed.count != count and self._feed.known is not None:
                count = self._feed.count
                text = text_of(_value(self._name, self._feed))
                said = await _tell(send, f"event: {self._name}\nid: {count}\ndata: {text}\n\n")
            elif time.monotonic() - said > BEAT_SECONDS:
                said = await _tell(send, ": nothing new\n\n")
            await self._rest(gone)
        if not gone.done():
            await send({"type": "http.response.body", "body": b""})

    async def _rest(self, gone: asyncio.Future[None]) -> None:
        """Wait until the next event is due, the reader has gone, or the server ends."""
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


router.add_api_route("/feeds", list_feeds, response_model=list[models.Feed])
router.add_api_route("/feeds/{feed}", get_feed, response_model=models.FeedValue, responses=problems(415))
router.add_api_route(
    "/feeds/{feed}/stream", stream_feed, response_class=Response, responses={**_EVENTS, **problems(415, 429)}
)
