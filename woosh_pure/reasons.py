"""Whether the chassis would move (yes, no or not known) and the reasons, as values."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum

from rosproto.sentence import both, say, shown
from woosh_pure.language import Spoken

__all__ = ["Readiness", "Ready", "Reason", "ReasonKey"]


class Ready(Enum):
    """Whether the chassis would move now."""

    YES = "yes"
    NO = "no"
    UNKNOWN = "not known"

    def __str__(self) -> str:
        """Its value."""
        return self.value


class ReasonKey(str, Enum):
    """The subject of a `Reason`; equal to its text, so that `reason.key == "bumper"` works, too."""

    EMERGENCY_STOP = "emergency_stop"
    BUMPER = "bumper"
    MANUAL_MODE = "manual_mode"
    NOT_IN_TASK_MODE = "not_in_task_mode"
    NOT_LOCALISED = "not_localised"
    MAPPING = "mapping"
    NO_MAP = "no_map"
    OCCUPIED = "occupied"
    """The robot is marked as occupied (by its Robot API)."""
    NOT_TASKABLE = "not_taskable"
    """The robot takes no task now (by its Robot API)."""
    CHARGING_CABLE = "charging_cable"
    FAULT = "fault"
    BUSY = "busy"
    """A task of ours is under way."""
    OTHER_CLIENT = "other_client"
    """Another client commands the robot."""
    CHASSIS_KEY = "chassis_key"
    """A key of the chassis is triggered; which one is not documented."""
    REFUSED = "refused"
    """The last motion was refused or failed, and nothing has shown since that the cause is over."""
    UNKNOWN = "unknown"
    """The chassis has not reported its state."""
    LINK_LOST = "link_lost"
    """The link to the publisher of its state is lost: the last report may be out of date."""
    NO_CHASSIS = "no_chassis"
    """No node on this ROS master publishes the state of a chassis."""
    SILENT = "silent"
    """The chassis is registered at the master but sends nothing."""
    UNREACHABLE = "unreachable"
    """The chassis is registered at the master, but its nodes cannot be reached."""
    CALL = "call"
    """The call itself: wrong values, a `stop()` in the meantime, or another motion of this program."""

    def __str__(self) -> str:
        """Its text, on every Python."""
        return self.value


@dataclass(frozen=True, slots=True)
class Reason:
    """One reason against moving, or one because of which the answer is not known.

    Attributes:
        key: Its subject, for programs.
        text: The same in words, for people.
        blocking: True when it makes the answer "no".
        doubt: True when it makes the answer "not known". With neither flag it is only information (a task is
            running, a warning).
    """

    key: str
    text: str
    blocking: bool = True
    doubt: bool = False

    def doubted(self) -> Reason:
        """Return the reason as one that may be over: it no longer blocks, and the answer is not known."""
        return replace(self, blocking=False, doubt=self.blocking or self.doubt)


@dataclass(frozen=True, slots=True)
class Readiness(Spoken):
    """Whether the chassis would move: yes, no, or not known.

    Attributes:
        reasons: The reasons against moving, and the unknown facts. Empty when every source has been heard and
            none speaks against it.
    """

    reasons: tuple[Reason, ...] = ()

    @property
    def answer(self) -> Ready:
        """Yes only when the chassis itself has reported its state and nothing blocks."""
        if self.blocked:
            return Ready.NO
        return Ready.UNKNOWN if any(reason.doubt for reason in self.reasons) else Ready.YES

    @property
    def ready(self) -> bool:
        """True when the answer is yes; False when it is no or not known."""
        return self.answer is Ready.YES

    @property
    def blocked(self) -> bool:
        """True when a known reason blocks motion. "Not known" does not block: the chassis then decides."""
        return any(reason.blocking for reason in self.reasons)

    @property
    def refuses(self) -> bool:
        """True when a verb must not even ask the chassis. After an earlier refusal it may ask again."""
        return any(reason.blocking and reason.key != ReasonKey.REFUSED for reason in self.reasons)

    def __bool__(self) -> bool:
        return self.ready

    def __str__(self) -> str:
        """All reasons in one line."""
        if not self.reasons:
            return say("nothing is known to prevent it from moving")
        return shown(both(*(reason.text for reason in self.reasons)))
