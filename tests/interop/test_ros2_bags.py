"""`bag convert --ros2`: what rosbags' reader of ROS 2 bags finds in the result."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import pytest

from rosproto.bag import BagReader, BagWriter
from rosproto.cli import main
from rosproto.codec import define, message_class
from rosproto.time import Duration, Time

rosbag2 = pytest.importorskip("rosbags.rosbag2", reason="rosbags is not installed (extra ros2)")
typesys = pytest.importorskip("rosbags.typesys")

Odometry = message_class("nav_msgs/Odometry")
LaserScan = message_class("sensor_msgs/LaserScan")
Battery = message_class("woosh_msgs/Battery")
Mixed = define(
    "my_msgs/Mixed",
    "int8 GOOD=3\nint8 small=4\nstring WORD=yes\ntime when\nduration long\nbyte octet\nchar sign\nuint8[] raw\n"
    "string[] names\nfloat64[2] pair\nbool yes\nmy_msgs/Part[] parts\n"
    + "=" * 80
    + "\nMSG: my_msgs/Part\nstring label\nint16 value\n",
)
Part = define("my_msgs/Part", "string label\nint16 value\n")


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Standard messages, the robot's, one with every kind of field; one topic latched."""
    path = tmp_path_factory.mktemp("ros1") / "a.bag"
    with BagWriter(path, "lz4", 3000) as bag:
        for i in range(40):
            odom = Odometry()
            odom.header.seq, odom.header.stamp, odom.header.frame_id = i, Time(100 + i, 7), "map"
            odom.pose.pose.position.x = i / 4
            bag.write("/odom", odom, Time(1000 + i, 1))
            scan = LaserScan(ranges=[float(i)] * i)
            bag.write("/scan", scan, Time(1000 + i, 2))
        mixed = Mixed(
            when=Time(5, 6), long=Duration(-1, 5), octet=-3, sign=200, raw=b"abc", names=["a", "ü"],
            pair=[1.0, 2.0], yes=True, parts=[Part("p", -1), Part("q", 2)],
        )  # fmt: skip
        bag.write("/mixed", mixed, Time(2000), header={"callerid": "/robot", "latching": "1"})
        bag.write("/battery", Battery(), Time(2001))
    return path


def read_by_rosbags(path: Path) -> list[tuple[str, str, int, Any, bool]]:
    """Topic, type, time, message and whether it is latched, by the definitions that are in the bag."""
    found = []
    with rosbag2.Reader(path) as bag:
        for connection, stamp, data in bag.messages():
            store = typesys.get_typestore(typesys.Stores.EMPTY)
            store.register(typesys.get_types_from_msg(connection.msgdef.data, connection.msgtype))
            latched = any(q.durability.name == "TRANSIENT_LOCAL" for q in connection.ext.offered_qos_profiles)
            message = store.deserialize_cdr(data, connection.msgtype)
            found.append((connection.topic, connection.msgtype, stamp, message, latched))
    return found


def test_message_by_message(recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Topics, types, times, every field; a latched topic stays one."""
    assert main(["bag", "convert", "--ros2", str(recording), str(tmp_path / "two")]) == 0
    assert capsys.readouterr().out.strip() == f"{tmp_path / 'two'}: 82 messages"
    theirs = read_by_rosbags(tmp_path / "two")
    with BagReader(recording) as bag:
        ours = list(bag.read_messages())
        kinds = {topic: info.types[0].replace("/", "/msg/") for topic, info in bag.topics.items()}
    assert [(t, kind, stamp) for t, kind, stamp, _, _ in theirs] == [
        (t, kinds[t], stamp.to_nsec()) for t, _, stamp in ours
    ]
    assert {topic for topic, *_, latched in theirs if latched} == {"/mixed"}
    for (topic, _, _, new, _), (_, old, _) in zip(theirs, ours, strict=True):
        if topic == "/odom":
            assert not hasattr(new.header, "seq")
            assert (new.header.stamp.sec, new.header.stamp.nanosec) == (old.header.stamp.secs, 7)
            assert new.header.frame_id == "map"
            assert new.pose.pose.position.x == old.pose.pose.position.x
            assert new.pose.covariance.tolist() == list(old.pose.covariance)
        elif topic == "/scan":
            assert new.ranges.tolist() == list(old.ranges)
    mixed = next(message for topic, _, _, message, _ in theirs if topic == "/mixed")
    assert (mixed.when.sec, mixed.when.nanosec, mixed.long.sec, mixed.long.nanosec) == (5, 6, -1, 5)
    assert (mixed.octet & 0xFF, mixed.sign, bytes(mixed.raw), mixed.names) == (253, 200, b"abc", ["a", "ü"])
    assert [(part.label, part.value) for part in mixed.parts] == [("p", -1), ("q", 2)]


def test_what_fails_leaves_nothing(
    recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A damaged chunk; a directory that exists; a compression; a missing package."""
    data = bytearray(recording.read_bytes())
    with BagReader(recording) as bag:
        data[bag.chunks[1].pos + 200] ^= 0xFF
    broken, out = tmp_path / "broken.bag", tmp_path / "out"
    broken.write_bytes(data)
    assert main(["bag", "convert", "--ros2", str(broken), str(out)]) != 0
    assert "cannot be read" in capsys.readouterr().err
    assert not out.exists()
    assert main(["bag", "convert", "--ros2", "--lz4", str(recording), str(out)]) != 0
    assert "without compression" in capsys.readouterr().err
    out.mkdir()
    assert main(["bag", "convert", "--ros2", str(recording), str(out)]) != 0
    assert "already exists" in capsys.readouterr().err
    monkeypatch.setitem(sys.modules, "rosbags.rosbag2", None)
    assert main(["bag", "convert", "--ros2", str(recording), str(tmp_path / "other")]) != 0
    assert ".[ros2]" in capsys.readouterr().err
