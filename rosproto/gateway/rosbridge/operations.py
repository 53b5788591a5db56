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
from dataclasses import MISSING, dataclass, field, fields
from typing import Any, get_args, get_type_hints

from rosproto.gateway.rosbridge.fields import (
    Anything,
    Arguments,
    Check,
    Compression,
    Count,
    FieldError,
    Flag,
    Id,
    Name,
    Number,
    Seconds,
    Size,
    Status,
    StatusLevel,
    Text,
    read_id,
    shown,
)

RECEIVED_PARTS = ("fragment", "png")
"""Operations that hold another one; the protocol itself reads them."""

Payload = str | bytes
"""One message of the WebSocket: text, or binary."""


# -- operations


@dataclass(frozen=True, slots=True)
class Advertise:
    """The client will publish on a topic."""

    id: Id
    topic: Name
    type: Name
    latch: Flag = False
    queue_size: Count = 100


@dataclass(frozen=True, slots=True)
class Unadvertise:
    """It will not any more; without an id: by none of its advertisements."""

    id: Id
    topic: Name


@dataclass(frozen=True, slots=True)
class Publish:
    """A message of the client. The topic need not be advertised: its type is the graph's then.

    Attributes:
        msg: By field; without it, a message of default values.
    """

    id: Id
    topic: Name
    msg: Anything = field(default_factory=dict)
    latch: Flag = False
    queue_size: Count = 100


@dataclass(frozen=True, slots=True)
class Subscribe:
    """The client wants a topic; an id tells several subscriptions of it apart.

    Attributes:
        type: The type that the client expects; None: whichever the topic has.
        throttle_rate: Least milliseconds between two messages.
        queue_length: Messages that wait because of it; 0: those that come too early are dropped.
        fragment_size: Longest text before it is cut into fragments; None: never.
    """

    id: Id
    topic: Name
    type: Text | None = None
    throttle_rate: Count = 0
    queue_length: Count = 0
    fragment_size: Size | None = None
    compression: Compression = "none"


@dataclass(frozen=True, slots=True)
class Unsubscribe:
    """It wants it no more; without an id: by none of its subscriptions."""

    id: Id
    topic: Name


@dataclass(frozen=True, slots=True)
class CallService:
    """A call; its answer is `Protocol.service_response`.

    Attributes:
        service: The name to call.
        asked: The name as the client wrote it, which the answer repeats: old clients append "#" and an id.
        args: A dict by field, a list by position, or None.
        timeout: Seconds that the client waits; None, also where it gave no number: the gateway's own.
        long: It came in a long message: few such ones may be unanswered at a time.
    """

    id: Id
    service: Name
    asked: str
    args: Arguments | None = None
    fragment_size: Size | None = None
    compression: Compression = "none"
    timeout: Seconds | None = None
    long: bool = False


@dataclass(frozen=True, slots=True)
class AdvertiseService:
    """The client provides a service: calls go to it by `Protocol.call_service`."""

    id: Id
    service: Name
    type: Name


@dataclass(frozen=True, slots=True)
class UnadvertiseService:
    """It provides it no more."""

    id: Id
    service: Name


@dataclass(frozen=True, slots=True)
class ServiceResponse:
    """The client's answer to a call of the service that it provides.

    Attributes:
        id: The id of `Protocol.call_service`.
        values: The response by field; a text where `result` is False, if the client says why.
        result: False: it failed. roslib leaves it out where a page's callback returns nothing.
    """

    id: Id
    service: Name
    values: Anything = None
    result: Flag = False


@dataclass(frozen=True, slots=True)
class SendActionGoal:
    """A goal for an action server; `Protocol.action_feedback` and `action_result` answer it.

    Attributes:
        action_type: As the client wrote it; `actions.action_type` brings it to ROS 1's form.
        feedback: Whether feedback is wanted.
        long: As for `CallService`.
    """

    id: Id
    action: Name
    asked: str
    action_type: Name
    args: Arguments | None = None
    feedback: Flag = False
    fragment_size: Size | None = None
    compression: Compression = "none"
    long: bool = False


@dataclass(frozen=True, slots=True)
class CancelActionGoal:
    """Give up the goal that was sent with this id."""

    id: Id
    action: Name


@dataclass(frozen=True, slots=True)
class AdvertiseAction:
    """The client provides an action: goals go to it by `Protocol.send_action_goal`."""

    id: Id
    action: Name
    type: Name


@dataclass(frozen=True, slots=True)
class UnadvertiseAction:
    """It provides it no more."""

    id: Id
    action: Name


@dataclass(frozen=True, slots=True)
class ActionFeedback:
    """The client's feedback on a goal; `id` is that of `Protocol.send_action_goal`."""

    id: Id
    action: Name
    values: Anything = None


@dataclass(frozen=True, slots=True)
class ActionResult:
    """The client has ended a goal.

    Attributes:
        id: The id of `Protocol.send_action_goal`.
        values: The result by field; a text where `result` is False, if the client says why.
        status: `actions.ActionStatus`.
        result: False: it failed.
    """

    id: Id
    action: Name
    values: Anything = None
    status: Status = 0
    result: Flag = False


