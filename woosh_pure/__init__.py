"""Drive a Woosh mobile chassis from any OS: `with Chassis("169.254.128.2") as chassis: ...`.

Importing this package is cheap; names load on first use.
"""

from __future__ import annotations

from rosproto.late import late_names
from rosproto.version import __version__ as __version__

TYPE_CHECKING = False  # as in typing, which takes longer to load than all of this
if TYPE_CHECKING:
    from woosh_pure.chassis import Chassis
    from woosh_pure.errors import ChassisError, FirmwareLimit, GoalFailed, MotionRefused, StaleState
    from woosh_pure.geometry import Footprint, Pose2D, Velocity
    from woosh_pure.outcome import Outcome, OutcomeKind
    from woosh_pure.readiness import Readiness, Ready
    from woosh_pure.sim import SimulatedChassis

__all__ = [
    "Chassis",
    "ChassisError",
    "FirmwareLimit",
    "Footprint",
    "GoalFailed",
    "MotionRefused",
    "Outcome",
    "OutcomeKind",
    "Pose2D",
    "Readiness",
    "Ready",
    "SimulatedChassis",
    "StaleState",
    "Velocity",
]

__getattr__ = late_names(
    __name__,
    {
        "Chassis": "chassis",
        "ChassisError": "errors",
        "FirmwareLimit": "errors",
        "Footprint": "geometry",
        "GoalFailed": "errors",
        "MotionRefused": "errors",
        "Outcome": "outcome",
        "OutcomeKind": "outcome",
        "Pose2D": "geometry",
        "Readiness": "readiness",
        "Ready": "readiness",
        "SimulatedChassis": "sim",
        "StaleState": "errors",
        "Velocity": "geometry",
    },
)


def __dir__() -> list[str]:
    return sorted(__all__)
