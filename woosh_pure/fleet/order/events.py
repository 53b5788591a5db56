"""The input of the order machine (events) and its output (effects), as frozen values."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import NamedTuple

from woosh_pure.fleet.messages.elements import Action, Edge, InstantActions, Node, Order
from woosh_pure.fleet.messages.parsing import Invalid
from woosh_pure.fleet.order.errors import Problem
from woosh_pure.fleet.order.vehicle_limits import AgvPosition

# -- events --------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class MalformedMessage:
    """A message is malformed (6.6.4.1); `data` is its JSON object, empty if it has none."""

    data: Mapping[str, object]
    error: Invalid
    topic: str = "order"


@dataclass(frozen=True, slots=True)
class PositionMeasured:
    """The measured position; None if the vehicle is not localised."""

    position: AgvPosition | None


@dataclass(frozen=True, slots=True)
class StandingMeasured:
    """Whether the vehicle was measured standing after the last end of a drive, a moving action or a stop."""

    standing: bool


@dataclass(frozen=True, slots=True)
class ContactChanged:
    """Contact with the robot was lost or regained. Without contact it is not known whether it stands."""

    heard: bool


@dataclass(frozen=True, slots=True)
class DriveEnded:
    """A drive has ended; the vehicle may still be moving.

    Attributes:
        token: The drive's token; the end of a replaced drive changes nothing.
        arrived: Whether the chassis reports an arrival.
        text: Why it did not arrive.
        known: False if the chassis may still be driving: the link was lost, or the end was not confirmed.
        by_others: Whether another program or the robot itself has cancelled or replaced it.
    """

    token: int
    arrived: bool
    text: str = ""
    known: bool = True
    by_others: bool = False


@dataclass(frozen=True, slots=True)
class DriveTooFast:
    """The current drive is faster than its edge allows."""

    text: str


@dataclass(frozen=True, slots=True)
class StopEnded:
    """A `StopAll` has ended; whether the robot stands."""

    standing: bool


@dataclass(frozen=True, slots=True)
class ActionEnded:
    """An action has ended; `known` and `by_others` as in `DriveEnded`."""

    action_id: str
    ok: bool
    text: str = ""
    known: bool = True
    by_others: bool = False


@dataclass(frozen=True, slots=True)
class StoppedByOthers:
    """Somebody else has stopped the chassis: a person, or another part of the program."""


@dataclass(frozen=True, slots=True)
class ModeChanged:
    """The operating mode that the chassis reports."""

    mode: str


@dataclass(frozen=True, slots=True)
class MapsChanged:
    """Ids of the maps that are ENABLED."""

    maps: Collection[str]


@dataclass(frozen=True, slots=True)
class RetryDue:
    """The time of a `ScheduleRetry` is over, or the obstacle is gone."""


@dataclass(frozen=True, slots=True)
class DiskFailed:
    """The state cannot be saved: nothing is started until it can."""

    problem: Problem


@dataclass(frozen=True, slots=True)
class DiskRecovered:
    """The state can be saved again."""


@dataclass(frozen=True, slots=True)
class ProblemChanged:
    """A problem of the vehicle itself has come, or has gone (None)."""

    key: str
    problem: Problem | None


@dataclass(frozen=True, slots=True)
class Restarted:
    """The state was read from disk after an unclean end of the program."""


@dataclass(frozen=True, slots=True)
class ShutDown:
    """The program ends cleanly; the vehicle was halted."""

    text: str


Event = (
    Order | InstantActions | MalformedMessage | PositionMeasured | StandingMeasured | ContactChanged
    | DriveEnded | DriveTooFast | StopEnded | ActionEnded | StoppedByOthers | ModeChanged | MapsChanged
    | RetryDue | DiskFailed | DiskRecovered | ProblemChanged | Restarted | ShutDown
)  # fmt: skip


# -- effects -------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class PublishState:
    """Publish a state message."""


@dataclass(frozen=True, slots=True)
class Drive:
    """Drive to a node and replace the current drive; ends with a `DriveEnded`."""

    token: int
    node: Node
    edge: Edge | None


@dataclass(frozen=True, slots=True)
class Halt:
    """Cancel the drive; ends with a `DriveEnded`."""

    token: int


@dataclass(frozen=True, slots=True)
class StopAll:
    """Stop every motion of the chassis after `after` seconds; ends with a `StopEnded`."""

    after: float


@dataclass(frozen=True, slots=True)
class BeginAction:
    """Begin an action; ends with an `ActionEnded`."""

    action: Action


@dataclass(frozen=True, slots=True)
class EndAction:
    """End a running action; ends with an `ActionEnded`."""

    action_id: str


@dataclass(frozen=True, slots=True)
class ScheduleRetry:
    """Send `RetryDue` after `after` seconds, or as soon as the vehicle can drive again."""

    after: float


@dataclass(frozen=True, slots=True)
class PublishFactsheet:
    """Publish the factsheet."""


Effect = PublishState | Drive | Halt | StopAll | BeginAction | EndAction | ScheduleRetry | PublishFactsheet


class Effects(NamedTuple):
    """What follows from an event. It is carried out in this order.

    If the state cannot be saved, what comes afterwards is discarded: `DiskFailed` is applied to the old
    state, then the event to the result.

    Attributes:
        stops: What stops a drive or an action.
        saves: Whether the state must be saved on disk.
        publishes: Whether a state message is published.
        begins: All others.
    """

    stops: list[Effect]
    saves: bool
    publishes: bool
    begins: list[Effect]
