"""What is known of a chassis, beside its order. Pure."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

from woosh_pure.fleet.messages.elements import Node
from woosh_pure.fleet.order.vehicle_limits import AgvPosition

_PATH_ENDS = 0.5  # m from its node


@dataclass(frozen=True, slots=True)
class Load:
    """A load on the vehicle, as pick and drop have left it."""

    load_id: str = ""
    load_type: str = ""
    position: str = ""

    def to_json(self) -> dict[str, Any]:
        """As the state has it."""
        given = {"loadId": self.load_id, "loadType": self.load_type, "loadPosition": self.position}
        return {key: value for key, value in given.items() if value}


@dataclass(frozen=True, slots=True)
class MapEntry:
    """A map on the vehicle."""

    map_id: str
    version: str = "1"
    enabled: bool = True

    def to_json(self) -> dict[str, Any]:
        """As the state has it."""
        status = "ENABLED" if self.enabled else "DISABLED"
        return {"mapId": self.map_id, "mapVersion": self.version, "mapStatus": status}


@dataclass(slots=True)
class ChassisFacts:
    """What is known of the chassis.

    Attributes:
        position: m and rad in the map; None while it was not heard.
        located: Whether the robot knows where it is.
        lost: Whether nothing is heard of the robot.
        may_move: While it is lost: whether it may be driving, because it was, or was told to.
        velocity: vx, vy in m/s, wz in rad/s; None while it was not heard.
        percent, voltage, charging: Of the battery; None while it was not heard.
        emergency_stop, bumper: As the chassis tells them.
        faults: Sentences of the faults that it tells, each with whether it is severe.
        loads: None where nothing tells them.
        zone_set: Of the chassis's map; "" where there is none.
        path: Corners (x, y) in m of the way that the chassis has planned for the drive under way; empty where
            it has told none.
        information: (type, text) pairs for people.
    """

    position: AgvPosition | None = None
    located: bool = False
    lost: bool = False
    may_move: bool = False
    velocity: tuple[float, float, float] | None = None
    percent: float | None = None
    voltage: float | None = None
    charging: bool = False
    emergency_stop: bool = False
    bumper: bool = False
    faults: tuple[tuple[str, bool], ...] = ()
    loads: tuple[Load, ...] | None = None
    maps: tuple[MapEntry, ...] = ()
    map_id: str = ""
    zone_set: str = ""
    path: tuple[tuple[float, float], ...] = ()
    information: tuple[tuple[str, str], ...] = field(default_factory=tuple)

    @property
    def alarms(self) -> tuple[object, ...]:
        """What is so urgent that any change of it sends a state."""
        return self.emergency_stop, self.bumper, self.faults, self.charging

    def has_path_to(self, node: Node) -> bool:
        """Whether the path is one to this node, and not one to a node before.

        Of a node without a position, a mark, only the chassis knows where it is: there any path counts.
        """
        place = node.position
        if len(self.path) < 2 or place is None:
            return len(self.path) > 1
        (x, y), radius = self.path[-1], max(place.deviation_xy, _PATH_ENDS)
        return math.hypot(x - place.x, y - place.y) <= radius

    @property
    def moving(self) -> bool:
        """Whether the robot drives or turns."""
        return self.velocity is not None and (
            abs(self.velocity[0]) > 0.01 or abs(self.velocity[1]) > 0.01 or abs(self.velocity[2]) > 0.02
        )
