"""What the order machine asks of whoever carries its decisions out. Pure values."""

from __future__ import annotations

from dataclasses import dataclass

from woosh_pure.fleet.messages.elements import Action, Edge, Node
from woosh_pure.fleet.order.actions import Scope

__all__ = ["Begin", "Changed", "Drive", "Effect", "End", "Factsheet", "Halt", "Retry"]


@dataclass(frozen=True, slots=True)
class Changed:
    """Something that the state message tells has changed: put the machine on disk, then send a state."""


@dataclass(frozen=True, slots=True)
class Drive:
    """Drive to a node; tell the end with `drive_ended(token, ...)`. It replaces a drive under way."""

    token: int
    node: Node
    edge: Edge | None


@dataclass(frozen=True, slots=True)
class Halt:
    """End the drive, and tell its end when the vehicle stands."""

    token: int


@dataclass(frozen=True, slots=True)
class Begin:
    """Begin an action; tell its end with `action_ended(...)`."""

    action: Action
    scope: Scope


@dataclass(frozen=True, slots=True)
class End:
    """End an action that runs; tell it with `action_ended(...)`.

    Attributes:
        failed: False when its edge was left: that is its right end.
    """

    action_id: str
    failed: bool


@dataclass(frozen=True, slots=True)
class Retry:
    """Call `retry()` after so many seconds, or when the vehicle can drive again."""

    after: float


@dataclass(frozen=True, slots=True)
class Factsheet:
    """Send the factsheet."""


Effect = Changed | Drive | Halt | Begin | End | Retry | Factsheet
