"""The table of rosbridge's operations: which fields each has, of which kind, and what comes of it.

Source: ROSBRIDGE_PROTOCOL.md of rosbridge_suite (branch ros1; the operations of actions: branch ros2), and
what its capabilities do where that is silent. An optional field that is null counts as left out.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from rosproto.gateway.rosbridge import effects
from rosproto.gateway.rosbridge.actions import ActionStatus
from rosproto.gateway.rosbridge.effects import Effect
from rosproto.gateway.rosbridge.status import level_named
from rosproto.text import printable

__all__ = ["OPERATIONS", "RECEIVED_PARTS", "FieldError", "read_id", "read_operation"]

LARGEST = 2**31 - 1
"""Of every whole number: sizes, rates and counts beyond it mean nothing."""
_SHOWN = 60  # characters of a wrong value in a sentence
_COMPRESSIONS = ("none", "png", "cbor", "cbor-raw")

RECEIVED_PARTS = ("fragment", "png")
"""Operations that hold another one; the protocol itself reads them."""


class FieldError(Exception):
    """A field is missing or wrong; the text is a sentence for the client."""


Check = Callable[[Any, int], Any]
"""(value, longest text) -> value; ValueError with what is expected."""


@dataclass(frozen=True, slots=True)
class Field:
    name: str
    check: Check
    required: bool = False


@dataclass(frozen=True, slots=True)
class Operation:
    make: Callable[..., Effect]
    fields: tuple[Field, ...]


def read_operation(op: str, message: dict[str, Any], text_length: int) -> Effect:
    """The effect of one message whose `op` is in the table.

    Raises:
        FieldError: What is wrong with which field.
    """
    operation = OPERATIONS[op]
    given: dict[str, Any] = {"id": read_id(message, text_length)}
    for field in operation.fields:
        value = message.get(field.name)
        if value is None and field.name in _NULL_IS_A_VALUE and field.name in message:
            given[field.name] = None
        elif value is not None:
            try:
                given[field.name] = field.check(value, text_length)
            except ValueError as error:
                raise FieldError(f"field {field.name} is {_shown(value)}; expected {error}") from None
        elif field.required:
            raise FieldError(f"field {field.name} is missing; it is required")
    return operation.make(**given)


_NULL_IS_A_VALUE = frozenset({"msg"})  # refused by its message type, with the sentence of that


def read_id(message: dict[str, Any], text_length: int) -> effects.Id:
    """The id of a message, None where it has none.

    Raises:
        FieldError: It is neither a text nor a whole number, or it is too long to be sent back.
    """
    value = message.get("id")
    if value is None or (type(value) is int and abs(value) < 2**63):
        return value
    if isinstance(value, str) and len(value) <= text_length:
        return value
    raise FieldError(
        f"field id is {_shown(value)}; expected a text of at most {text_length} characters or a whole number"
    )


def _shown(value: Any) -> str:
    """A client's value for a sentence: short, and one line."""
    if isinstance(value, (dict, list)):
        return f"{'an object' if isinstance(value, dict) else 'an array'} of {len(value)}"
    if isinstance(value, str):
        cut = value if len(value) <= _SHOWN else f"{value[:_SHOWN]}..."
        return f"'{printable(cut)}'"
    if isinstance(value, bool) or value is None:
        return {True: "true", False: "false", None: "null"}[value]
    if isinstance(value, int) and value.bit_length() > 64:
        return "a number of more than 64 bits"
    return repr(value)


# -- kinds of fields


def _text(value: Any, longest: int) -> str:
    if isinstance(value, str) and len(value) <= longest:
        return value
    raise ValueError(f"a text of at most {longest} characters")


def _name(value: Any, longest: int) -> str:
    if isinstance(value, str) and 0 < len(value) <= longest:
        return value
    raise ValueError(f"a text of 1 to {longest} characters")


def _flag(value: Any, _longest: int) -> bool:
    if isinstance(value, bool):
        return value
    raise ValueError("true or false")


def _whole(least: int) -> Check:
    def check(value: Any, _longest: int) -> int:
        number = int(value) if isinstance(value, float) and value.is_integer() else value
        if type(number) is int and least <= number <= LARGEST:
            return number
        raise ValueError(f"a whole number from {least} to {LARGEST}")

    return check


def _seconds(value: Any, _longest: int) -> float | None:
    """roslib has every number at or below zero for "no time-out of mine"."""
    if type(value) in (int, float) and abs(value) <= LARGEST:  # not a NaN, nor an integer beyond floats
        return float(value) if value > 0 else None
    raise ValueError("a number of seconds")


def _number(value: Any, _longest: int) -> float:
    if type(value) in (int, float) and abs(value) <= 2**63:
        return float(value)
    raise ValueError("a number")


def _compression(value: Any, _longest: int) -> str:
    if isinstance(value, str) and value in _COMPRESSIONS:
        return value
    raise ValueError(f"one of {', '.join(_COMPRESSIONS)}")


