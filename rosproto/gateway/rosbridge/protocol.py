"""`Protocol`: one client's rosbridge protocol v2, sans-IO. Messages become requests, answers payloads.

Source: ROSBRIDGE_PROTOCOL.md of github.com/RobotWebTools/rosbridge_suite, branch ros1, and rosbridge_library.
`operations.py` has the table of operations. `receive` never raises: it returns a reply with the error, or a
request to close the connection.

Deliberate differences from the original: a message ends with its WebSocket message (an incomplete one is not
continued), everything is bounded, statuses are sent (the original's branch for ROS 1 only logs them), and
`png` operations are read.
"""

from __future__ import annotations

import itertools
import json
from functools import partial
from json.encoder import encode_basestring_ascii as quoted

from rosproto.gateway.chunks import ChunkedMessage, chunked
from rosproto.gateway.client_limits import GatewayLimits
from rosproto.gateway.rosbridge.fields import LEVELS, Id, Level, WrongMessage, read_id
from rosproto.gateway.rosbridge.fragments import FragmentError, Reassembly, split
from rosproto.gateway.rosbridge.operations import (
    OPERATIONS,
    RECEIVED_PARTS,
    CallService,
    Close,
    LongMessage,
    Payload,
    Reply,
    Request,
    SendActionGoal,
    SetLevel,
    failed_answer,
    read_operation,
    unread_request,
)
from rosproto.gateway.rosbridge.png import MAX_PICTURE_BYTES, PngError, unpack
from rosproto.json_text import JsonError, JsonReader, is_short
from rosproto.json_values import JsonValue
from rosproto.protocol.framing import BytesLike
from rosproto.text import printable

TOO_BIG = 1009
"""The WebSocket close code for a message that is too long."""

_MAX_OBJECTS = 100  # JSON objects in one WebSocket message
_MAX_PICTURES = 4  # in one WebSocket message: a kilobyte may take a twentieth of a second to unpack
_WRAPPED = 2  # levels: a picture in fragments is read, deeper nesting is not


def publish_text(topic: str, message: str) -> str:
    """The operation `publish` with a topic's message, given as JSON text."""
    return f'{{"op":"publish","topic":{quoted(topic)},"msg":{message}}}'


def publish_chunks(topic: str, message: list[str]) -> ChunkedMessage:
    """As `publish_text`, for a long text in parts."""
    return chunked([f'{{"op":"publish","topic":{quoted(topic)},"msg":', *message, "}"])


