"""`ChassisFacts`: the current data of a chassis (position, battery, faults, maps, loads). Pure."""

from __future__ import annotations

import math
from dataclasses import dataclass

from woosh_pure.fleet.messages.elements import Node
from woosh_pure.fleet.order.vehicle_limits import AgvPosition

_PATH_ENDS = 0.5  # m from its node


@dataclass(frozen=True, slots=True)
class Load:
    """A load on the vehicle."""

    load_id: str = ""
    load_type: str = ""
    position: str = ""

    def to_json(self) -> dict[str, object]:
        """An entry of the state message."""
        given = {"loadId": self.load_id, "loadType": self.load_type, "loadPosition": self.position}
        return {key: value for key, value in given.items() if value}


@dataclass(frozen=True, slots=True)
class MapEntry:
    """A map on the vehicle."""

    map_id: str
    version: str = "1"
    enabled: bool = True

    def to_json(self) -> dict[str, object]:
        """An entry of the state message."""
        status = "ENABLED" if self.enabled else "DISABLED"
        return {"mapId": self.map_id, "mapVersion": self.version, "mapStatus": status}


@dataclass(slots=True)
class ChassisFacts:
    """The current data of a chassis.

    Attributes:
        position: m and rad in the map; None if not received yet.
        located: Whether the robot is localised.
        lost: Whether there is no contact with the robot.
        may_move: Without contact: whether it may be driving.
        velocity: vx, vy in m/s, wz in rad/s; None if not received yet.
        percent, voltage, charging: Of the battery; None if not received yet.
        emergency_stop, bumper: Whether they are active.
        faults: (sentence, severe) pairs of the active faults.
        loads: None if they are not known.
        zone_set: Id of the zone set of the chassis's map; "" if there is none.
        path: Corners (x, y) in m of the path that the chassis has planned for the current drive; may be
            empty.
        information: (type, text) pairs for the state's `information`.
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
    information: tuple[tuple[str, str], ...] = ()

    @property
    def alarms(self) -> tuple[object, ...]:
        """The data of which any change is published at once."""
        return self.emergency_stop, self.bumper, self.faults, self.charging

    def has_path_to(self, node: Node) -> bool:
        """Whether the path leads to this node, and not to one before.

        The position of a mark, a node without a position, is not known: any path counts.
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