@dataclass(frozen=True, slots=True)
class Auth:
    """Credentials of rosauth."""

    id: Id
    mac: Text
    client: Text = ""
    dest: Text = ""
    rand: Text = ""
    t: Number = 0.0
    level: Text = ""
    end: Number = 0.0


@dataclass(frozen=True, slots=True)
class SetLevel:
    """Which status messages the client wants from here on; the protocol has taken it over already."""

    id: Id
    level: StatusLevel


# -- what else the protocol says


@dataclass(frozen=True, slots=True)
class Reply:
    """Send this, in this order: the protocol's own answer (a status)."""

    payloads: tuple[Payload, ...]


@dataclass(frozen=True, slots=True)
class LongMessage:
    """What the rest of a message asks for, which takes time to be read; only `Protocol.begin` says it.

    Attributes:
        read: Returns it; for a thread.
    """

    read: Callable[[], list[Request]]


@dataclass(frozen=True, slots=True)
class Close:
    """End the connection with this WebSocket close code and reason; nothing that came later is read."""

    code: int
    reason: str


Request = (
    Advertise
    | Unadvertise
    | Publish
    | Subscribe
    | Unsubscribe
    | CallService
    | AdvertiseService
    | UnadvertiseService
    | ServiceResponse
    | SendActionGoal
    | CancelActionGoal
    | AdvertiseAction
    | UnadvertiseAction
    | ActionFeedback
    | ActionResult
    | Auth
    | SetLevel
    | Reply
    | LongMessage
    | Close
)
"""Everything that `Protocol.receive` may say."""


# -- the table


@dataclass(frozen=True, slots=True)
class Field:
    """A field of an operation, as the wire has it."""

    name: str
    check: Check
    required: bool


@dataclass(frozen=True, slots=True)
class Operation:
    """A row of the table."""

    make: Callable[..., Request]
    fields: tuple[Field, ...]


def op_of(kind: type) -> str:
    """ "call_service" of CallService."""
    return re.sub("(?<!^)(?=[A-Z])", "_", kind.__name__).lower()


def _fields(kind: Any) -> tuple[Field, ...]:
    hints = get_type_hints(kind, include_extras=True)
    found = []
    for each in fields(kind):
        # `Annotated[...]`, or `Annotated[...] | None`
        checks = [
            check
            for hint in (hints[each.name], *get_args(hints[each.name]))
            for check in getattr(hint, "__metadata__", ())
        ]
        if checks:
            required = each.default is MISSING and each.default_factory is MISSING
            found.append(Field(each.name, checks[0], required))
    return tuple(found)


OPERATIONS: dict[str, Operation] = {
    op_of(kind): Operation(kind, _fields(kind))
    for kind in (
        Advertise,
        Unadvertise,
        Publish,
        Subscribe,
        Unsubscribe,
        CallService,
        AdvertiseService,
        UnadvertiseService,
        ServiceResponse,
        SendActionGoal,
        CancelActionGoal,
        AdvertiseAction,
        UnadvertiseAction,
        ActionFeedback,
        ActionResult,
        Auth,
        SetLevel,
    )
}
_NULL_IS_A_VALUE = frozenset({"msg"})  # refused by its message type, with the sentence of that
_APPENDED = {"call_service": "service", "send_action_goal": "action", "cancel_action_goal": "action"}
"""Fields in which old clients write the id, too: `/rosapi/topics#33` is a call with the id 33."""


def read_operation(op: str, message: dict[str, Any], text_length: int) -> Request:
    """The effect of one message whose `op` is in the table.

    Raises:
        FieldError: What is wrong with which field.
    """
    operation = OPERATIONS[op]
    given: dict[str, Any] = {"id": read_id(message, text_length)}
    for each in operation.fields:
        value = message.get(each.name)
        if value is None and each.name in _NULL_IS_A_VALUE and each.name in message:
            given[each.name] = None
        elif value is not None:
            try:
                given[each.name] = each.check(value, text_length)
            except ValueError as error:
                raise FieldError(f"field {each.name} is {shown(value)}; expected {error}") from None
        elif each.required:
            raise FieldError(f"field {each.name} is missing; it is required")
    if op in _APPENDED:
        asked = given[_APPENDED[op]]
        given[_APPENDED[op]], mark, appended = asked.partition("#")
        if mark and given["id"] is None:
            given["id"] = appended
        if op != "cancel_action_goal":
            given["asked"] = asked
    return operation.make(**given)


def unread_request(op: object, message: dict[str, Any], id: Id, text_length: int) -> Request | None:
    """A call or goal with a wrong field, as far as its answer repeats it; None for other operations."""
    if op not in ("call_service", "send_action_goal"):
        return None
    asked = message.get("service" if op == "call_service" else "action")
    name = asked[:text_length] if isinstance(asked, str) else ""
    if id is None and "#" in name:
        id = name.partition("#")[2]
    return CallService(id, name, name) if op == "call_service" else SendActionGoal(id, name, name, "")


def failed_answer(op: object, id: Id, text: str) -> ServiceResponse | ActionResult | None:
    """Ends the call or goal that an answer with a wrong field was for; None for other operations."""
    text = f"the client's answer is not valid: {text}"
    if op == "service_response":
        return ServiceResponse(id, "", text, result=False)
    return ActionResult(id, "", text, result=False) if op == "action_result" else None
