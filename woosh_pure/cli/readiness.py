"""Readiness for the commands: the chassis's reasons, and whether a chassis exists."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosproto.errors import RosTimeout
from rosproto.sentence import say
from woosh_pure.cli.output import Output
from woosh_pure.reasons import Readiness, Reason, ReasonKey

if TYPE_CHECKING:
    from woosh_pure.chassis import Chassis


_STEADY = 1.0  # s; maximum wait for the measured velocity, also over a slow network


def is_there(chassis: Chassis) -> bool:
    """Whether the chassis's status is published; a master without a chassis answers, too."""
    return chassis.status.heard or chassis.status.publishers > 0


def nobody_there(chassis: Chassis) -> str:
    """Return the sentence for a missing or unreachable chassis."""
    if why := chassis.status.unreachable:
        return say(
            "{topic} is published at {uri}, but its publisher cannot be reached: {why}; try `woosh doctor`",
            topic=chassis.status.topic,
            uri=chassis.master_uri,
            why=why,
        )
    return say(
        "nobody publishes {topic} at {uri}: no chassis runs there, or not all of it; try `woosh doctor`",
        topic=chassis.status.topic,
        uri=chassis.master_uri,
    )


_WORDS = {
    "yes": ("ready", "yes", "green"),
    "no": ("NOT READY", "NO", "red"),
    "not known": ("NOT KNOWN whether it is ready", "NOT KNOWN", "yellow"),
}


def verdict(readiness: Readiness, out: Output, *, short: bool = False) -> str:
    """Return the answer in one or a few words, coloured."""
    long_word, short_word, colour = _WORDS[readiness.answer.value]
    return out.colour(short_word if short else long_word, colour)


def as_json(readiness: Readiness) -> bool | None:
    """Return True, False, or None (null) if unknown."""
    return {"yes": True, "no": False}.get(readiness.answer.value)


def readiness_of(chassis: Chassis) -> Readiness:
    """Return `Chassis.readiness()`, but no without a chassis: scripts would read "unknown" as yes."""

    found = chassis.readiness()
    if not is_there(chassis):
        key = ReasonKey.UNREACHABLE if chassis.status.unreachable else ReasonKey.NO_CHASSIS
        missing = Reason(key, nobody_there(chassis))
    elif _is_silent(chassis):
        missing = Reason(ReasonKey.SILENT, "nothing comes from the chassis: is it up? try `woosh doctor`")
    else:
        return found
    known = [reason for reason in found.reasons if reason.key != ReasonKey.UNKNOWN]
    return Readiness((missing, *known))


def _is_silent(chassis: Chassis) -> bool:
    """Whether periodic topics are silent, too: then its nodes are registered, but do not run."""
    if chassis.status.heard or chassis.battery.heard:
        return False
    try:
        chassis.measured_velocity.wait(_STEADY, new=False)
    except RosTimeout:
        return True
    return False
