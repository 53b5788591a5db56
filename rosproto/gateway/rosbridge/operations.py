"""The operations of rosbridge that a client sends: one class for each, and the table that reads them.

`Protocol.receive` reads them, and the session carries them out. Fields have the names of the wire; the
annotation of each is its kind (`fields.py`), and one without a default is required. An optional field that is
null counts as left out. The values of messages (`msg`, `args`, `values`) are as JSON had them:
`values.from_values` checks them against a definition.

Source: ROSBRIDGE_PROTOCOL.md of rosbridge_suite (branch ros1; the operations of actions: branch ros2), and
what its capabilities do where that is silent.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field

from rosproto.gateway.rosbridge.fields import (
    Arguments,
    Compression,
    Count,
    Flag,
    Id,
    Name,
    Number,
    Seconds,
    Size,
    Status,
    StatusLevel,
    Text,
    WrongMessage,
    read_id,
)
from rosproto.json_fields import Anything, FieldError, Reader
from rosproto.json_values import JsonValue

RECEIVED_PARTS = ("fragment", "png")
"""Operations that contain another one; `Protocol` unpacks them."""

Payload = str | bytes
"""One WebSocket message, text or binary."""


# -- operations


@dataclass(frozen=True, slots=True)
class Operation:
    """What a client may send; `OPERATIONS` finds all classes below that derive from it.

    Attributes:
        id: The client's, repeated in the answer.
    """

    id: Id


@dataclass(frozen=True, slots=True)
class Advertise(Operation):
    """The client will publish on a topic."""

    topic: Name
    type: Name
    latch: Flag = False
    queue_size: Count = 100


@dataclass(frozen=True, slots=True)
class Unadvertise(Operation):
    """The client stops publishing on a topic; without an id, all its advertisements end."""

    topic: Name


@dataclass(frozen=True, slots=True)
class Publish(Operation):
    """The client publishes a message. If it has not advertised the topic, the type is the graph's.

    Attributes:
        msg: The message by field; by default, all fields have their default values.
    """

    topic: Name
    msg: Anything = field(default_factory=dict)
    latch: Flag = False
    queue_size: Count = 100


@dataclass(frozen=True, slots=True)
class Subscribe(Operation):
    """The client subscribes to a topic; ids distinguish several subscriptions of one topic.

    Attributes:
        type: The expected type; None for any.
        throttle_rate: Minimum milliseconds between two messages.
        queue_length: Most messages delayed by `throttle_rate`; with 0, early messages are dropped.
        fragment_size: Longest text that is not split into fragments; None for no limit.
    """

    topic: Name
    type: Text | None = None
    throttle_rate: Count = 0
    queue_length: Count = 0
    fragment_size: Size | None = None
    compression: Compression = "none"


@dataclass(frozen=True, slots=True)
class Unsubscribe(Operation):
    """The client ends a subscription; without an id, all of the topic."""

    topic: Name


@dataclass(frozen=True, slots=True)
class CallService(Operation):
    """The client calls a service; `Protocol.service_response` is the answer.

    Attributes:
        service: The name to call.
        asked: The name as the client wrote it, repeated in the answer: old clients append "#" and an id.
        args: A dict by field, a list by position, or None.
        timeout: Seconds; None for the gateway's own limit.
        long: The message was long: only few such calls may be unanswered at a time.
    """

    service: Name
    asked: str
    args: Arguments | None = None
    fragment_size: Size | None = None
    compression: Compression = "none"
    timeout: Seconds | None = None
    long: bool = False


@dataclass(frozen=True, slots=True)
class AdvertiseService(Operation):
    """The client starts providing a service; it gets the calls by `Protocol.call_service`."""

    service: Name
    type: Name


@dataclass(frozen=True, slots=True)
class UnadvertiseService(Operation):
    """The client stops providing a service."""

    service: Name


@dataclass(frozen=True, slots=True)
class ServiceResponse(Operation):
    """The client's answer to a call of its service.

    Attributes:
        id: The id of `Protocol.call_service`.
        values: The response by field; if `result` is False, None or a text with the reason.
        result: False if the call failed. roslib omits it when a page's callback returns nothing.
    """

    service: Name
    values: Anything = None
    result: Flag = False


@dataclass(frozen=True, slots=True)
class SendActionGoal(Operation):
    """The client sends a goal; `Protocol.action_feedback` and `action_result` are the answers.

    Attributes:
        action_type: As the client wrote it; `action_mapping.action_type` converts it to ROS 1's form.
        feedback: Whether the client wants feedback.
        long: As for `CallService`.
    """

    action: Name
    asked: str
    action_type: Name
    args: Arguments | None = None
    feedback: Flag = False
    fragment_size: Size | None = None
    compression: Compression = "none"
    long: bool = False


@dataclass(frozen=True, slots=True)
class CancelActionGoal(Operation):
    """The client cancels the goal with this id."""

    action: Name


@dataclass(frozen=True, slots=True)
class AdvertiseAction(Operation):
    """The client starts providing an action; it gets the goals by `Protocol.send_action_goal`."""

    action: Name
    type: Name


@dataclass(frozen=True, slots=True)
class UnadvertiseAction(Operation):
    """The client stops providing an action."""

    action: Name


@dataclass(frozen=True, slots=True)
class ActionFeedback(Operation):
    """The client's feedback on a goal; `id` is that of `Protocol.send_action_goal`."""

    action: Name
    values: Anything = None


