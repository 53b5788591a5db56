"""Maps of a vehicle: fetched, unpacked, stored, enabled, deleted."""

from __future__ import annotations

import hashlib
import io
import json
import socket
import threading
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from rosproto.errors import RosTimeout
from tests.support.fleet_maps import packed as packed_map
from tests.support.fleet_maps import serving
from woosh_pure.errors import ChassisError
from woosh_pure.fleet.action_handlers import maps
from woosh_pure.fleet.action_handlers.maps import MapStore, fetch, unpack
from woosh_pure.fleet.action_handlers.predefined_actions import supported_actions
from woosh_pure.fleet.action_handlers.running_action import Handler, Task
from woosh_pure.fleet.chassis_facts import MapEntry
from woosh_pure.fleet.config import VehicleConfig
from woosh_pure.fleet.messages.elements import Action
from woosh_pure.geometry import Pose2D
from woosh_pure.maps import GridMap

HERE = Pose2D(1.0, 2.0, 0.5)


def grid(fill: int = 0) -> GridMap:
    cells = np.zeros((20, 30), np.int8)
    cells[0, : fill + 1] = 100
    return GridMap(cells, 0.1, Pose2D(-1.0, -1.0))


def packed(folder: Path, given: GridMap | None = None, **more: bytes) -> bytes:
    return packed_map(folder, given or grid(), **more)


class Robot:
    """Of a chassis what map actions use."""

    def __init__(self) -> None:
        self.map, self.poses = grid(), []  # type: tuple[GridMap, list[Pose2D]]
        self.refuses = False
        self.heard: Pose2D | None = None  # where it takes itself to be, whatever it is told

    def get_map(self) -> GridMap:
        return self.map

    def set_map(self, given: GridMap, pose: Pose2D) -> None:
        if self.refuses:
            raise ChassisError("set_map: the chassis refused: it drives")
        self.map = given
        self.poses.append(pose)

    def set_pose(self, pose: Pose2D) -> None:
        self.poses.append(pose)

    @property
    def pose(self) -> Robot:
        return self

    def wait(self, timeout: float, new: bool = True) -> Pose2D:
        return HERE

    def wait_for(self, accept: Callable[[Pose2D], bool], timeout: float) -> Pose2D:
        if self.heard is not None and not accept(self.heard):
            raise RosTimeout("no pose came", what="a pose", seconds=timeout)
        assert self.heard is not None or accept(self.poses[-1])
        return self.poses[-1]

    @property
    def known(self) -> Any:
        return SimpleNamespace(value=self.heard)


@pytest.fixture
def shelf(tmp_path: Path) -> MapStore:
    return MapStore(tmp_path / "shelf", MapEntry("hall", "1"))


def told(shelf: MapStore) -> list[tuple[str, str, bool]]:
    return [(each.map_id, each.version, each.enabled) for each in shelf.entries]


@pytest.fixture
def served(tmp_path: Path) -> Iterator[str]:
    """A map server with /good.zip."""
    with serving(packed(tmp_path / "made", grid(3))) as address:
        yield address


def handlers(shelf: MapStore | None) -> dict[str, Handler]:
    config = VehicleConfig(manufacturer="W", serial="1", map_id="hall")
    return {name: handler for name, (_, handler) in supported_actions(config, maps=shelf).items()}


def task(robot: Robot, **parameters: Any) -> Task:
    chassis: Any = robot
    return Task(Action("a", "x", "NONE", parameters), chassis, [])


def test_a_map_is_downloaded_enabled_and_deleted(shelf: MapStore, served: str) -> None:
    """DISABLED at first; enabled it replaces the map in use, where the robot is; the other can be had again."""
    robot, do = Robot(), handlers(shelf)
    first = robot.map
    do["downloadMap"](task(robot, mapId="hall", mapVersion="2", mapDownloadLink=f"{served}/good.zip"))
    assert told(shelf) == [("hall", "1", True), ("hall", "2", False)]
    assert robot.poses == [], "nothing is changed by a download"
    assert do["enableMap"](task(robot, mapId="hall", mapVersion="2")) == "in use"
    assert told(shelf) == [("hall", "1", False), ("hall", "2", True)]
    assert robot.poses == [HERE]
    assert int((robot.map.cells > 50).sum()) == 4
    with pytest.raises(ChassisError, match="ENABLED"):
        do["deleteMap"](task(robot, mapId="hall", mapVersion="2"))
    with pytest.raises(ChassisError, match="own"):
        do["deleteMap"](task(robot, mapId="hall", mapVersion="1"))
    do["enableMap"](task(robot, mapId="hall", mapVersion="1"))
    assert (robot.map.cells == first.cells).all()
    do["deleteMap"](task(robot, mapId="hall", mapVersion="2"))
    assert told(shelf) == [("hall", "1", True)]
    with pytest.raises(ChassisError, match="not on the vehicle"):
        do["deleteMap"](task(robot, mapId="hall", mapVersion="2"))
    assert not [path for path in shelf.folder.iterdir() if path.suffix == ".pgm" and path.stat().st_size == 0]


