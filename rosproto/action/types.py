"""The message classes of an action type."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from rosproto.codec import DynamicMessage, Message, message_class
from rosproto.deprecation import former_parameters
from rosproto.errors import CodecError, DefinitionError
from rosproto.node.definitions.known_definitions import KnownDefinitions

Part = Message | Mapping[str, object]
"""A goal, a result or feedback as programs give it: a message, or a dict of its fields."""


@dataclass(frozen=True, slots=True)
class ActionType:
    """Message classes of an action, as actionlib's generator names them.

    Attributes:
        name: "package/FooAction".
        action_goal, action_result, action_feedback: Messages of the topics: header, id or status, and the
            part from the .action file.
        goal, result, feedback: The parts from the .action file.
        goal_id, status, status_array: Types of actionlib_msgs, as these classes use them.
    """

    name: str
    action_goal: type[DynamicMessage]
    action_result: type[DynamicMessage]
    action_feedback: type[DynamicMessage]
    goal: type[DynamicMessage]
    result: type[DynamicMessage]
    feedback: type[DynamicMessage]
    goal_id: type[DynamicMessage]
    status: type[DynamicMessage]
    status_array: type[DynamicMessage]


@former_parameters(revisions="definitions")
def action_type(action: type[Message] | str, definitions: KnownDefinitions | None = None) -> ActionType:
    """The message classes of an action type.

    Args:
        action: A `FooAction` class, "package/FooAction", or "package/Foo" as the .action file is named.
        definitions: Finds a type by name: a node's own folders come before the bundled types.

    Raises:
        DefinitionError: The type is unknown, or not an action.
    """
    cls = _class_of(action, definitions) if isinstance(action, str) else action
    try:
        goal, result, feedback = (_part(cls, f"action_{name}") for name in ("goal", "result", "feedback"))
        return ActionType(
            name=cls._type,
            action_goal=goal,
            action_result=result,
            action_feedback=feedback,
            goal=_part(goal, "goal"),
            result=_part(result, "result"),
            feedback=_part(feedback, "feedback"),
            goal_id=_part(goal, "goal_id"),
            status=_part(result, "status"),
            status_array=message_class("actionlib_msgs/GoalStatusArray"),
        )
    except AttributeError:
        raise DefinitionError(
            f"{cls._type} is not an action: it has no action_goal, action_result and action_feedback; "
            "give the FooAction class, not its goal"
        ) from None


def part_from(value: object, part: type[DynamicMessage], what: str) -> Any:
    """A goal, result or feedback message from a program's argument.

    Args:
        value: A message of the type (of any class with its name), or a dict of its fields.
        part: Class of the message.
        what: Description for the error text: "a goal of /move_base".

    Raises:
        CodecError: It is neither, or has an unknown field.
    """
    if isinstance(value, Mapping):
        try:
            return part(**value)
        except (AttributeError, TypeError) as error:
            raise CodecError(f"{what}: {error}", type_name=part._type) from None
    if getattr(value, "_type", None) == part._type:
        return value
    shown = getattr(value, "_type", type(value).__name__)
    fields = ", ".join(part.__slots__) or "no fields"
    raise CodecError(
        f"{what} is a {part._type} or a dict of its fields ({fields}), not a {shown}", type_name=part._type
    )


def _part(owner: type[Message], name: str) -> type[DynamicMessage]:
    """The class of a field; if possible without making a message, which would generate code."""
    binding: Any = getattr(owner, "_binding", None)
    for field in binding.spec.fields if binding is not None else ():
        if field.name == name and "/" in field.type.base and not field.type.is_array:
            part: type[DynamicMessage] = binding.class_for(field.type.base)
            return part
    return type(getattr(owner(), name))


def _class_of(name: str, definitions: KnownDefinitions | None) -> type[Message]:
    name = name if name.endswith("Action") else name + "Action"
    return message_class(name, definitions.library_for(name) if definitions is not None else None)