@dataclass(frozen=True, slots=True)
class ActionResult(Operation):
    """The client's result of a goal.

    Attributes:
        id: The id of `Protocol.send_action_goal`.
        values: The result by field; if `result` is False, None or a text with the reason.
        status: An `ActionStatus`.
        result: False if the goal failed.
    """

    action: Name
    values: Anything = None
    status: Status = 0
    result: Flag = False


@dataclass(frozen=True, slots=True)
class Auth(Operation):
    """The client authenticates with credentials of rosauth."""

    mac: Text
    client: Text = ""
    dest: Text = ""
    rand: Text = ""
    t: Number = 0.0
    level: Text = ""
    end: Number = 0.0


@dataclass(frozen=True, slots=True)
class SetLevel(Operation):
    """The client chooses the level of its status messages; `Protocol` has applied it already."""

    level: StatusLevel


# -- requests of the protocol itself


@dataclass(frozen=True, slots=True)
class Reply:
    """Send these payloads, in order: an answer made by the protocol."""

    payloads: tuple[Payload, ...]


@dataclass(frozen=True, slots=True)
class LongMessage:
    """A message, or the rest of one, that takes time to read; only returned with `at_once`.

    Attributes:
        read: Returns its requests; call it in a thread.
    """

    read: Callable[[], list[Request]]


@dataclass(frozen=True, slots=True)
class Close:
    """Close the connection with this WebSocket close code and reason; later messages are ignored."""

    code: int
    reason: str


Request = Operation | Reply | LongMessage | Close
"""A request returned by `Protocol.receive`."""


# -- the table


def op_of(kind: type) -> str:
    """ "call_service" of CallService."""
    return re.sub("(?<!^)(?=[A-Z])", "_", kind.__name__).lower()


OPERATIONS = {
    op_of(kind): Reader(kind)
    for kind in list(globals().values())
    if isinstance(kind, type) and issubclass(kind, Operation) and kind is not Operation
}
_APPENDED = {"call_service": "service", "send_action_goal": "action", "cancel_action_goal": "action"}
"""Fields to which old clients append the id: `/rosapi/topics#33` is a call with the id 33."""


def read_operation(op: str, message: dict[str, JsonValue], text_length: int) -> Request:
    """Make the request of a message whose `op` is in `OPERATIONS`.

    Raises:
        WrongMessage: A field is wrong; the text names it.
    """
    reader, id = OPERATIONS[op], read_id(message, text_length)
    try:
        given = reader.arguments(message, text_length)
    except FieldError as error:
        raise WrongMessage(f"field {error}") from None
    if op in _APPENDED:
        asked = given[_APPENDED[op]]
        given[_APPENDED[op]], mark, appended = asked.partition("#")
        if mark and id is None:
            id = appended
        if op != "cancel_action_goal":
            given["asked"] = asked
    given["id"] = id
    return reader.make(**given)


def unread_request(op: object, message: dict[str, JsonValue], id: Id, text_length: int) -> Request | None:
    """A call or goal with a wrong field, with what its answer repeats; None for other operations."""
    if op not in ("call_service", "send_action_goal"):
        return None
    asked = message.get("service" if op == "call_service" else "action")
    name = asked[:text_length] if isinstance(asked, str) else ""
    if id is None and "#" in name:
        id = name.partition("#")[2]
    return CallService(id, name, name) if op == "call_service" else SendActionGoal(id, name, name, "")


def failed_answer(op: object, id: Id, text: str) -> ServiceResponse | ActionResult | None:
    """A failure in place of an answer with a wrong field, so that its call or goal ends; else None."""
    text = f"the client's answer is not valid: {text}"
    if op == "service_response":
        return ServiceResponse(id, "", text, result=False)
    return ActionResult(id, "", text, result=False) if op == "action_result" else None