class Protocol:
    """The protocol of one client. `receive` is for one thread at a time; any thread may write.

    Args:
        limits: Bounds of the client's messages.
        json: Decodes them; shared by all clients of a gateway.

    Attributes:
        level: Level of the statuses that the client wants.
        closed: `receive` has returned `Close`; it returns nothing more.
    """

    def __init__(self, limits: GatewayLimits, json: JsonReader | None = None) -> None:
        self._limits = limits
        self._json = json or limits.json_reader()
        self._fragments = Reassembly(limits.message_bytes)
        self._fragmented = itertools.count(1)
        self._pictures = 0  # in the message that is read
        self.level: Level = "error"
        self.closed = False

    # -- in

    def receive(self, data: str | BytesLike, now: float = 0.0, *, at_once: bool = False) -> list[Request]:
        """Return the requests of one WebSocket message, in order.

        Args:
            data: The message; bytes are decoded as UTF-8.
            now: Monotonic seconds, for the age of fragments.
            at_once: Return within milliseconds, with a `LongMessage` for what takes longer to read. Read it
                before the next message.
        """
        if self.closed:
            return []
        self._pictures = 0
        if len(data) > self._limits.message_bytes:
            self.closed = True
            return [Close(TOO_BIG, f"a message may have {self._limits.message_bytes} bytes")]
        return self._text(data if isinstance(data, str) else bytes(data), now, 0, at_once)

    def _text(self, text: Payload, now: float, depth: int, at_once: bool) -> list[Request]:
        """The requests of a text with one or several JSON objects."""
        if at_once and not is_short(text):
            return [LongMessage(partial(self._text, text, now, depth, False))]
        requests: list[Request] = []
        try:
            messages = self._json.read(text, _MAX_OBJECTS)
        except JsonError as error:
            self._refuse(requests, f"the message {error}")
            return requests
        objects = [message for message in messages if isinstance(message, dict)]
        others = [message for message in messages if not isinstance(message, dict)]
        if others:
            kind = _kind(others[0])
            self._refuse(requests, f"the message is JSON, but {kind}; expected an object with an op")
        elif not messages:
            self._refuse(requests, "the message is empty; expected a JSON object with an op")
        else:
            for message in objects:
                requests += self._message(message, now, depth, at_once)
        return requests

    def _message(self, message: dict[str, JsonValue], now: float, depth: int, at_once: bool) -> list[Request]:
        op = message.get("op")
        id: Id = None
        requests: list[Request] = []
        try:
            id = read_id(message, self._limits.text_length)
            if isinstance(op, str) and op in RECEIVED_PARTS:
                if at_once and op == "png":
                    return [LongMessage(partial(self._message, message, now, depth, False))]
                whole = self._part(op, message, now, depth)
                return [] if whole is None else self._text(whole, now, depth + 1, at_once)
            if not isinstance(op, str) or op not in OPERATIONS:
                raise WrongMessage(_no_operation(message, op))
            request = read_operation(op, message, self._limits.text_length)
        except (WrongMessage, FragmentError, PngError) as error:
            what = f"{op}: " if isinstance(op, str) and (op in OPERATIONS or op in RECEIVED_PARTS) else ""
            asked = unread_request(op, message, id, self._limits.text_length)
            self._refuse(requests, f"{what}{error}", id, asked)
            answer = None if id is None else failed_answer(op, id, str(error))
            return requests if answer is None else [*requests, answer]
        if isinstance(request, SetLevel):
            self.level = request.level
        return [request]

    def _part(self, op: str, message: dict[str, JsonValue], now: float, depth: int) -> str | None:
        """The text in a fragment or a picture; None while fragments are missing."""
        if depth >= _WRAPPED:
            raise WrongMessage("too many fragments and pictures inside one another")
        if op == "fragment":
            return self._fragments.add(message, now)
        if "num" in message or "total" in message:
            data: JsonValue = self._fragments.add(message, now)
            if data is None:
                return None
        else:
            data = message.get("data")
        if not isinstance(data, str):
            raise WrongMessage("field data is missing or not a text; expected a picture in base64")
        self._pictures += 1
        if self._pictures > _MAX_PICTURES:
            raise WrongMessage(f"more than {_MAX_PICTURES} pictures in one message; send them one by one")
        return unpack(data, min(MAX_PICTURE_BYTES, self._limits.message_bytes))

    def _refuse(
        self, requests: list[Request], text: str, id: Id = None, asked: Request | None = None
    ) -> None:
        """Append an error: the answer to the call or goal `asked`, else a status."""
        if isinstance(asked, CallService):
            payloads = self.service_failure(asked, text)
        elif isinstance(asked, SendActionGoal):
            payloads = self.action_failure(asked, text)
        else:
            payloads = self.status("error", text, id)
        if payloads:
            requests.append(Reply(payloads))

    # -- out

    def status(self, level: Level, text: str, id: Id = None) -> tuple[Payload, ...]:
        """A status; empty if the client does not want this level.

        Args:
            level: "error", "warning" or "info".
            text: A sentence.
            id: The id of the client's message.
        """
        if LEVELS.index(level) > LEVELS.index(self.level):
            return ()
        message: dict[str, JsonValue] = {"op": "status", "level": level, "msg": printable(text, keep="\n\t")}
        if id is not None:
            message["id"] = id
        return (json.dumps(message),)

    def service_response(self, call: CallService, values: str, *, result: bool = True) -> tuple[Payload, ...]:
        """Answer a call.

        Args:
            call: The call.
            values: The response as JSON text, or a sentence as JSON text.
            result: Whether the call succeeded.
        """
        head = f'{{"op":"service_response","service":{quoted(call.asked)},"values":{values}'
        text = f'{head},"result":{_truth(result)}{_with_id(call.id)}}}'
        return self.split(text, call.fragment_size, call.id)

    def service_failure(self, call: CallService, text: str) -> tuple[Payload, ...]:
        """Answer a failed call with a sentence."""
        return self.service_response(call, quoted(printable(text, keep="\n\t")), result=False)

    def call_service(self, id: str, service: str, args: str) -> tuple[Payload, ...]:
        """Call a service that the client provides; `ServiceResponse` with this id is its answer.

        Args:
            id: New for every call.
            service: The name it was advertised by.
            args: The request's JSON text.
        """
        text = f'{{"op":"call_service","id":{quoted(id)},"service":{quoted(service)},"args":{args}}}'
        return (text,)

    def send_action_goal(self, id: str, action: str, action_type: str, args: str) -> tuple[Payload, ...]:
        """Send a goal for an action that the client provides; `ActionResult` with this id ends it.

        Args:
            id: New for every goal.
            action: The name it was advertised by.
            action_type: The type it was advertised by.
            args: The goal's JSON text.
        """
        head = f'{{"op":"send_action_goal","id":{quoted(id)},"action":{quoted(action)}'
        return (f'{head},"action_type":{quoted(action_type)},"args":{args},"feedback":true}}',)

    def cancel_action_goal(self, id: str, action: str) -> tuple[Payload, ...]:
        """Ask the client to cancel a goal; it still ends with an `ActionResult`."""
        return (f'{{"op":"cancel_action_goal","id":{quoted(id)},"action":{quoted(action)}}}',)

    def action_feedback(self, goal: SendActionGoal, values: str) -> tuple[Payload, ...]:
        """Send feedback on a goal; `values` is its JSON text."""
        head = f'{{"op":"action_feedback","action":{quoted(goal.asked)},"values":{values}'
        return self.split(f"{head}{_with_id(goal.id)}}}", goal.fragment_size, goal.id)

    def action_result(
        self, goal: SendActionGoal, values: str, status: int, *, result: bool = True
    ) -> tuple[Payload, ...]:
        """Send the result of a goal.

        Args:
            goal: The goal.
            values: The result as JSON text, or a sentence as JSON text.
            status: An `ActionStatus`.
            result: False if there is no result from the server.
        """
        head = (
            f'{{"op":"action_result","action":{quoted(goal.asked)},"values":{values},"status":{int(status)}'
        )
        return self.split(
            f'{head},"result":{_truth(result)}{_with_id(goal.id)}}}', goal.fragment_size, goal.id
        )

    def action_failure(self, goal: SendActionGoal, text: str) -> tuple[Payload, ...]:
        """End a goal that was not sent, or was lost, with a sentence."""
        return self.action_result(goal, quoted(printable(text, keep="\n\t")), 0, result=False)

    def split(self, text: str, size: int | None, id: Id = None) -> tuple[Payload, ...]:
        """Return the text itself, or its fragments if it has more than `size` characters."""
        if size is None or len(text) <= size:
            return (text,)
        if not id:  # roslib ignores 0 and ""
            id = f"fragment:{next(self._fragmented)}"
        return split(text, size, id)


def _with_id(id: Id) -> str:
    return "" if id is None else f',"id":{json.dumps(id)}'


def _truth(value: bool) -> str:
    return "true" if value else "false"


def _kind(value: object) -> str:
    if isinstance(value, (list, str)):
        return "an array" if isinstance(value, list) else "a text"
    return "null" if value is None else "true or false" if isinstance(value, bool) else "a number"


def _no_operation(message: dict[str, JsonValue], op: object) -> str:
    if op is None and "receiver" in message:
        return "this is a message of rosbridge v1; expected v2, whose messages have an op"
    allowed = ", ".join([*OPERATIONS, *RECEIVED_PARTS])
    if op is None:
        return f"the message has no op; expected one of {allowed}"
    shown = f"'{printable(op[:60])}'" if isinstance(op, str) else _kind(op)
    return f"the operation {shown} is unknown; expected one of {allowed}"