def test_what_is_there_already_is_not_downloaded(shelf: MapStore, served: str) -> None:
    """6.7.3: it is deleted first."""
    with pytest.raises(ChassisError, match="already"):
        handlers(shelf)["downloadMap"](
            task(Robot(), mapId="hall", mapVersion="1", mapDownloadLink=f"{served}/good.zip")
        )


@pytest.mark.parametrize(
    ("theta", "sentence"),
    [
        (90.0, "theta 90: expected an angle of -pi to pi, in rad"),
        (
            3.0,
            "x 1.000 m, y 2.000 m, yaw 0.0° in map: 0.00 m and 172° away from the pose that it was given, ",
        ),
        (
            -1.0,
            "0.00 m and 57° away from the pose that it was given, x 1.000 m, y 2.000 m, yaw -57.3° in map",
        ),
    ],
)
def test_init_position_with_a_wrong_heading_says_so(theta: float, sentence: str) -> None:
    """In degrees, or another one than that in which the robot finds itself."""
    robot = Robot()
    robot.heard = Pose2D(1.0, 2.0, 0.0)
    with pytest.raises(ChassisError) as failed:
        handlers(None)["initPosition"](task(robot, mapId="hall", x=1.0, y=2.0, theta=theta))
    assert sentence in str(failed.value)


def test_another_map_is_taken_by_init_position(shelf: MapStore) -> None:
    """Enabling a map that is not in use changes nothing; initPosition with its id takes the robot there."""
    robot, do = Robot(), handlers(shelf)
    shelf.add("up", "1", grid(5))
    where = {"x": 0.5, "y": 0.0, "theta": 0.0}
    with pytest.raises(ChassisError, match="ENABLED"):
        do["initPosition"](task(robot, mapId="up", **where))
    assert "initPosition" in (do["enableMap"](task(robot, mapId="up", mapVersion="1")) or "")
    assert (robot.poses, shelf.active) == ([], "hall")
    do["initPosition"](task(robot, mapId="up", **where))
    assert (robot.poses, shelf.active) == ([Pose2D(0.5, 0.0, 0.0)], "up")
    assert told(shelf) == [("hall", "1", True), ("up", "1", True)]
    do["initPosition"](task(robot, mapId="hall", **where))
    assert (int((robot.map.cells > 50).sum()), shelf.active) == (1, "hall")


def test_a_map_that_is_not_there_is_none_to_stand_in() -> None:
    """Also where maps are not the fleet manager's: before, any mapId was let pass."""
    with pytest.raises(ChassisError, match="no map up"):
        handlers(None)["initPosition"](task(Robot(), mapId="up", x=0.0, y=0.0, theta=0.0))


def test_a_chassis_that_refuses_leaves_all_as_it_was(shelf: MapStore) -> None:
    """The map that is reported as in use is in use."""
    robot = Robot()
    robot.refuses = True
    shelf.add("hall", "2", grid(5))
    with pytest.raises(ChassisError, match="refused"):
        handlers(shelf)["enableMap"](task(robot, mapId="hall", mapVersion="2"))
    assert (shelf.version, told(shelf)) == ("1", [("hall", "1", True), ("hall", "2", False)])


def test_maps_outlive_the_process_if_the_robot_has_them_still(shelf: MapStore, tmp_path: Path) -> None:
    """A robot that was switched off may have its own map again: then that one is in use, and reported."""
    robot = Robot()
    shelf.add("hall", "2", grid(5))
    handlers(shelf)["enableMap"](task(robot, mapId="hall", mapVersion="2"))
    again = MapStore(shelf.folder, MapEntry("hall", "1"))
    again.confirm(robot)
    assert (again.version, told(again)) == ("2", [("hall", "1", False), ("hall", "2", True)])
    again.confirm(Robot())
    assert (again.version, told(again)) == ("1", [("hall", "1", True), ("hall", "2", False)])


@pytest.mark.parametrize("text", ["", "[]", '{"maps": 3}', "\0"])
def test_an_index_that_makes_no_sense_is_an_empty_shelf(tmp_path: Path, text: str) -> None:
    """And no traceback at the start."""
    (tmp_path / "index.json").write_text(text)
    assert told(MapStore(tmp_path, MapEntry("hall", "1"))) == [("hall", "1", True)]


