"""`MapStore`: the maps of a vehicle (6.7), stored as files: add, enable, use and delete them.

A chassis has one map at a time. Its own map, present at the start, has the name of the configuration; others
are only stored. `enableMap` for another version of the map in use replaces that map (`set_map`, with the
robot's current pose). `enableMap` for another map only marks it ENABLED; `initPosition` with its id, as an
instant action or at a node, then switches the robot to it.
"""

from __future__ import annotations

import hashlib
import json
import threading
from dataclasses import replace
from pathlib import Path
from typing import Any

from rosproto.files import replace_file
from rosproto.logs import get_logger
from rosproto.sentence import say
from woosh_pure.errors import ChassisError
from woosh_pure.fleet.chassis_facts import MapEntry
from woosh_pure.maps.gridmap import GridMap

_log = get_logger("woosh_pure.fleet.action_handlers.map_store")
MOST_MAPS = 50


class MapStore:
    """The maps of one vehicle.

    Args:
        folder: Folder of the maps; created with the first one.
        own: The chassis's own map.

    Attributes:
        active: Id of the map in use.
    """

    def __init__(self, folder: Path, own: MapEntry) -> None:
        self.folder, self.own = folder, own
        self._lock = threading.RLock()
        self._entries: list[MapEntry] = [own]
        self.active, self.version = own.map_id, own.version
        self._load()

    @property
    def entries(self) -> tuple[MapEntry, ...]:
        """All maps, for the state message."""
        with self._lock:
            return tuple(self._entries)

    def find(self, map_id: str, version: str) -> MapEntry | None:
        """The entry of a map; None if it is not stored."""
        return next((each for each in self.entries if (each.map_id, each.version) == (map_id, version)), None)

    def enabled(self, map_id: str) -> MapEntry | None:
        """The enabled version of a map; None if there is none."""
        return next((each for each in self.entries if each.map_id == map_id and each.enabled), None)

    @property
    def enabled_ids(self) -> tuple[str, ...]:
        """Ids of the map in use and of all maps with an enabled version."""
        return tuple(dict.fromkeys([self.active, *(each.map_id for each in self.entries if each.enabled)]))

    def add(self, map_id: str, version: str, grid: GridMap) -> None:
        """Store a map, DISABLED.

        Raises:
            ChassisError: The map is stored already, or there are too many.
        """
        with self._lock:
            if self.find(map_id, version) is not None:
                raise ChassisError(
                    say(
                        "map {map_id} {version} is on the vehicle already; delete it first",
                        map_id=map_id,
                        version=version,
                    )
                )
            if len(self._entries) >= MOST_MAPS:
                raise ChassisError(
                    say("there are {most_maps} maps on the vehicle; delete one first", most_maps=MOST_MAPS)
                )
            self._write(map_id, version, grid)
            self._entries.append(MapEntry(map_id, version, enabled=False))
            self._save()

    def enable(self, map_id: str, version: str) -> None:
        """Enable one version of a map, and disable its other versions."""
        with self._lock:
            if self.find(map_id, version) is None:
                raise ChassisError(
                    say(
                        "map {map_id} {version} is not on the vehicle; download it first",
                        map_id=map_id,
                        version=version,
                    )
                )
            self._entries = [
                each if each.map_id != map_id else replace(each, enabled=each.version == version)
                for each in self._entries
            ]
            self._save()

    def delete(self, map_id: str, version: str) -> None:
        """Delete a map.

        Raises:
            ChassisError: The map is not stored, is enabled, or is the chassis's own.
        """
        with self._lock:
            found = self.find(map_id, version)
            if found is None:
                raise ChassisError(
                    say("map {map_id} {version} is not on the vehicle", map_id=map_id, version=version)
                )
            if found.enabled:
                raise ChassisError(
                    say(
                        "map {map_id} {version} is ENABLED; enable another version of it first",
                        map_id=map_id,
                        version=version,
                    )
                )
            if (map_id, version) == (self.own.map_id, self.own.version):
                raise ChassisError(
                    say(
                        "map {map_id} {version} is the chassis's own, and stays",
                        map_id=map_id,
                        version=version,
                    )
                )
            self._entries.remove(found)
            self._save()
            for path in self._place(map_id, version):
                path.unlink(missing_ok=True)

    def use(self, chassis: Any, map_id: str, version: str, pose: Any) -> None:
        """Store the chassis's current map, then set another one.

        Raises:
            ChassisError: The map is not stored, or the chassis refuses it.
            OSError: The current map cannot be stored.
        """
        with self._lock:
            if (self.active, self.version) == (map_id, version):
                return
            if not self._place(self.active, self.version)[0].exists():
                self._write(self.active, self.version, chassis.get_map())
            sheet = self._place(map_id, version)[0]
            if self.find(map_id, version) is None or not sheet.exists():
                raise ChassisError(
                    say(
                        "map {map_id} {version} is not on the vehicle; download it first",
                        map_id=map_id,
                        version=version,
                    )
                )
            chassis.set_map(GridMap.load(sheet), pose)
            self.active, self.version = map_id, version
            self._save()

    def confirm(self, chassis: Any) -> None:
        """After a restart, check that the chassis still has the map in use; else its own map is in use."""
        with self._lock:
            if (self.active, self.version) == (self.own.map_id, self.own.version):
                return
            try:
                given = GridMap.load(self._place(self.active, self.version)[0])
                same = _alike(chassis.get_map(), given)
                why = "it has another"
            except Exception as error:
                same, why = False, str(error)
            if not same:
                _log.warning("! the chassis has not the map %s any more: %s", self.active, why)
                self.active, self.version = self.own.map_id, self.own.version
                self.enable(self.active, self.version)

    # -- the disk --------------------------------------------------------------------------------------------

    def _place(self, map_id: str, version: str) -> tuple[Path, Path]:
        name = hashlib.sha256(json.dumps([map_id, version]).encode()).hexdigest()[:24]
        return self.folder / f"{name}.yaml", self.folder / f"{name}.pgm"

    def _write(self, map_id: str, version: str, grid: GridMap) -> None:
        self.folder.mkdir(parents=True, exist_ok=True)
        grid.save(self._place(map_id, version)[0])

    def _save(self) -> None:
        self.folder.mkdir(parents=True, exist_ok=True)
        data = {"active": [self.active, self.version], "maps": [each.to_json() for each in self._entries]}
        beside = self.folder / "index.new"
        beside.write_text(json.dumps(data), "utf-8")
        replace_file(beside, self.folder / "index.json")

    def _load(self) -> None:
        path = self.folder / "index.json"
        try:
            data = json.loads(path.read_text("utf-8"))
            found = [
                MapEntry(str(raw["mapId"]), str(raw["mapVersion"]), raw["mapStatus"] == "ENABLED")
                for raw in data["maps"]
            ]
            active, version = data["active"]
        except FileNotFoundError:
            return
        except (OSError, ValueError, KeyError, TypeError) as error:
            _log.warning("! %s cannot be used: %s", path, error)
            return
        there = [each for each in found if self._place(each.map_id, each.version)[0].exists()]
        known = {(each.map_id, each.version) for each in found}
        own = (self.own.map_id, self.own.version)
        if own not in known:
            enabled = not any(each.map_id == own[0] and each.enabled for each in there)
            there.insert(0, MapEntry(*own, enabled))
        elif not any((each.map_id, each.version) == own for each in there):
            there.insert(0, next(each for each in found if (each.map_id, each.version) == own))
        self._entries = there
        if any((each.map_id, each.version) == (active, version) for each in there):
            self.active, self.version = str(active), str(version)


def _alike(one: GridMap, other: GridMap) -> bool:
    """Compare as pictures: a file only keeps free, occupied and unknown cells."""
    return one.cells.shape == other.cells.shape and bool((one.to_grey() == other.to_grey()).all())
