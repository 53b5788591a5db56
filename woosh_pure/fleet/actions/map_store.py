"""The maps on a vehicle (6.7): downloaded, enabled, deleted, as files beside its state.

A chassis has one map at a time. The one it has when we come is its own, by the name of the configuration;
others lie on a shelf. `enableMap` of another version of the map in use replaces it (`set_map`, with the pose
that the robot has); of a map that is not in use it only marks it, and `initPosition` with its id takes the
robot there. So a map that is ENABLED and not in use changes nothing, and orders are for the map in use.

A map comes as one file, as the standard wants it: a ZIP of a map_server YAML and its picture. What is in it
is read with limits, and written anew: no name out of it becomes a name on this disk.
"""

from __future__ import annotations

import hashlib
import io
import json
import os
import tempfile
import threading
import zipfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any
from urllib.error import URLError
from urllib.parse import urlsplit
from urllib.request import Request, urlopen

from rosproto.logs import get_logger
from rosproto.text import printable
from woosh_pure.errors import ChassisError
from woosh_pure.fleet.state import MapEntry
from woosh_pure.gridmap import GridMap

__all__ = ["MapShelf", "fetch", "unpack"]

_log = get_logger("woosh_pure.fleet.actions.map_store")
MOST_DOWNLOAD = 64_000_000
"""Bytes of a file that is downloaded."""
MOST_UNPACKED = 256_000_000
"""Bytes of what is in it."""
MOST_MAPS = 50
_SILENCE = 20.0  # s without a byte after which a download has failed
_HASHES = {32: "md5", 40: "sha1", 64: "sha256", 128: "sha512"}  # by their hexadecimal digits


def fetch(link: str, cancelled: Callable[[], bool], digest: str = "") -> bytes:
    """A file of a map server.

    Args:
        link: http:// or https://; nothing else is opened, no file of this computer either.
        cancelled: Whether to give up; asked between two pieces.
        digest: In hexadecimal digits: MD5, SHA-1, SHA-256 or SHA-512 by their number; "" checks nothing.

    Raises:
        ChassisError: It could not be fetched, is too large, or is not what the digest says.
    """
    where = printable(link)[:200]
    if urlsplit(link).scheme not in ("http", "https") or not urlsplit(link).hostname:
        raise ChassisError(f"mapDownloadLink {where}: expected http:// or https://")
    kind = _HASHES.get(len(digest)) if digest else "sha256"
    if kind is None:
        raise ChassisError(
            f"mapHash of {len(digest)} characters: expected 32, 40, 64 or 128 hexadecimal digits"
        )
    found = bytearray()
    try:
        with urlopen(Request(link), timeout=_SILENCE) as reply:
            while piece := reply.read(65536):
                found += piece
                if len(found) > MOST_DOWNLOAD:
                    raise ChassisError(f"{where}: more than {MOST_DOWNLOAD} bytes; send a smaller map")
                if cancelled():
                    raise ChassisError("the download was cancelled")
    except (OSError, ValueError, URLError) as error:
        raise ChassisError(f"{where} could not be fetched: {error}") from error
    if digest and hashlib.new(kind, found).hexdigest() != digest.lower():
        raise ChassisError(f"{where}: what came is not what mapHash says ({kind})")
    return bytes(found)


def unpack(data: bytes) -> GridMap:
    """The map in a ZIP of a map_server YAML and its picture.

    Raises:
        ChassisError: It is no such file.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as packed, tempfile.TemporaryDirectory() as folder:
            infos = [info for info in packed.infolist() if not info.is_dir()]
            if sum(info.file_size for info in infos) > MOST_UNPACKED:
                raise ChassisError(f"the map is larger than {MOST_UNPACKED} bytes when unpacked")
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
        raise ChassisError(f"the file is no ZIP of a map: {error}") from error
    except (ValueError, RuntimeError) as error:
        raise ChassisError(f"the map cannot be read: {error}") from error


class MapShelf:
    """The maps of one vehicle.

    Args:
        folder: Where they are; made when the first one comes.
        own: The map that the chassis has by itself.

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
        """As the state tells them."""
        with self._lock:
            return tuple(self._entries)

    def find(self, map_id: str, version: str) -> MapEntry | None:
        """One of them."""
        return next((each for each in self.entries if (each.map_id, each.version) == (map_id, version)), None)

    def enabled(self, map_id: str) -> MapEntry | None:
        """The version of a map that is enabled."""
        return next((each for each in self.entries if each.map_id == map_id and each.enabled), None)

    def add(self, map_id: str, version: str, grid: GridMap) -> None:
        """Put a map on the shelf, DISABLED.

        Raises:
            ChassisError: It is there already, or the shelf is full.
        """
        with self._lock:
            if self.find(map_id, version) is not None:
                raise ChassisError(f"map {map_id} {version} is on the vehicle already; delete it first")
            if len(self._entries) >= MOST_MAPS:
                raise ChassisError(f"there are {MOST_MAPS} maps on the vehicle; delete one first")
            self._write(map_id, version, grid)
            self._entries.append(MapEntry(map_id, version, enabled=False))
            self._save()

    def enable(self, map_id: str, version: str) -> None:
        """Mark one version of a map as enabled, and the others of it as not."""
        with self._lock:
            if self.find(map_id, version) is None:
                raise ChassisError(f"map {map_id} {version} is not on the vehicle; download it first")
            self._entries = [
                each if each.map_id != map_id else replace(each, enabled=each.version == version)
                for each in self._entries
            ]
            self._save()

    def delete(self, map_id: str, version: str) -> None:
        """Take a map off the shelf.

        Raises:
            ChassisError: It is not there, is enabled, or is the chassis's own.
        """
        with self._lock:
            found = self.find(map_id, version)
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

    def put_on(self, chassis: Any, map_id: str, version: str, pose: Any) -> None:
        """Give the chassis another map, and keep the one that it had.

        Raises:
            ChassisError: It is not on the vehicle, or the chassis refuses.
            OSError: What it had cannot be kept.
        """
        with self._lock:
            if (self.active, self.version) == (map_id, version):
                return
            if not self._place(self.active, self.version)[0].exists():
                self._write(self.active, self.version, chassis.get_map())
            sheet = self._place(map_id, version)[0]
            if self.find(map_id, version) is None or not sheet.exists():
                raise ChassisError(f"map {map_id} {version} is not on the vehicle; download it first")
            chassis.set_map(GridMap.load(sheet), pose)
            self.active, self.version = map_id, version
            self._save()

    def confirm(self, chassis: Any) -> None:
        """After a restart of ours: whether the chassis still has the map that it was given, or its own."""
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
        os.replace(beside, self.folder / "index.json")

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
    """By their pictures: a file keeps no more of a map than free, occupied and not known."""
    return one.cells.shape == other.cells.shape and bool((one.to_grey() == other.to_grey()).all())