def test_a_hash_is_compared(served: str, tmp_path: Path) -> None:
    """By the number of its digits."""
    data = fetch(f"{served}/good.zip", lambda: False)
    for kind in ("md5", "sha1", "sha256", "sha512"):
        assert fetch(f"{served}/good.zip", lambda: False, hashlib.new(kind, data).hexdigest().upper()) == data
    for digest, match in (("0" * 64, "not what mapHash says"), ("abc", "mapHash of 3")):
        with pytest.raises(ChassisError, match=match):
            fetch(f"{served}/good.zip", lambda: False, digest)


@pytest.mark.promise("an http or https address, from which", "no other file is read for it")
@pytest.mark.parametrize("link", ["file:///etc/passwd", "ftp://h/x", "/etc/passwd", "http://", "data:,x"])
def test_only_web_servers_are_asked(link: str) -> None:
    """No file of this computer becomes a map."""
    with pytest.raises(ChassisError, match="expected http"):
        fetch(link, lambda: False)


@pytest.mark.promise("an http or https address, from which")
def test_a_download_is_bounded_and_can_be_cancelled(served: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """In size; and what is not there is said."""
    with pytest.raises(ChassisError, match="cancelled"):
        fetch(f"{served}/good.zip", lambda: True)
    with pytest.raises(ChassisError, match="404"):
        fetch(f"{served}/other.zip", lambda: False)
    with pytest.raises(ChassisError, match="could not be fetched"):
        fetch("http://127.0.0.1:1/x", lambda: False)
    monkeypatch.setattr(maps, "MAX_DOWNLOAD", 10)
    with pytest.raises(ChassisError, match="more than 10 bytes"):
        fetch(f"{served}/good.zip", lambda: False)


@pytest.mark.promise("an http or https address, from which")
def test_a_server_that_does_not_speak_http_is_one_sentence() -> None:
    """As any other download that fails."""
    with socket.create_server(("127.0.0.1", 0)) as server:

        def answer() -> None:
            connection, _ = server.accept()
            with connection:
                connection.recv(65536)
                connection.sendall(b"hello\r\n\r\n")

        thread = threading.Thread(target=answer)
        thread.start()
        with pytest.raises(ChassisError, match="could not be fetched: hello"):
            fetch(f"http://127.0.0.1:{server.getsockname()[1]}/x", lambda: False)
        thread.join()


def test_what_is_no_map_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A file of anything, a ZIP of anything, two sheets, a picture that is not there, one too large."""
    assert unpack(packed(tmp_path / "good")).cells.shape == (20, 30)
    empty = io.BytesIO()
    zipfile.ZipFile(empty, "w").close()
    wrong = {
        b"PK": "not a ZIP", b"": "not a ZIP", empty.getvalue(): "in this are nothing",
        packed(tmp_path / "two", other_yaml=b"image: x"): "a map is a ZIP of one YAML",
    }  # fmt: skip
    for data, match in wrong.items():
        with pytest.raises(ChassisError, match=match):
            unpack(data)
    lone = io.BytesIO()
    with zipfile.ZipFile(lone, "w") as file:
        file.writestr("a.yaml", f"image: {tmp_path}/good/hall.pgm\nresolution: 0.1\norigin: [0, 0, 0]\n")
    with pytest.raises(ChassisError, match=r"hall\.pgm"):
        unpack(lone.getvalue())
    monkeypatch.setattr(maps, "MAX_UNPACKED", 100)
    with pytest.raises(ChassisError, match="larger than 100"):
        unpack(packed(tmp_path / "good"))


@pytest.mark.promise("No name in such a file becomes a name on this disk")
def test_no_name_out_of_a_file_leads_out_of_its_folder(tmp_path: Path) -> None:
    """Nor do an id and a version of the manager's."""
    data = io.BytesIO()
    grid().save(tmp_path / "m.yaml")
    with zipfile.ZipFile(data, "w") as file:
        file.writestr("../../m.yaml", (tmp_path / "m.yaml").read_bytes())
        file.writestr("..\\..\\m.pgm", (tmp_path / "m.pgm").read_bytes())
    shelf = MapStore(tmp_path / "a" / "b" / "shelf", MapEntry("hall", "1"))
    shelf.add("../../x", "/etc", unpack(data.getvalue()))
    names = {path.name for path in (tmp_path / "a").rglob("*") if path.is_file()}
    assert len(names) == 3
    assert json.loads((shelf.folder / "index.json").read_text())["maps"][1]["mapId"] == "../../x"
    assert not (tmp_path / "x").exists()