def _level(value: Any, _longest: int) -> str:
    level = level_named(value) if isinstance(value, str) else None
    if level is not None:
        return level
    raise ValueError("one of none, error, warning, info")


def _arguments(value: Any, _longest: int) -> Any:
    if isinstance(value, (dict, list)):
        return value
    raise ValueError("an object by field, or an array by position")


def _status(value: Any, _longest: int) -> int:
    if type(value) is int and value in range(len(ActionStatus)):
        return value
    raise ValueError(f"a status of a goal, from 0 to {len(ActionStatus) - 1}")


def _anything(value: Any, _longest: int) -> Any:
    return value


# -- what becomes of them

_NOT_GIVEN = object()


def _split(asked: str) -> tuple[str, str | None]:
    """Old clients write `/rosapi/topics#33` for a call with the id 33."""
    name, mark, appended = asked.partition("#")
    return name, appended if mark else None


def _call_service(id: effects.Id, service: str, **given: Any) -> Effect:
    name, appended = _split(service)
    return effects.CallService(id=appended if id is None else id, service=name, asked=service, **given)


def _send_action_goal(id: effects.Id, action: str, **given: Any) -> Effect:
    name, appended = _split(action)
    return effects.SendActionGoal(id=appended if id is None else id, action=name, asked=action, **given)


def _cancel_action_goal(id: effects.Id, action: str) -> Effect:
    name, appended = _split(action)
    return effects.CancelActionGoal(appended if id is None else id, name)


def _publish(id: effects.Id, topic: str, msg: Any = _NOT_GIVEN, **given: Any) -> Effect:
    """Without `msg`: a message of defaults, as rosbridge has it."""
    return effects.Publish(id=id, topic=topic, msg={} if msg is _NOT_GIVEN else msg, **given)


def _service_response(id: effects.Id, service: str, result: bool = False, values: Any = None) -> Effect:
    """Without `result` it failed: roslib leaves it out where a page's callback returns nothing."""
    return effects.ServiceResponse(id, service, values, result)


_COUNT, _SIZE = _whole(0), _whole(1)

OPERATIONS: dict[str, Operation] = {
    "advertise": Operation(
        effects.Advertise,
        (
            Field("topic", _name, True),
            Field("type", _name, True),
            Field("latch", _flag),
            Field("queue_size", _COUNT),
        ),
    ),
    "unadvertise": Operation(effects.Unadvertise, (Field("topic", _name, True),)),
    "publish": Operation(
        _publish,
        (
            Field("topic", _name, True),
            Field("msg", _anything),
            Field("latch", _flag),
            Field("queue_size", _COUNT),
        ),
    ),
    "subscribe": Operation(
        effects.Subscribe,
        (
            Field("topic", _name, True),
            Field("type", _text),
            Field("throttle_rate", _COUNT),
            Field("queue_length", _COUNT),
            Field("fragment_size", _SIZE),
            Field("compression", _compression),
        ),
    ),
    "unsubscribe": Operation(effects.Unsubscribe, (Field("topic", _name, True),)),
    "call_service": Operation(
        _call_service,
        (
            Field("service", _name, True),
            Field("args", _arguments),
            Field("type", _text),
            Field("fragment_size", _SIZE),
            Field("compression", _compression),
            Field("timeout", _seconds),
        ),
    ),
    "advertise_service": Operation(
        effects.AdvertiseService, (Field("service", _name, True), Field("type", _name, True))
    ),
    "unadvertise_service": Operation(effects.UnadvertiseService, (Field("service", _name, True),)),
    "service_response": Operation(
        _service_response,
        (Field("service", _name, True), Field("values", _anything), Field("result", _flag)),
    ),
    "send_action_goal": Operation(
        _send_action_goal,
        (
            Field("action", _name, True),
            Field("action_type", _name, True),
            Field("args", _arguments),
            Field("feedback", _flag),
            Field("fragment_size", _SIZE),
            Field("compression", _compression),
        ),
    ),
    "cancel_action_goal": Operation(_cancel_action_goal, (Field("action", _name, True),)),
    "advertise_action": Operation(
        effects.AdvertiseAction, (Field("action", _name, True), Field("type", _name, True))
    ),
    "unadvertise_action": Operation(effects.UnadvertiseAction, (Field("action", _name, True),)),
    "action_feedback": Operation(
        effects.ActionFeedback, (Field("action", _name, True), Field("values", _anything))
    ),
    "action_result": Operation(
        effects.ActionResult,
        (
            Field("action", _name, True),
            Field("values", _anything),
            Field("status", _status),
            Field("result", _flag),
        ),
    ),
    "auth": Operation(
        effects.Auth,
        (
            Field("mac", _text, True),
            Field("client", _text),
            Field("dest", _text),
            Field("rand", _text),
            Field("t", _number),
            Field("level", _text),
            Field("end", _number),
        ),
    ),
    "set_level": Operation(effects.SetLevel, (Field("level", _level, True),)),
}
