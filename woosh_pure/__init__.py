"""Drive a Woosh mobile chassis from any OS: `with Chassis("169.254.128.2") as chassis: ...`.

`Chassis` and `SimulatedChassis` are imported with their first use: they load the network.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosproto.version import __version__ as __version__
from woosh_pure.errors import ChassisError, FirmwareLimit, GoalFailed, MotionRefused, StaleState
from woosh_pure.geometry import Footprint, Pose2D, Velocity
from woosh_pure.outcome import Outcome, OutcomeKind
from woosh_pure.reasons import Readiness, Ready

if TYPE_CHECKING:
    from woosh_pure.chassis import Chassis
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


def __getattr__(name: str) -> object:
    """Import `Chassis` and `SimulatedChassis` on first use (PEP 562)."""
    if name == "Chassis":
        from woosh_pure.chassis import Chassis

        return Chassis
    if name == "SimulatedChassis":
        from woosh_pure.sim import SimulatedChassis

        return SimulatedChassis
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
