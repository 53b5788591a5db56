"""What a client of rosbridge asks for: what comes out of `Protocol.receive`, and the session carries out.

Fields have the names of the wire (github.com/RobotWebTools/rosbridge_suite, ROSBRIDGE_PROTOCOL.md), every one
checked for its type and its bounds. The values of messages (`msg`, `args`, `values`) are as JSON had them:
`values.from_values` checks them against a definition.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

__all__ = [
    "ActionFeedback",
    "ActionResult",
    "Advertise",
    "AdvertiseAction",
    "AdvertiseService",
    "Auth",
    "CallService",
    "CancelActionGoal",
    "Close",
    "Compression",
    "Effect",
    "Id",
    "Payload",
    "Publish",
    "Reply",
    "Rest",
    "SendActionGoal",
    "ServiceResponse",
    "SetLevel",
    "Subscribe",
    "Unadvertise",
    "UnadvertiseAction",
    "UnadvertiseService",
    "Unsubscribe",
]

Id = str | int | None
"""Names an interaction; the client's choice, and back to it in every answer."""

Payload = str | bytes
"""One message of the WebSocket: text, or binary."""

Compression = Literal["none", "png", "cbor", "cbor-raw"]


@dataclass(frozen=True, slots=True)
class Advertise:
    """The client will publish on a topic."""

    id: Id
    topic: str
    type: str
    latch: bool = False
    queue_size: int = 100


@dataclass(frozen=True, slots=True)
class Unadvertise:
    """It will not any more; without an id: by none of its advertisements."""

    id: Id
    topic: str


@dataclass(frozen=True, slots=True)
class Publish:
    """A message of the client. The topic need not be advertised: its type is the graph's then."""

    id: Id
    topic: str
    msg: Any
    latch: bool = False
    queue_size: int = 100


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
    topic: str
    type: str | None = None
    throttle_rate: int = 0
    queue_length: int = 0
    fragment_size: int | None = None
    compression: Compression = "none"


@dataclass(frozen=True, slots=True)
class Unsubscribe:
    """It wants it no more; without an id: by none of its subscriptions."""

    id: Id
    topic: str


@dataclass(frozen=True, slots=True)
class CallService:
    """A call; its answer is `Protocol.service_response`.

    Attributes:
        service: The name to call.
        asked: The name as the client wrote it, which the answer repeats: old clients append "#" and an id.
        args: A dict by field, a list by position, or None.
        type: The type that the client expects, where it says so.
        timeout: Seconds that the client waits; None: the gateway's own.
        long: It came in a long message: few such ones may be unanswered at a time.
    """

    id: Id
    service: str
    asked: str
    args: dict[str, Any] | list[Any] | None = None
    type: str | None = None
    fragment_size: int | None = None
    compression: Compression = "none"
    timeout: float | None = None
    long: bool = False


@dataclass(frozen=True, slots=True)
class AdvertiseService:
    """The client provides a service: calls go to it by `Protocol.call_service`."""

    id: Id
    service: str
    type: str


@dataclass(frozen=True, slots=True)
class UnadvertiseService:
    """It provides it no more."""

    id: Id
    service: str


@dataclass(frozen=True, slots=True)
class ServiceResponse:
    """The client's answer to a call of the service that it provides.

    Attributes:
        id: The id of `Protocol.call_service`.
        values: The response by field; a text where `result` is False, if the client says why.
        result: False: it failed.
    """

    id: Id
    service: str
    values: Any
    result: bool


@dataclass(frozen=True, slots=True)
class SendActionGoal:
    """A goal for an action server; `Protocol.action_feedback` and `action_result` answer it.

    Attributes:
        action_type: As the client wrote it; `actions.action_type` brings it to ROS 1's form.
        feedback: Whether feedback is wanted.
        long: As for `CallService`.
    """

    id: Id
    action: str
    asked: str
    action_type: str
    args: dict[str, Any] | list[Any] | None = None
    feedback: bool = False
    fragment_size: int | None = None
    compression: Compression = "none"
    long: bool = False


@dataclass(frozen=True, slots=True)
class CancelActionGoal:
    """Give up the goal that was sent with this id."""

    id: Id
    action: str


@dataclass(frozen=True, slots=True)
class AdvertiseAction:
    """The client provides an action: goals go to it by `Protocol.send_action_goal`."""

    id: Id
    action: str
    type: str


@dataclass(frozen=True, slots=True)
class UnadvertiseAction:
    """It provides it no more."""

    id: Id
    action: str


@dataclass(frozen=True, slots=True)
class ActionFeedback:
    """The client's feedback on a goal; `id` is that of `Protocol.send_action_goal`."""

    id: Id
    action: str
    values: Any = None


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
    action: str
    values: Any = None
    status: int = 0
    result: bool = False


@dataclass(frozen=True, slots=True)
class Auth:
    """Credentials of rosauth."""

    id: Id
    mac: str
    client: str = ""
    dest: str = ""
    rand: str = ""
    t: float = 0.0
    level: str = ""
    end: float = 0.0


@dataclass(frozen=True, slots=True)
class SetLevel:
    """Which status messages the client wants from here on; the protocol has taken it over already."""

    id: Id
    level: Literal["none", "error", "warning", "info"]


@dataclass(frozen=True, slots=True)
class Reply:
    """Send this, in this order: the protocol's own answer (a status)."""

    payloads: tuple[Payload, ...]


@dataclass(frozen=True, slots=True)
class Rest:
    """What the rest of a message asks for, which takes time to be read; only `Protocol.begin` says it.

    Attributes:
        read: Returns it; for a thread.
    """

    read: Callable[[], list[Effect]]


@dataclass(frozen=True, slots=True)
class Close:
    """End the connection with this WebSocket close code and reason; nothing that came later is read."""

    code: int
    reason: str


Effect = (
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
    | Rest
    | Close
)
"""Everything that `Protocol.receive` may say."""
