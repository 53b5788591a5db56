"""`Overlay`: draws the state of a chassis as markers in its map: pose, state, faults, and your marks. Pure.

Foxglove, Lichtblick and RViz show markers (visualization_msgs/MarkerArray).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from msgdefs.geometry_msgs.msg import Point, Pose, Quaternion, Vector3
from msgdefs.std_msgs.msg import ColorRGBA, Header
from msgdefs.visualization_msgs.msg import Marker, MarkerArray
from rosproto.time import Time
from woosh_pure.enums import RobotState
from woosh_pure.faults import StatusCode
from woosh_pure.geometry import Pose2D, quaternion_from_yaw
from woosh_pure.maps.marks import UserMark
from woosh_pure.values.state import Battery, RobotStatus

__all__ = ["Overlay", "OverlayState"]

MAX_FAULTS, MAX_MARKS = 8, 500
TEXT_HEIGHT = 0.3  # m: 13 pixels at the distance of the layout's camera
GREEN, AMBER, RED, BLUE, GREY = (
    (0.2, 0.8, 0.3),
    (1.0, 0.7, 0.0),
    (1.0, 0.4, 0.4),  # light enough to be read on the black that viewers put behind texts
    (0.25, 0.55, 1.0),
    (0.6, 0.6, 0.6),
)
_COLOURS = {RobotState.WARNING: AMBER, RobotState.FAULT: RED}
_FRAME = "map"


@dataclass(frozen=True, slots=True)
class OverlayState:
    """The state to draw; None where a value is unknown.

    Attributes:
        pose: The robot's, in the map.
        status: Its state and task.
        battery: Its charge.
        faults: The active faults, the worst first.
        marks: The user's marks; those without a pose are not drawn.
        old: Age of the pose in seconds, if it is outdated.
    """

    pose: Pose2D | None = None
    status: RobotStatus | None = None
    battery: Battery | None = None
    faults: Sequence[StatusCode] = ()
    marks: Sequence[UserMark] = ()
    old: float | None = None

    def sentence(self) -> str:
        """The text over the robot: state, task and charge."""
        words = [str(self.status.robot_state) if self.status else "state not known"]
        if self.status is not None and self.status.destination:
            words.append(f"to {self.status.destination}")
        if self.battery is not None:
            words.append(f"{self.battery.percent} %")
        if self.old is not None:
            words.append(f"pose {self.old:.0f} s old")
        return " · ".join(words)

    @property
    def colour(self) -> tuple[float, float, float]:
        """The robot's colour; grey while its state is not known."""
        if self.faults:
            return RED
        return GREY if self.status is None else _COLOURS.get(self.status.robot_state, GREEN)


class Overlay:
    """Makes the markers of a state, and deletes outdated markers of earlier states.

    Args:
        language: Language of the texts of faults, "en" or "zh".
    """

    def __init__(self, language: str = "en") -> None:
        self._language = language
        self._drawn: set[tuple[str, int]] = set()

    def markers(self, state: OverlayState, stamp: Time) -> MarkerArray:
        """A `MarkerArray` that replaces the previous state with this one."""
        made = [*self._robot(state), *self._faults(state), *self._marks(state.marks)]
        names = {(one.ns, one.id) for one in made}
        gone = [Marker(ns=ns, id=n, action=Marker.DELETE) for ns, n in sorted(self._drawn - names)]
        self._drawn = names
        for one in (*made, *gone):
            one.header = Header(stamp=stamp, frame_id=one.header.frame_id or _FRAME)
        return MarkerArray(markers=[*made, *gone])

    def _robot(self, state: OverlayState) -> list[Marker]:
        if state.pose is None:
            return []
        where, colour = state.pose, state.colour
        return [
            _marker("robot", 0, Marker.CYLINDER, _at(where, 0.1), (0.6, 0.6, 0.2), colour, alpha=0.5),
            _marker("robot", 1, Marker.ARROW, _at(where, 0.25), (0.7, 0.12, 0.12), colour),
            _text("robot", 2, _at(where, 0.8), state.sentence(), colour),
        ]

    def _faults(self, state: OverlayState) -> list[Marker]:
        where = state.pose or Pose2D(0.0, 0.0, 0.0)
        made = []
        for number, fault in enumerate(state.faults[:MAX_FAULTS]):
            words = fault.chinese if self._language == "zh" else fault.english
            code = f"{fault.code:012d}"
            line = words if code in words else f"{words} ({code})"  # the text of an unknown code is the code
            # Lines must not overlap seen from 40 degrees above, as in the layout.
            height = 1.4 + 2.0 * TEXT_HEIGHT * number
            made.append(_text("fault", number, _at(where, height), line, RED))
        return made

    def _marks(self, marks: Sequence[UserMark]) -> list[Marker]:
        made = []
        placed = [mark for mark in marks if mark.pose is not None]
        for number, mark in enumerate(placed[:MAX_MARKS]):
            assert mark.pose is not None
            made += [
                _marker("mark", 2 * number, Marker.ARROW, _at(mark.pose, 0.03), (0.4, 0.06, 0.06), BLUE),
                _text("mark", 2 * number + 1, _at(mark.pose, 0.3), mark.name, BLUE),
            ]
        return made


def _at(pose: Pose2D, height: float) -> Pose:
    yaw = pose.yaw if math.isfinite(pose.yaw) else 0.0
    x, y, z, w = quaternion_from_yaw(yaw)
    return Pose(position=Point(x=pose.x, y=pose.y, z=height), orientation=Quaternion(x=x, y=y, z=z, w=w))


def _marker(
    ns: str,
    number: int,
    kind: int,
    pose: Pose,
    size: tuple[float, float, float],
    colour: tuple[float, float, float],
    *,
    alpha: float = 1.0,
) -> Marker:
    return Marker(
        ns=ns,
        id=number,
        type=kind,
        action=Marker.ADD,
        pose=pose,
        scale=Vector3(x=size[0], y=size[1], z=size[2]),
        color=ColorRGBA(r=colour[0], g=colour[1], b=colour[2], a=alpha),
    )


def _text(ns: str, number: int, pose: Pose, text: str, colour: tuple[float, float, float]) -> Marker:
    made = _marker(ns, number, Marker.TEXT_VIEW_FACING, pose, (0.0, 0.0, TEXT_HEIGHT), colour)
    made.text = text
    return made
