"""What one robot names by its Robot API, for the page: its marks, maps, zones and outline.

It is asked in the background and only while somebody wants to know, because a robot may answer slowly or not
at all. Nobody who looks at the robot's ROS side waits for it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TypeVar

from rosproto.logs import get_logger
from rosproto.text import printable
from woosh_pure.chassis import Chassis
from woosh_pure.errors import ApiRefused
from woosh_pure.maps.marks import UserMark
from woosh_pure.robot_api.background import Background
from woosh_pure.robot_api.values import Outline, Scene, Zone
from woosh_pure.web.snapshot import points_part

T = TypeVar("T")
FRESH, FIRST_SECONDS = 5.0, 2.0
"""Seconds after which the robot is asked again; and how long a first request waits for its answer."""
_logger = get_logger("woosh_pure.web")


@dataclass(frozen=True, slots=True)
class SiteFacts:
    """What the robot has named, and the marks and zones of its map; empty without a Robot API."""

    scene: Scene | None = None
    scenes: tuple[Scene, ...] = ()
    marks: tuple[UserMark, ...] = ()
    zones: tuple[Zone, ...] = ()
    outline: Outline | None = None

    def as_json(self) -> dict[str, object]:
        """Maps and zones as the API sends them."""
        scene = self.scene
        return {
            "scene": scene and printable(scene.name),
            "map": scene and printable(scene.current_map),
            "scenes": [{"name": each.name, "maps": list(each.maps)} for each in self.scenes],
            "zones": [
                {"kind": zone.kind, "max_speed": zone.max_speed, "points": points_part(zone.polygon)}
                for zone in self.zones
            ],
        }


_NOTHING = SiteFacts()


class RobotSite:
    """Asks one robot, and keeps what it has named. From any thread."""

    def __init__(self, chassis: Chassis) -> None:
        self._chassis = chassis
        self._asked = Background(self._news, FRESH)

    def known(self, wait: float = 0.0) -> SiteFacts:
        """What is known; `wait` is that of `Background.want`."""
        return self._asked.want(wait) or _NOTHING

    def switch(self, scene: str, name: str) -> Scene:
        """Let the robot use another map; blocks until it does. See `RobotApi.switch_map`."""
        try:
            return self._chassis.robot_api.switch_map(scene, name)
        finally:
            self._asked.ask_again()

    def _news(self) -> SiteFacts:
        api, facts = self._chassis.robot_api, self._asked.answer or _NOTHING
        scene = api.scene()
        if scene != facts.scene:  # its version counts uploads
            here = ("", scene.current_map)
            facts = SiteFacts(
                scene,
                tuple(_if_offered(api.scenes) or ()),
                tuple(mark.as_user_mark() for mark in _if_offered(api.marks) or () if mark.map in here),
                tuple(zone for zone in _if_offered(api.zones) or () if zone.map in here),
            )
        return replace(facts, outline=_if_offered(api.outline))


def _if_offered(ask: Callable[[], T]) -> T | None:
    """Ask for what an older robot may refuse; None if it does."""
    try:
        return ask()
    except ApiRefused as refused:
        _logger.debug("= %s", refused)
        return None
