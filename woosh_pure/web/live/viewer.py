"""The live connection of one page: reads its messages, and begins stops.

`frame_pacing` sends it frames as fast as it reads; `page_driving` applies its dead-man switch.
"""

from __future__ import annotations

import asyncio
import json
import time
from collections.abc import Coroutine
from concurrent.futures import Future
from typing import Annotated, NamedTuple

from starlette.websockets import WebSocket, WebSocketDisconnect

from rosproto.admission import TokenBucket
from rosproto.json_fields import FieldError, Reader, number, shown, whole
from rosproto.sentence import say
from rosproto.text import printable
from woosh_pure.stopping.report import StopReport
from woosh_pure.web.access import Client
from woosh_pure.web.context import WebContext
from woosh_pure.web.http_errors import problem_of
from woosh_pure.web.live.frame_pacing import BadMessage, FrameSender
from woosh_pure.web.live.hub import Hub
from woosh_pure.web.live.page_driving import PageDriving
from woosh_pure.web.snapshot import plain, stop_part

MAX_TEXT_CHARACTERS = 4096
GONE_SECONDS = 6.0
"""Seconds for which a disconnected page keeps the lease, to connect again."""
GOING_AWAY = 1001
"""The code with which a browser closes the connections of a page that is closed or left. A last message of
the page's script does not always arrive (Firefox). A cut network sends no code."""
REPLACED = 4409
"""The code of a connection whose session another connection has resumed. A page that is still open, because
its tab was copied with the session, then takes a new session."""


_number = number(-1e15, 1e15, "a finite number")


