"""What happens to the order machine, and what it asks the vehicle to do. Frozen values.

Of the effects of an event, those that stop something come first, then `Write`, then `Tell`, then what begins
something. Whoever carries them out does so in this order. What follows `Write` must not be done when the
state cannot be written: then `DiskFailed` happens to the state of before, and the event to the state after
that.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Any

from woosh_pure.fleet.messages.elements import Action, Edge, InstantActions, Node, Order
from woosh_pure.fleet.messages.schema import Invalid
from woosh_pure.fleet.order.action_states import Scope
from woosh_pure.fleet.order.errors import Problem
from woosh_pure.fleet.order.tables import ActionStatus
from woosh_pure.fleet.order.vehicle_limits import AgvPosition

# -- events --------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class MalformedMessage:
    """A message does not fit (6.6.4.1); `data` is whatever of it can be read."""

    data: Mapping[str, Any]
    error: Invalid
    topic: str = "order"


@dataclass(frozen=True, slots=True)
class PositionMeasured:
    """The measured position; None while the vehicle does not know where it is."""

    position: AgvPosition | None


@dataclass(frozen=True, slots=True)
class StandingMeasured:
    """Whether the vehicle is measured standing; True only by what was measured after the last end of a drive,
    of a moving action or of a stop."""

    standing: bool


@dataclass(frozen=True, slots=True)
class Heard:
    """Whether the robot is heard. While it is not, nobody knows whether it stands."""

    heard: bool


@dataclass(frozen=True, slots=True)
class DriveEnded:
    """A drive is over, which does not say that the vehicle stands.

    Attributes:
        token: Of the drive; the end of one that was replaced changes nothing.
        arrived: Whether the chassis says that it arrived.
        text: Why it did not.
        known: False where the chassis may go on with it: the link was lost, or it has confirmed no end.
    """

    token: int
    arrived: bool
    text: str = ""
    known: bool = True


@dataclass(frozen=True, slots=True)
class DriveTooFast:
    """The drive under way is faster than its edge allows."""

    text: str


@dataclass(frozen=True, slots=True)
class StopEnded:
    """A `StopAll` is over; whether the robot stands."""

    standing: bool


@dataclass(frozen=True, slots=True)
class ActionProgress:
    """An action has come from its preparation to its work, pauses, or goes on."""

    action_id: str
    status: ActionStatus = ActionStatus.RUNNING


@dataclass(frozen=True, slots=True)
class ActionEnded:
    """An action is over; `known` as with `DriveEnded`."""

    action_id: str
    ok: bool
    text: str = ""
    known: bool = True


@dataclass(frozen=True, slots=True)
class ModeChanged:
    """The operating mode, as the chassis tells it."""

    mode: str


@dataclass(frozen=True, slots=True)
class MapsChanged:
    """Ids of the maps that are ENABLED."""

    maps: Collection[str]


@dataclass(frozen=True, slots=True)
class RetryDue:
    """The time of a `Retry` is over, or what stood in the way is."""


@dataclass(frozen=True, slots=True)
class DiskFailed:
    """The state cannot be written: nothing begins until it can."""

    problem: Problem


@dataclass(frozen=True, slots=True)
class DiskRecovered:
    """The state was written again."""


@dataclass(frozen=True, slots=True)
class ProblemChanged:
    """A problem of the vehicle itself is told, or taken back with None."""

    key: str
    problem: Problem | None


@dataclass(frozen=True, slots=True)
class Restarted:
    """The state was read from disk, after an end that was not in order."""


@dataclass(frozen=True, slots=True)
class ShutDown:
    """This program ends in order; the vehicle was halted."""

    text: str


Event = (
    Order | InstantActions | MalformedMessage | PositionMeasured | StandingMeasured | Heard | DriveEnded
    | DriveTooFast | StopEnded | ActionProgress | ActionEnded | ModeChanged | MapsChanged | RetryDue
    | DiskFailed | DiskRecovered | ProblemChanged | Restarted | ShutDown
)  # fmt: skip


# -- effects -------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Write:
    """Put the state on disk; what follows must not be done without it."""


@dataclass(frozen=True, slots=True)
class Tell:
    """Publish a state."""


@dataclass(frozen=True, slots=True)
class Drive:
    """Drive to a node, replacing a drive under way; its end is a `DriveEnded`."""

    token: int
    node: Node
    edge: Edge | None


@dataclass(frozen=True, slots=True)
class Halt:
    """Cancel the drive; its end is reported."""

    token: int


@dataclass(frozen=True, slots=True)
class StopAll:
    """Stop the chassis whatever it does, after so many seconds; its end is a `StopEnded`."""

    after: float


@dataclass(frozen=True, slots=True)
class Begin:
    """Begin an action; its end is an `ActionEnded`."""

    action: Action
    scope: Scope = field(default=Scope.INSTANT)


@dataclass(frozen=True, slots=True)
class End:
    """End a running action; its end is reported.

    Attributes:
        failed: False when its edge was left: that is its right end.
    """

    action_id: str
    failed: bool


@dataclass(frozen=True, slots=True)
class Retry:
    """`RetryDue` is to happen after so many seconds, or as soon as the vehicle can drive again."""

    after: float


@dataclass(frozen=True, slots=True)
class Factsheet:
    """Publish the factsheet."""


Effect = Write | Tell | Drive | Halt | StopAll | Begin | End | Retry | Factsheet


def stops(effect: Effect) -> bool:
    """Whether an effect ends something that was given up: it waits for no disk and no broker."""
    return isinstance(effect, (Halt, StopAll)) or (isinstance(effect, End) and effect.failed)
