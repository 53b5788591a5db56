"""What the commands say about readiness: the chassis's own reasons, and whether there is a chassis at all."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosproto.errors import RosTimeout

if TYPE_CHECKING:
    from woosh_pure.chassis import Chassis
    from woosh_pure.readiness import Readiness

__all__ = ["is_there", "nobody_there", "readiness_of"]

_STEADY = 1.0  # seconds within which the measured velocity comes, also over a slow network


def is_there(chassis: Chassis) -> bool:
    """Whether somebody publishes its status; any master answers, also one without a chassis."""
    return chassis.status.heard or chassis.status.publishers > 0


def nobody_there(chassis: Chassis) -> str:
    """What to say when there is none."""
    return (
        f"nobody publishes {chassis.status.topic} at {chassis.master_uri}: no chassis runs there, or not all "
        "of it; try `woosh doctor`"
    )


def readiness_of(chassis: Chassis) -> Readiness:
    """`Chassis.readiness()`, but no without a chassis: scripts take "nothing known against it" for a yes."""
    from woosh_pure.readiness import Readiness, Reason

    found = chassis.readiness()
    if not is_there(chassis):
        missing = Reason("no_chassis", nobody_there(chassis))
    elif _is_silent(chassis):
        missing = Reason("silent", "nothing comes from the chassis: is it up? try `woosh doctor`")
    else:
        return found
    known = [reason for reason in found.reasons if reason.key != "unknown"]
    return Readiness((missing, *known))


def _is_silent(chassis: Chassis) -> bool:
    """Whether not even what it sends all the time comes: its nodes are registered, but do not run."""
    if chassis.status.heard or chassis.battery.heard:
        return False
    try:
        chassis.measured_velocity.wait(_STEADY, new=False)
    except RosTimeout:
        return True
    return False
