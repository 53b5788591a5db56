"""The maps of a vehicle (6.7): `MapStore` keeps them as files; `fetch` and `unpack` get the fleet manager's.

A chassis has one map at a time. Its own map, present at the start, has the name of the configuration; others
are only stored. `enableMap` for another version of the map in use replaces that map (`set_map`, with the
robot's current pose). `enableMap` for another map only marks it ENABLED; `initPosition` with its id, as an
instant action or at a node, then switches the robot to it.

A map archive is a ZIP of a map_server YAML and its picture. Sizes are limited, and files are unpacked to a
temporary folder without their paths.
"""

from __future__ import annotations

import hashlib
import io
import json
import threading
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from urllib.parse import urlsplit

from rosproto.files import save_file
from rosproto.logs import get_logger
from rosproto.text import printable
from woosh_pure.chassis import Chassis
from woosh_pure.errors import ChassisError
from woosh_pure.fleet.chassis_facts import MapEntry
from woosh_pure.geometry import Pose2D
from woosh_pure.maps.gridmap import GridMap

_log = get_logger("woosh_pure.fleet.action_handlers.maps")
MAX_MAPS = 50
MAX_DOWNLOAD = 64_000_000
"""Largest download, bytes."""
MAX_UNPACKED = 256_000_000
"""Largest size of the unpacked files, bytes."""
_SILENCE = 20.0  # s without a byte after which a download has failed
_HASHES = {32: "md5", 40: "sha1", 64: "sha256", 128: "sha512"}  # by their hexadecimal digits


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

    def _find(self, map_id: str, version: str) -> MapEntry | None:
        return next((each for each in self.entries if (each.map_id, each.version) == (map_id, version)), None)

    def enabled(self, map_id: str) -> MapEntry | None:
        """The enabled version of a map; None if there is none."""
        return next((each for each in self.entries if each.map_id == map_id and each.enabled), None)

    @property
    def enabled_ids(self) -> tuple[str, ...]:
        """Ids of the map in use and of all maps with an enabled version."""
        return tuple(dict.fromkeys([self.active, *(each.map_id for each in self.entries if each.enabled)]))

    def require_room(self, map_id: str, version: str) -> None:
        """Raise `ChassisError` if a map is stored already, or there are too many."""
        if self._find(map_id, version) is not None:
            raise ChassisError(f"map {map_id} {version} is on the vehicle already; delete it first")
        if len(self.entries) >= MAX_MAPS:
            raise ChassisError(f"there are {MAX_MAPS} maps on the vehicle; delete one first")

    def require_stored(self, map_id: str, version: str) -> None:
        """Raise `ChassisError` if a map is not stored."""
        if self._find(map_id, version) is None:
            raise _not_stored(map_id, version)

    def add(self, map_id: str, version: str, grid: GridMap) -> None:
        """Store a map, DISABLED; raises as `require_room`."""
        with self._lock:
            self.require_room(map_id, version)
            self._write(map_id, version, grid)
            self._entries.append(MapEntry(map_id, version, enabled=False))
            self._save()

    def enable(self, map_id: str, version: str) -> None:
        """Enable one version of a map, and disable its other versions; raises as `require_stored`."""
        with self._lock:
            self.require_stored(map_id, version)
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
            found = self._find(map_id, version)
            if found is None:
                raise ChassisError(f"map {map_id} {version} is not on the vehicle")
            if found.enabled:
                raise ChassisError(f"map {map_id} {version} is ENABLED; enable another version of it first")
            if (map_id, version) == (self.own.map_id, self.own.version):
                raise ChassisError(f"map {map_id} {version} is the chassis's own, and stays")
            self._entries.remove(found)
            self._save()
            for path in self._place(map_id, version):
                path.unlink(missing_ok=True)

    def use(self, chassis: Chassis, map_id: str, version: str, pose: Pose2D | None) -> None:
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
            if not sheet.exists():
                raise _not_stored(map_id, version)
            chassis.set_map(GridMap.load(sheet), pose)
            self.active, self.version = map_id, version
            self._save()

    def confirm(self, chassis: Chassis) -> None:
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
        data = {"active": [self.active, self.version], "maps": [each.to_json() for each in self._entries]}
        save_file(self.folder / "index.json", json.dumps(data).encode())

    def _load(self) -> None:
        """Read the index. Maps without a file are forgotten, except the chassis's own."""
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
        own = (self.own.map_id, self.own.version)
        there = {
            (each.map_id, each.version): each
            for each in found
            if (each.map_id, each.version) == own or self._place(each.map_id, each.version)[0].exists()
        }
        if own not in there:
            enabled = not any(each.map_id == own[0] and each.enabled for each in there.values())
            there = {own: MapEntry(*own, enabled), **there}
        self._entries = list(there.values())
        if (active, version) in there:
            self.active, self.version = str(active), str(version)


