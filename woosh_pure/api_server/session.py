"""`ApiSession`: one client of the server by WebSocket: its requests, answered one by one, and its
subscriptions. `ApiPosts`: requests by HTTP. `respond` answers both.
"""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Hashable
from functools import partial
from http import HTTPStatus
from typing import Any

from rosproto.errors import RosError
from rosproto.gateway import ClientChannel, Refused
from rosproto.json_fields import shown
from rosproto.logs import get_logger
from rosproto.text import short
from woosh_pure.api_server.state import SCANNER, ApiState, asks_robot, is_command
from woosh_pure.robot_api import wire
from woosh_pure.robot_api.wire import Values

_log = get_logger("woosh_pure.api_server")

MAX_TYPE = 200  # characters of a type that are repeated
_SN_BITS = 63


def respond(state: ApiState, frame: object, client: Hashable, received: float | None = None) -> Values:
    """Answer one request, `{"type", "body", "sn"}`; the answer has its number.

    It may wait for the robot, see `ApiState.waits`. The client is the session of a WebSocket, or the IP
    address of the clients by HTTP there, which have no connection that ends with them.
    """
    if not isinstance(frame, dict):
        return wire.answer("", ok=False, msg=f"the message is {shown(frame)}; expected an object")
    type_name, sn = frame.get("type"), frame.get("sn")
    known = type_name[:MAX_TYPE] if isinstance(type_name, str) else ""
    if sn is not None and (type(sn) is not int or sn.bit_length() > _SN_BITS):
        text = f"sn is {shown(sn)}; expected a whole number of at most {_SN_BITS} bits"
        return wire.answer(known, ok=False, msg=text)
    try:
        if not isinstance(type_name, str):
            raise Refused("the request has no type; expected one such as woosh.robot.RobotState")
        request = wire.requests().get(type_name)
        if request is None:
            raise Refused(f"{short(type_name)!r} is not a request of the Robot API")
        asked = wire.load(type_name, frame.get("body"))
        if is_command(type_name):
            values = state.commands.do(client, type_name, asked, received or time.monotonic())
        else:
            values = state.answer(type_name, asked)
        return wire.answer(request.answer, None if request.empty else values, sn=sn)
    except (Refused, RosError, ValueError) as problem:
        return wire.answer(known, ok=False, msg=str(problem), sn=sn)
    except Exception:
        _log.exception("! robot-api: %s", known)
        return wire.answer(known, ok=False, msg="internal error; see the server's log", sn=sn)


async def _answer(state: ApiState, frame: object, client: Hashable) -> Values:
    """`respond`, in a thread where it may wait; called in the server's loop."""
    type_name = frame.get("type") if isinstance(frame, dict) else None
    work = partial(respond, state, frame, client, time.monotonic())
    if state.waits(type_name, client):
        return await state.pool.run(work, always=is_command(type_name))
    return work()


class ApiPosts:
    """The requests by HTTP; a `PostHandler`."""

    def __init__(self, state: ApiState) -> None:
        self._state = state

    async def answer(self, path: str, data: bytes, address: str) -> tuple[HTTPStatus, str]:
        """The path names the request: "/woosh/robot/Twist". As robots do, say a refusal with status 200."""
        type_name = wire.type_of(path)
        if type_name is None:
            why = f"{short(path)!r} is not a request of the Robot API; one is /woosh/robot/Battery"
            return HTTPStatus.NOT_FOUND, self.refused(why)
        try:
            frame = {"type": type_name, "body": await self._state.read_json(data)}
        except ValueError as problem:
            return HTTPStatus.OK, self.refused(f"the body {problem}", type_name)
        return HTTPStatus.OK, json.dumps(await _answer(self._state, frame, address))

    def refused(self, why: str, type_name: str = "") -> str:
        """The answer to what is refused before it is known."""
        return json.dumps(wire.answer(type_name, ok=False, msg=why))


class ApiSession:
    """One client of a server; a `ClientSession`.

    Attributes:
        topics: Types that are pushed to it; changed by `ApiState.subscribe` alone.
    """

    def __init__(self, state: ApiState, channel: ClientChannel) -> None:
        self.channel = channel
        self.topics: frozenset[str] = frozenset()
        self._state = state
        self._pushed: dict[str, str] = {}
        self._free = threading.Semaphore(state.limits.calls_per_client)

    @property
    def max_message_bytes(self) -> int:
        """See `GatewayState`."""
        return self._state.max_message_bytes

    async def received(self, data: str | bytes) -> None:
        """Answer one message; in the server's loop."""
        state = self._state
        try:
            frame = await state.read_json(data)
        except ValueError as problem:
            self._send(wire.answer("", ok=False, msg=f"the message {problem}"))
            return
        type_name = frame.get("type") if isinstance(frame, dict) else None
        if isinstance(frame, dict) and type_name == wire.SUBSCRIPTION:
            await state.pool.run(partial(self._subscribe, frame))
        elif asks_robot(type_name) and state.waits(type_name, self) and self._free.acquire(blocking=False):
            # The next message is read meanwhile: it may be a stop.
            state.pool.spawn(partial(self._reply, frame, time.monotonic()))
        else:
            self._send(await _answer(state, frame, self))

    def _subscribe(self, frame: dict[str, Any]) -> None:
        """Begin or end pushes. Only what cannot be subscribed has an answer: the protocol has none."""
        try:
            asked = wire.load(wire.SUBSCRIPTION, frame.get("body"))
            topics = {_topic(name) for name in asked["topics"]}
            self._state.subscribe(self, topics & wire.topics(), sub=asked["sub"])
            unknown = sorted(topics - wire.topics())
            if unknown and asked["sub"]:
                raise Refused(f"not topics of the Robot API: {', '.join(map(short, unknown[:5]))}")
        except (Refused, RosError) as problem:
            self.refuse_subscription(str(problem))

    def refuse_subscription(self, why: str) -> None:
        """Say why something is not pushed; from any thread."""
        self._send(wire.answer(wire.SUBSCRIPTION, ok=False, msg=why))

    def push(self, type_name: str, text: str | None) -> None:
        """Send the present value of a type, unless it is known to the client; the state's lock is held.

        Every scan is sent, an equal one too.
        """
        known = type_name != SCANNER and self._pushed.get(type_name) == text
        if text is None or known or type_name not in self.topics:
            return
        self._pushed[type_name] = text
        self.channel.outbox.put(type_name, len(text), text, keep=1)

    def forget(self, type_name: str) -> None:
        """What waits of a topic that was left is not sent; the state's lock is held."""
        self._pushed.pop(type_name, None)
        self.channel.outbox.forget(type_name)

    def _reply(self, frame: object, received: float) -> None:
        try:
            self._send(respond(self._state, frame, self, received))
        finally:
            self._free.release()
            if self.channel.gone:  # it may have been a velocity, which waited until then
                self._state.commands.gone(self)

    def _send(self, frame: Values) -> None:
        self.channel.answer((json.dumps(frame),))

    def ended(self) -> None:
        """The client has gone."""
        self._state.commands.gone(self)
        self._state.subscribe(self, self.topics, sub=False)

    def __str__(self) -> str:
        return self.channel.peer.rpartition(":")[0]

    def __repr__(self) -> str:
        return f"<ApiSession of {self.channel.peer}, {len(self.topics)} topics>"


def _topic(name: str) -> str:
    """The type that a topic means: manuals leave out the first word, or write one in the singular."""
    name = name if name.startswith("woosh.") else f"woosh.{name}"
    return f"{name}s" if name == "woosh.robot.count.AbnormalCode" else name
