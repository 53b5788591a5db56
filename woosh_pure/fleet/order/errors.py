"""The errors that a state message reports: their types, levels and references. Pure.

The types are those of the standard (6.6.3, 6.6.4); where it has none, those that fleet managers know.
References follow chapter 7.1.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from rosproto.text import short

MAX_ERRORS = 24
"""Order problems in one state message; the oldest are dropped."""
_MAX_CHARACTERS = 500  # characters of a description, which may quote a received message


class ErrorType:
    """Values of `errorType`."""

    VALIDATION = "validationError"  # 6.6.4.1, and a malformed instantActions
    ORDER = "orderError"  # 6.6.4.2: cannot be done, or not now
    ORDER_UPDATE = "orderUpdateError"  # 6.6.4.3, and an update that does not continue the order
    NO_ROUTE = "noRouteError"  # the first node is out of reach, or a map is not here
    NO_ORDER_TO_CANCEL = "noOrderToCancel"  # 6.6.3.2
    ORDER_ACTION = "orderActionError"  # an action of the order has failed
    INSTANT_ACTION = "instantActionError"  # an instant action cannot be done, or has failed
    DRIVE = "driveError"  # a node was not reached
    STILL_MOVING = "stillMoving"  # a cancel or pause waits, because the vehicle is not measured standing
    SPEED = "speedExceeded"  # it drove faster than the edge allows
    HELD = "orderHeld"  # after a restart or a stop by somebody else: it waits for stopPause or cancelOrder
    ROBOT_LOST = "robotLost"  # no messages of the chassis arrive
    STORAGE = "storageError"  # orders cannot be kept on disk
    DROPPED = "messagesDropped"  # they arrived faster than they are read
    CHASSIS = "chassisError"  # a fault that the chassis reports


class Level:
    """Values of `errorLevel`."""

    WARNING = "WARNING"
    FATAL = "FATAL"


@dataclass(frozen=True, slots=True)
class Problem:
    """One entry of the state's `errors`.

    Attributes:
        kind: `errorType`.
        description: A sentence: what happened, what was expected.
        references: What it refers to, by key.
        level: WARNING ends by itself or with the next order; FATAL needs a person.
        hint: What to do next; since version 2.1.
    """

    kind: str
    description: str
    references: Mapping[str, str] = field(default_factory=dict)
    level: str = Level.WARNING
    hint: str = ""

    def to_json(self, *, hints: bool = True) -> dict[str, object]:
        """An entry of the state's `errors`."""
        found: dict[str, object] = {
            "errorType": self.kind,
            "errorReferences": [
                {"referenceKey": k, "referenceValue": v[:_MAX_CHARACTERS]} for k, v in self.references.items()
            ],
            "errorDescription": short(self.description, _MAX_CHARACTERS),
            "errorLevel": self.level,
        }
        if hints and self.hint:
            found["errorHint"] = self.hint
        return found

    @classmethod
    def from_json(cls, data: dict[str, Any]) -> Problem:
        """Restore from the output of `to_json`."""
        references = {each["referenceKey"]: each["referenceValue"] for each in data["errorReferences"]}
        return cls(
            data["errorType"],
            data["errorDescription"],
            references,
            data["errorLevel"],
            data.get("errorHint", ""),
        )


@dataclass(frozen=True, slots=True)
class Problems:
    """The errors that are reported now, each once.

    Attributes:
        of_orders: Problems that stay until an order is accepted (6.6.4), at most `MAX_ERRORS`.
        standing: (key, problem) pairs that stay until the problem of the key is removed.
    """

    of_orders: tuple[Problem, ...] = ()
    standing: tuple[tuple[str, Problem], ...] = ()

    def __iter__(self) -> Iterator[Problem]:
        return iter((*(problem for _, problem in self.standing), *self.of_orders))

    def get(self, key: str) -> Problem | None:
        """The problem with a key; None if there is none."""
        return dict(self.standing).get(key)

    def added(self, problem: Problem) -> Problems:
        """A copy with a problem that is reported until an order is accepted."""
        others = [each for each in self.of_orders if each != problem]
        return replace(self, of_orders=(*others, problem)[-MAX_ERRORS:])

    def with_key(self, key: str, problem: Problem | None) -> Problems:
        """A copy with another problem for a key; None removes it."""
        known = dict(self.standing)
        if known.get(key) == problem:
            return self
        if problem is None:
            del known[key]
        else:
            known[key] = problem
        return replace(self, standing=tuple(known.items()))