def _not_stored(map_id: str, version: str) -> ChassisError:
    return ChassisError(f"map {map_id} {version} is not on the vehicle; download it first")


def _alike(one: GridMap, other: GridMap) -> bool:
    """Compare as pictures: a file only keeps free, occupied and unknown cells."""
    return one.cells.shape == other.cells.shape and bool((one.to_grey() == other.to_grey()).all())


# -- map archives --------------------------------------------------------------------------------------------


def fetch(link: str, cancelled: Callable[[], bool], digest: str = "") -> bytes:
    """Download a file.

    Args:
        link: An http:// or https:// URL; others are refused.
        cancelled: Called between two blocks; True ends the download.
        digest: MD5, SHA-1, SHA-256 or SHA-512 in hexadecimal digits, chosen by the length; "" checks nothing.

    Raises:
        ChassisError: The download failed, is too large, or does not match the digest.
    """
    from http.client import HTTPException  # imported late: not needed to start a vehicle
    from urllib.request import Request, urlopen

    where = printable(link)[:200]
    if urlsplit(link).scheme not in ("http", "https") or not urlsplit(link).hostname:
        raise ChassisError(f"mapDownloadLink {where}: expected http:// or https://")
    kind = _HASHES.get(len(digest), "")
    if digest and not kind:
        raise ChassisError(
            f"mapHash of {len(digest)} characters: expected 32, 40, 64 or 128 hexadecimal digits"
        )
    found = bytearray()
    try:
        with urlopen(Request(link), timeout=_SILENCE) as reply:
            while piece := reply.read(65536):
                found += piece
                if len(found) > MAX_DOWNLOAD:
                    raise ChassisError(f"{where}: more than {MAX_DOWNLOAD} bytes; send a smaller map")
                if cancelled():
                    raise ChassisError("the download was cancelled")
    except (OSError, ValueError, HTTPException) as error:
        raise ChassisError(f"{where} could not be fetched: {error}") from error
    if digest and hashlib.new(kind, found).hexdigest() != digest.lower():
        raise ChassisError(f"{where}: what came is not what mapHash says ({kind})")
    return bytes(found)


def unpack(data: bytes) -> GridMap:
    """Read the map from an archive.

    Raises:
        ChassisError: The data is not a map archive.
    """
    import tempfile
    import zipfile

    try:
        with zipfile.ZipFile(io.BytesIO(data)) as packed, tempfile.TemporaryDirectory() as folder:
            infos = [info for info in packed.infolist() if not info.is_dir()]
            if sum(info.file_size for info in infos) > MAX_UNPACKED:
                raise ChassisError(f"the map is larger than {MAX_UNPACKED} bytes when unpacked")
            names = [Path(info.filename.replace("\\", "/")).name for info in infos]
            sheets = [name for name in names if name.lower().endswith((".yaml", ".yml"))]
            if len(sheets) != 1 or len(set(names)) != len(names):
                listed = ", ".join(printable(name) for name in names[:10]) or "nothing"
                raise ChassisError(
                    f"a map is a ZIP of one YAML of map_server and its picture; in this are {listed}"
                )
            for info, name in zip(infos, names, strict=True):
                (Path(folder) / name).write_bytes(packed.read(info))
            return GridMap.load(Path(folder) / sheets[0], beside=True)
    except (zipfile.BadZipFile, zipfile.LargeZipFile, NotImplementedError, EOFError, OSError) as error:
        raise ChassisError(f"the file is not a ZIP of a map: {error}") from error
    except (ValueError, RuntimeError) as error:
        raise ChassisError(f"the map cannot be read: {error}") from error
