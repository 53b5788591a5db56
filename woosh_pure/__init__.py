"""Drive a Woosh mobile chassis from any OS: `with Chassis("169.254.128.2") as chassis: ...`.

The names are imported with their first use (PEP 562): `Chassis` loads the network.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from rosproto.version import __version__ as __version__

if TYPE_CHECKING:
    from woosh_pure.chassis import Chassis
    from woosh_pure.errors import ChassisError, FirmwareLimit, GoalFailed, MotionRefused, StaleState
    from woosh_pure.geometry import Footprint, Pose2D, Velocity
    from woosh_pure.outcome import Outcome, OutcomeKind
    from woosh_pure.reasons import Readiness, Ready
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


_HOME = {
    "chassis": "Chassis",
    "errors": "ChassisError FirmwareLimit GoalFailed MotionRefused StaleState",
    "geometry": "Footprint Pose2D Velocity",
    "outcome": "Outcome OutcomeKind",
    "reasons": "Readiness Ready",
    "sim": "SimulatedChassis",
}
_MODULE_OF = {name: f"{__name__}.{module}" for module, names in _HOME.items() for name in names.split()}


def __getattr__(name: str) -> object:
    module = _MODULE_OF.get(name) or (f"{__name__}.{name}" if name in _HOME else None)
    if module is None:
        from woosh_pure.hints import NAMES, meant

        if right := meant(NAMES, name):  # `from woosh_pure import NAME` shows the text of an ImportError only
            raise ImportError(f"cannot import name {name!r} from {__name__!r}; use {right}", name=__name__)
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    found = import_module(module)
    return getattr(found, name) if name in _MODULE_OF else found


def __dir__() -> list[str]:
    return sorted(__all__)
