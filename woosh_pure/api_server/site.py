"""`RobotSite`: what ROS 1 does not tell of a robot; its scene, map and marks as the Robot API has them."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

from rosproto.gateway import Refused
from rosproto.numeric import encode_png
from woosh_pure.maps.gridmap import GridMap
from woosh_pure.maps.marks import UserMark
from woosh_pure.robot_api.translate import pose_values
from woosh_pure.robot_api.wire import Values


@dataclass(frozen=True)
class RobotSite:
    """One scene with one map, and values that no topic tells.

    Attributes:
        scene, map: Their names.
        grid: Returns the map.
        marks: Returns its marks.
        facts: Returns values by type, such as DeviceState, or parts of values that are merged with those of
            topics. A type that is not in it stays not known.
        start_list: Begins a stored task list; returns why it did not, "" if it did.
    """

    scene: str
    map: str
    grid: Callable[[], GridMap]
    marks: Callable[[], Sequence[UserMark]]
    facts: Callable[[], Mapping[str, Values]] = dict
    start_list: Callable[[int], str] = lambda _: "this server knows no task lists"

    def answers(self) -> dict[str, Callable[[Values], Values]]:
        """The requests that it answers, by type."""
        return {
            "woosh.map.SceneList": lambda _: {"scenes": [{"name": self.scene, "maps": [self.map]}]},
            "woosh.map.SceneDataEasy": self._easy,
            "woosh.map.SceneData": self._data,
            "woosh.map.mark.storage.Find": self._find,
        }

    def present(self) -> Values:
        """The Scene in use."""
        return {"sceneName": self.scene, "mapId": 1, "mapName": self.map, "version": 1}

    def _with_map(self, asked: Values, **more: object) -> Values:
        if asked["name"] not in ("", self.scene):
            raise Refused(f"there is no scene {asked['name'][:100]!r}; there is: {self.scene}")
        return {"name": self.scene, "maps": [{"id": 1, "name": self.map, **more}]}

    def _easy(self, asked: Values) -> Values:
        lists: dict[str, list[Values]] = {"bases": [], "chargers": []}
        for mark in self.marks():
            lists["chargers" if mark.charger else "bases"].append(_place(mark))
        return self._with_map(asked, version=1, storages=lists)

    def _data(self, asked: Values) -> Values:
        self._with_map(asked)  # the map need not be fetched for another scene
        grid, marks = self.grid(), [_storage(mark) for mark in self.marks()]
        return self._with_map(
            asked,
            resolution=grid.resolution,
            origin=pose_values(grid.origin),
            mapPng=_picture(grid),
            markInfo={"version": 1, "storages": marks},
            fieldInfo={},
            pathInfo={},
        )

    def _find(self, asked: Values) -> Values:
        for mark in self.marks():
            if mark.name == asked["no"]:
                return _storage(mark)
        raise Refused(f"there is no mark {asked['no'][:100]!r}")


@lru_cache(maxsize=1)
def _picture(grid: GridMap) -> bytes:
    return encode_png(grid.to_grey())


def _place(mark: UserMark) -> Values:
    identity = {"id": zlib.crc32(mark.name.encode()), "no": mark.name, "desc": mark.note}
    if mark.pose is None:
        return {"identity": identity}
    return {"identity": identity, "pose": dict.fromkeys(("dock", "real"), pose_values(mark.pose))}


def _storage(mark: UserMark) -> Values:
    return {**_place(mark), "charger": {}} if mark.charger else _place(mark)
