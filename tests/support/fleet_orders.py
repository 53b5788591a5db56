"""Steps that several tests of the order machine share."""

from __future__ import annotations

from tests.support.fleet import LIMITS, PureVehicle
from woosh_pure.fleet.order.vehicle_limits import Capabilities

__all__ = ["finish_order", "kinds", "restart"]


def finish_order(vehicle: PureVehicle) -> None:
    while vehicle.drive is not None:
        vehicle.arrive()


def kinds(vehicle: PureVehicle) -> list[str]:
    return vehicle.problems


def restart(vehicle: PureVehicle, limits: Capabilities = LIMITS) -> PureVehicle:
    """Restart as after kill -9, with only the last content of the disk."""
    place = vehicle.state.position
    return PureVehicle(limits, kept=vehicle.disk.kept, x=0.0 if place is None else place.x)
