"""The simulated chassis: a pure world (`world`) and its ROS side (`SimulatedChassis`)."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from woosh_pure.sim.chassis import SimulatedChassis
    from woosh_pure.sim.settings import Settings
    from woosh_pure.sim.site import Mark, Site
    from woosh_pure.sim.world import World

__all__ = ["Mark", "Settings", "SimulatedChassis", "Site", "World"]

_HOME = {
    "Mark": "site",
    "Settings": "settings",
    "SimulatedChassis": "chassis",
    "Site": "site",
    "World": "world",
}


def __getattr__(name: str) -> object:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
