"""The errors that a state message reports: their types, levels and references. Pure.

The types are those that the standard names (chapter 6.6.3 and 6.6.4), and beside them those that fleet
managers know where it names none; see `Problem.kind`. References follow its chapter 7.1.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

MOST = 24
"""Problems told at a time; the oldest of those that an order has caused makes room."""
_LONGEST = 500  # characters of a description: what a peer sent is quoted in it


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
    STILL_MOVING = "stillMoving"  # a cancel or a pause waits, and the vehicle is not measured standing
    SPEED = "speedExceeded"  # it drove faster than the edge allows
    HELD = "orderHeld"  # after a restart of ours: it waits for stopPause or cancelOrder
    LOCALISATION = "localizationError"
    ROBOT_LOST = "robotLost"  # the chassis does not answer any more
    STORAGE = "storageError"  # orders cannot be kept on disk
    DROPPED = "messagesDropped"  # they came faster than they are read
    CHASSIS = "chassisError"  # a fault that the chassis tells


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
        references: (key, value) pairs: what it is about.
        level: WARNING passes by itself or with the next order; FATAL needs a person.
        hint: What to do next; told from version 2.1 on.
    """

    kind: str
    description: str
    references: tuple[tuple[str, str], ...] = ()
    level: str = Level.WARNING
    hint: str = ""

    def to_json(self, *, hints: bool = True) -> dict[str, Any]:
        """As the state message has it."""
        found: dict[str, Any] = {
            "errorType": self.kind,
            "errorReferences": [
                {"referenceKey": k, "referenceValue": v[:_LONGEST]} for k, v in self.references
            ],
            "errorDescription": self.description[:_LONGEST],
            "errorLevel": self.level,
        }
        if hints and self.hint:
            found["errorHint"] = self.hint
        return found

    @classmethod
    def from_json(cls, data: dict[str, Any]) -> Problem:
        """What `to_json` gave."""
        references = tuple((r["referenceKey"], r["referenceValue"]) for r in data["errorReferences"])
        return cls(
            data["errorType"],
            data["errorDescription"],
            references,
            data["errorLevel"],
            data.get("errorHint", ""),
        )

    def about(self, key: str) -> str | None:
        """The value of its first reference of that key."""
        return next((value for name, value in self.references if name == key), None)


@dataclass(frozen=True, slots=True)
class Problems:
    """The errors that are reported now: a bounded number, each once.

    Attributes:
        of_orders: Those that stay until an order is accepted (6.6.4).
        standing: Those that stay until whoever put them takes them back, by their keys.
    """

    of_orders: tuple[Problem, ...] = ()
    standing: tuple[tuple[str, Problem], ...] = ()

    def __iter__(self) -> Iterator[Problem]:
        return iter((*(problem for _, problem in self.standing), *self.of_orders))

    def __len__(self) -> int:
        return len(self.standing) + len(self.of_orders)

    def get(self, key: str) -> Problem | None:
        """The problem of a key; None where there is none."""
        return dict(self.standing).get(key)

    def added(self, problem: Problem) -> Problems:
        """With one that is reported until an order is accepted."""
        others = [each for each in self.of_orders if each != problem]
        return replace(self, of_orders=(*others, problem)[-MOST:])

    def with_key(self, key: str, problem: Problem | None) -> Problems:
        """With one that is reported until it is taken back with None."""
        known = dict(self.standing)
        if known.get(key) == problem:
            return self
        if problem is None:
            del known[key]
        else:
            known[key] = problem
        return replace(self, standing=tuple(known.items()))