class Viewer:
    """The server's end of one live connection. Used in the event loop only.

    Attributes:
        is_replaced: Whether another connection has resumed the page's session.
    """

    def __init__(self, socket: WebSocket, context: WebContext, hub: Hub, client: Client) -> None:
        self._socket, self._context, self._hub, self._client = socket, context, hub, client
        self._robot = hub.robot
        self._sender = FrameSender(hub, client.name, context.clients.is_page)
        self._page_driving = PageDriving(context, hub.robot, client.name, self._sender, self._start)
        self._tell = self._sender.tell
        self._wanted: set[str] = set()  # cameras and costmap that the page has asked for
        self._is_looking = False
        self._tasks: set[asyncio.Task[None]] = set()
        self._pace = TokenBucket(200.0, 400.0)
        self._replaced = asyncio.Event()
        client.replaced = self._replace

    @property
    def is_replaced(self) -> bool:
        """See `Viewer`."""
        return self._replaced.is_set()

    def _replace(self) -> None:
        self._page_driving.gone()
        self._replaced.set()

    async def run(self) -> None:
        """Serve the page until the connection ends. The drive is ended first of all."""
        self._hub.join(self._sender.wake.set)
        self._robot.chassis.lease.renew(self._client.name)  # of a page that has connected again
        self._tell(self._hello())
        parts = (
            self._read(),
            self._sender.send_all(self._socket),
            self._page_driving.watch(),
            self._replaced.wait(),
        )
        tasks: list[asyncio.Task[object]] = [asyncio.ensure_future(part) for part in parts]
        code, reason = 1000, ""
        try:
            done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
            for task in done:
                error = task.exception()
                if isinstance(error, BadMessage):
                    code, reason = 1008, str(error)
                elif isinstance(error, TimeoutError):
                    code, reason = 4408, str(error)
                elif error is not None and not isinstance(
                    error, (WebSocketDisconnect, RuntimeError, OSError)
                ):
                    raise error
        finally:
            self._page_driving.gone()
            if self.is_replaced:
                code, reason = REPLACED, "the page was opened again"
            else:
                self._robot.chassis.lease.shorten(self._client.name, GONE_SECONDS)
                if self._robot.chassis.lease.withdraw(self._client.name):
                    self._hub.wake()
            try:
                await _end_all({*tasks, *self._tasks})
                for what in list(self._sender.watched):
                    await self._hub.watch(what, False)
            finally:
                self._hub.leave(self._sender.wake.set)
        try:
            await asyncio.wait_for(self._socket.close(code, printable(reason)[:120]), 2.0)
        except (RuntimeError, OSError, asyncio.TimeoutError, WebSocketDisconnect):
            pass  # the connection has ended

    def _hello(self) -> dict[str, object]:
        sim = self._robot.simulator
        return {
            "t": "hello",
            "robot": self._robot.name,
            "robots": list(self._context.robots),
            "session": self._client.session,
            "you": self._client.name,
            "allow_driving": self._context.allow_driving,
            "simulator": None if sim is None else {"speed": sim.speed},
            "limits": self._robot.manual_drive.limits,
        }

    async def _read(self) -> None:
        while True:
            event = await self._socket.receive()
            if self.is_replaced:
                return
            if event["type"] == "websocket.disconnect":
                if event.get("code") == GOING_AWAY:
                    self._page_driving.give()
                return
            text = event.get("text")
            if text is None or len(text) > MAX_TEXT_CHARACTERS:
                raise BadMessage(
                    say("expected text of at most {max_text} characters", max_text=MAX_TEXT_CHARACTERS)
                )
            message = _document(text)
            if message.get("t") == "stop":  # also above the limit of messages
                self._stop(message.get("n"))
            if not self._pace.take(time.monotonic()):
                raise BadMessage("more than 200 messages a second")
            self._handle(message)

    def _handle(self, message: dict[str, object]) -> None:
        """Handle one message without waiting, so that the next beat or stop is not delayed."""
        kind = message.get("t")
        if kind == "stop":
            pass  # `_read` has begun it
        elif kind == "ack":
            self._sender.acknowledge(message.get("n"))
        elif kind == "beat":
            self._page_driving.beat(*_control(message))
        elif kind == "press":
            self._page_driving.press(*_control(message))
        elif kind == "release":
            self._page_driving.release()
        elif kind == "confirm":
            self._page_driving.confirmed = True
        elif kind == "look":
            self._look(message)
        elif kind == "lease":
            self._page_driving.ask_lease(message.get("op"), message.get("to"))
            self._sender.tell_lease_again()
            self._hub.wake()
        else:
            raise BadMessage(say("t={kind!r:.40} is not a message of this connection", kind=kind))

    def _stop(self, number: object) -> None:
        """Begin a stop, which needs neither the lease nor a confirmation."""
        stop = self._robot.begin_stop(self._client.name)
        self._tell({"t": "stop", "n": plain(number), "state": "begun"})
        self._start(self._tell_stop(stop, number))

    async def _tell_stop(self, stop: Future[StopReport], number: object) -> None:
        part: dict[str, object] = {"stands_still": None}
        try:
            part.update(stop_part(await asyncio.wrap_future(stop)))
        except Exception as error:
            part["text"] = problem_of(error).text
        self._tell({"t": "stop", "n": plain(number), "state": "done", **part})

    def _look(self, message: dict[str, object]) -> None:
        camera, costmap = message.get("camera"), message.get("costmap", "costmap" in self._wanted)
        if camera not in ("color", "depth", None) or not isinstance(costmap, bool):
            raise BadMessage('look: expected camera "color", "depth" or null, and costmap true or false')
        self._wanted = {what for what, on in ((camera, True), ("costmap", costmap)) if on and what}
        if "costmap" not in self._wanted:
            self._sender.drop_costmap()
        if not self._is_looking:
            self._is_looking = True
            self._start(self._follow_look())

    async def _follow_look(self) -> None:
        """Watch the wanted cameras and costmap, also those requested meanwhile."""
        try:
            while changed := self._sender.watched ^ self._wanted:
                what = min(changed)
                on = what in self._wanted
                # Before it is waited for: at the end of `run` all that is watched is given up.
                self._sender.watched ^= {what}
                await self._hub.watch(what, on)
        finally:
            self._is_looking = False

    def _start(self, job: Coroutine[object, object, None]) -> None:
        task = asyncio.ensure_future(job)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)


async def _end_all(tasks: set[asyncio.Task[object]]) -> None:
    """Cancel tasks until they have ended: up to Python 3.11, `asyncio.wait_for` may swallow a cancel."""
    until = time.monotonic() + 2.0
    while tasks and time.monotonic() < until:
        for task in tasks:
            task.cancel()
        done, tasks = await asyncio.wait(tasks, timeout=0.1)
        for task in done:
            if not task.cancelled():
                task.exception()


def _document(text: str) -> dict[str, object]:
    try:
        message = json.loads(text)
    except (ValueError, RecursionError):
        raise BadMessage("expected JSON") from None
    if not isinstance(message, dict):
        raise BadMessage("expected an object")
    return message


class _Control(NamedTuple):
    seq: Annotated[int, whole(0, 2**53 - 1, "a whole number that grows")]
    at: Annotated[float, _number] = 0.0
    vx: Annotated[float, _number] = 0.0
    wz: Annotated[float, _number] = 0.0


_CONTROL = Reader(_Control, null=True)


def _control(message: dict[str, object]) -> _Control:
    try:
        return _CONTROL(message)
    except FieldError as error:
        raise BadMessage(f"{error.path}={shown(error.value)}: expected {error.expected}") from None
