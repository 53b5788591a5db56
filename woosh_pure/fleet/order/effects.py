"""What the order machine asks the vehicle to do. Pure values."""

from __future__ import annotations

from dataclasses import dataclass

from woosh_pure.fleet.messages.elements import Action, Edge, Node
from woosh_pure.fleet.order.actions import Scope

__all__ = ["Begin", "Changed", "Drive", "Effect", "End", "Factsheet", "Halt", "Retry", "StopAll"]


@dataclass(frozen=True, slots=True)
class Changed:
    """Something in the state message has changed: save the machine, then publish a state."""


@dataclass(frozen=True, slots=True)
class Drive:
    """Drive to a node, replacing a drive under way; report its end with `drive_ended(token, ...)`."""

    token: int
    node: Node
    edge: Edge | None


@dataclass(frozen=True, slots=True)
class Halt:
    """Cancel the drive, and report its end."""

    token: int


@dataclass(frozen=True, slots=True)
class Begin:
    """Begin an action; report its end with `action_ended(...)`."""

    action: Action
    scope: Scope


@dataclass(frozen=True, slots=True)
class End:
    """End a running action; report it with `action_ended(...)`.

    Attributes:
        failed: False when its edge was left: that is its right end.
    """

    action_id: str
    failed: bool


@dataclass(frozen=True, slots=True)
class StopAll:
    """Stop the chassis whatever it does, after so many seconds; report it with `stop_ended(...)`."""

    after: float


@dataclass(frozen=True, slots=True)
class Retry:
    """Call `retry()` after so many seconds, or as soon as the vehicle can drive again."""

    after: float


@dataclass(frozen=True, slots=True)
class Factsheet:
    """Publish the factsheet."""


Effect = Changed | Drive | Halt | Begin | End | Retry | Factsheet | StopAll
