"""Bags between us and Debian's rosbag, both ways: every compression, every kind of damage."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import textwrap
from pathlib import Path

import numpy as np
import pytest

import rosproto
from rosproto.bag import BagReader, BagWriter, recover, reindex
from rosproto.codec import define, encode, message_class
from rosproto.msg import DefinitionLibrary
from rosproto.time import Time
from tests.support import ros
from tests.support.bag_setters import BAG_SETTERS
from tests.support.rospy_program import output

COMPRESSIONS = ["none", "bz2", "lz4"]
String = message_class("std_msgs/String")
PoseArray = message_class("geometry_msgs/PoseArray")
Twist = message_class("geometry_msgs/Twist")

WRITE = """
import sys, rosbag, rospy, random
from std_msgs.msg import String
from geometry_msgs.msg import Twist, PoseArray, Pose
path, compression, how = sys.argv[1:4]
random.seed(4)
bag = rosbag.Bag(path, "w", compression=compression, chunk_threshold=8000)
order = list(range(300))
if how == "shuffled": random.shuffle(order)
for i in order:
    t = rospy.Time(100 + i // 10, i % 10 * 100000000)
    bag.write("/chatter", String("hello %d" % i), t)
    twist = Twist(); twist.linear.x = i
    bag.write("/cmd_vel", twist, t + rospy.Duration(0, 1000))
    if i % 5 == 0:
        poses = PoseArray(poses=[Pose() for _ in range(i % 7)]); poses.header.seq = i
        bag.write("/poses", poses, t + rospy.Duration(0, 2000))
if how == "died":
    bag.flush()
    bag._file.flush()
    import os; os._exit(0)
bag.close()
"""

READ = """
import sys, json, hashlib, rosbag
rows = []
with rosbag.Bag(sys.argv[1]) as bag:
    for topic, raw, t in bag.read_messages(raw=True):
        rows.append([topic, raw[0], hashlib.md5(raw[1]).hexdigest(), t.secs, t.nsecs])
    for topic, message, t in bag.read_messages():
        pass
print(json.dumps(rows))
"""


def debian(code: str, *arguments: object) -> subprocess.CompletedProcess[str]:
    return ros.run_rospy(code, "http://127.0.0.1:1", *map(str, arguments))


def rows_by_debian(path: Path) -> list[list[object]]:
    done = debian(READ, path)
    assert "WARN" not in done.stdout + done.stderr
    return json.loads(done.stdout.splitlines()[-1])


def rows_by_us(path: Path) -> list[list[object]]:
    import hashlib

    with BagReader(path, skip_damaged=True) as bag:
        return [
            [t, raw.type, hashlib.md5(raw.data).hexdigest(), s.secs, s.nsecs]
            for t, raw, s in bag.read_messages(raw=True)
        ]


def tool(*arguments: object, check: bool = True) -> str:
    done = ros.ros_tool(["rosbag", *map(str, arguments)], "http://127.0.0.1:1", check=check)
    return done.stdout + done.stderr


@pytest.fixture(scope="module")
def theirs(tmp_path_factory: pytest.TempPathFactory, ros_installed: None) -> dict[str, Path]:
    """Bags of Debian's writer, by compression and "died" / "shuffled"."""
    folder = tmp_path_factory.mktemp("theirs")
    found = {}
    for name, compression, how in [(c, c, "") for c in COMPRESSIONS] + [
        ("died", "none", "died"), ("died_lz4", "lz4", "died"), ("shuffled", "none", "shuffled"),
    ]:  # fmt: skip
        found[name] = folder / f"{name}.bag"
        debian(WRITE, found[name], compression, how)
    return found


def write_ours(path: Path, compression: str, *, close: bool = True) -> BagWriter:
    writer = BagWriter(path, compression, 8000)
    value = define(
        "my_msgs/Value",
        "int32 x\ngeometry_msgs/Point p\n"
        + "=" * 80
        + "\nMSG: geometry_msgs/Point\nfloat64 x\nfloat64 y\nfloat64 z\n",
    )
    for i in range(300):
        stamp = Time(100 + i // 10, i % 10 * 100_000_000)
        writer.write(
            "/chatter", String(data=f"hällo {i}"), stamp, header={"callerid": f"/p{i % 2}", "latching": "1"}
        )
        writer.write("/poses", PoseArray(), stamp)
        writer.write("/value", value(x=i), stamp)
    if close:
        writer.close()
    return writer


@pytest.mark.parametrize("name", [*COMPRESSIONS, "shuffled"])
def test_we_read_what_rosbag_wrote(theirs, name):
    ours = rows_by_us(theirs[name])
    # (rosbag's own reader does not sort an unordered bag completely; ours does.)
    assert sorted(ours, key=lambda r: r[3:]) == ours
    assert sorted(ours) == sorted(rows_by_debian(theirs[name]))
    with BagReader(theirs[name]) as bag:
        assert bag.damage == []
        assert bag.message_count == len(ours) == 660
        assert bag.frequency("/chatter") == pytest.approx(10.0)
        values = bag.to_numpy("/cmd_vel", ["linear.x"])["linear.x"]
        assert values.tolist() == np.arange(300.0).tolist()
        assert isinstance(next(bag.read_messages("/cmd_vel"))[1], Twist)


@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_rosbag_reads_what_we_wrote_without_a_warning(tmp_path, ros_installed, compression):
    path = tmp_path / "ours.bag"
    write_ours(path, compression)
    rows = rows_by_debian(path)
    assert sorted(rows) == sorted(rows_by_us(path))
    assert len(rows) == 900
    info = tool("info", path)
    assert re.search(r"messages:\s+900\b", info)
    assert compression in info if compression == "none" else f"{compression} [" in info
    assert re.search(r"/chatter\s+300 msgs\s+: std_msgs/String\s+\(2 connections\)", info), info
    assert not re.search("WARN|ERROR|Unable", info)


@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_rosbag_check_finds_the_recorded_definitions_unchanged(tmp_path, theirs, compression):
    """(It compares texts, comments included, so only what was recorded from Debian's nodes can pass.)"""
    path = tmp_path / "copy.bag"
    with BagReader(theirs["none"]) as bag, BagWriter(path, compression) as writer:
        for topic, raw, stamp in bag.read_messages(raw=True):
            writer.write(topic, raw, stamp)
    assert "does not need any migrations" in tool("check", path)
    assert rows_by_debian(path) == rows_by_debian(theirs["none"])


def test_rosbag_check_is_content_with_a_publishers_own_text(tmp_path, theirs):
    """Decoded messages, written again with the header they came with."""
    path = tmp_path / "again.bag"
    with BagReader(theirs["none"]) as bag, BagWriter(path) as writer:
        headers = {c.topic: c.header for c in bag.connections.values()}
        for topic, message, stamp in bag.read_messages():
            writer.write(topic, message, stamp, header=headers[topic])
    assert "does not need any migrations" in tool("check", path)
    assert rows_by_debian(path) == rows_by_debian(theirs["none"])


def test_rosbag_check_is_content_with_messages_of_the_installed_definitions(tmp_path, ros_installed):
    """Classes made from the folders of a ROS installation carry its texts."""
    library = DefinitionLibrary([Path("/usr/share")])
    path = tmp_path / "installed.bag"
    with BagWriter(path) as writer:
        for kind in (
            "std_msgs/String",
            "geometry_msgs/PoseArray",
            "geometry_msgs/TwistWithCovarianceStamped",
        ):
            writer.write("/" + kind.partition("/")[2], message_class(kind, library)(), 1)
    assert "does not need any migrations" in tool("check", path)


def test_rosbag_check_finds_nothing_but_comments_in_our_own_definitions(tmp_path, ros_installed):
    """The bundled texts say the same in other words: equal md5sums, and `rosbag fix` needs no rules."""
    path, fixed = tmp_path / "own.bag", tmp_path / "fixed.bag"
    with BagWriter(path) as writer:
        for kind in ("std_msgs/String", "geometry_msgs/PoseArray"):
            writer.write("/" + kind.partition("/")[2], message_class(kind)(), 1)
    found = re.findall(r"(?:From|To):\s+(\S+ \[\w+\])", tool("check", path))
    assert found[0::2] == found[1::2] != []
    tool("fix", path, fixed)
    assert rows_by_debian(fixed) == rows_by_debian(path)


@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_each_appends_to_the_others_bag(tmp_path, theirs, compression):
    path = tmp_path / "both.bag"
    shutil.copy(theirs[compression], path)
    with BagWriter(path, compression, append=True) as writer:
        for i in range(50):
            writer.write("/chatter", String(data=f"ours {i}"), 1000 + i)
    debian(
        "import sys, rosbag, rospy\nfrom std_msgs.msg import String\n"
        "with rosbag.Bag(sys.argv[1], 'a', compression=sys.argv[2]) as bag:\n"
        "    for i in range(50): bag.write('/chatter', String('theirs %d' % i), rospy.Time(2000 + i))\n",
        path,
        compression,
    )
    assert len(rows_by_us(path)) == 760
    assert sorted(rows_by_debian(path)) == sorted(rows_by_us(path))
    with BagReader(path) as bag:
        assert bag.damage == []
        assert [m.data for _, m, _ in bag.read_messages("/chatter", start_time=1000.0)][::99] == [
            "ours 0",
            "theirs 49",
        ]


@pytest.mark.parametrize("name", ["died", "died_lz4"])
def test_we_read_and_mend_what_a_dead_rosbag_left(tmp_path, theirs, name):
    with BagReader(theirs[name]) as bag:
        assert "never closed" in bag.damage[0]
    rows = rows_by_us(theirs[name])
    assert len(rows) >= 620
    path = tmp_path / "mended.bag"
    shutil.copy(theirs[name], path)
    assert reindex(path).messages == len(rows)
    assert rows_by_us(path) == rows
    assert sorted(rows_by_debian(path)) == sorted(rows)


@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_rosbag_reindexes_what_a_dead_writer_of_ours_left(tmp_path, ros_installed, compression):
    path = tmp_path / "died.bag"
    writer = write_ours(path, compression, close=False)
    writer._chunks.drain()  # a recorder lives longer than a chunk is compressed
    writer._output.close()  # all that a killed process leaves: what was written
    rows = rows_by_us(path)
    assert len(rows) > 700
    assert "unindexed" in tool("info", path, check=False)
    tool("reindex", path)
    assert sorted(rows_by_debian(path)) == sorted(rows)


@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_cut_at_every_thousandth_byte_we_read_a_prefix_and_what_we_mend_rosbag_reads(
    tmp_path, theirs, compression
):
    data = theirs[compression].read_bytes()
    whole = rows_by_us(theirs[compression])
    path = tmp_path / "cut.bag"
    counts = []
    for cut in range(1000, len(data), 1000):
        path.write_bytes(data[:cut])
        rows = rows_by_us(path)
        assert rows == sorted((r for r in whole if r in rows), key=lambda r: r[3:])
        counts.append(len(rows))
    assert counts == sorted(counts)
    assert counts[-1] > 500
    for share in (0.3, 0.6, 0.9):
        path.write_bytes(data[: int(len(data) * share)])
        rows = rows_by_us(path)
        if not rows:
            continue  # the file header alone is a good part of a small compressed bag
        reindex(path)
        assert rows_by_us(path) == rows
        assert sorted(rows_by_debian(path)) == sorted(rows)


READ_MANY = """
import sys, json, hashlib, rosbag
for path in sys.argv[1:]:
    rows = []
    with rosbag.Bag(path) as bag:
        for topic, raw, t in bag.read_messages(raw=True):
            rows.append([topic, raw[0], hashlib.md5(raw[1]).hexdigest(), t.secs, t.nsecs])
    print(json.dumps(rows))
"""


@pytest.mark.parametrize("whose", ["theirs", "ours"])
@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_what_we_save_of_a_bag_with_changed_bytes_rosbag_reads(tmp_path, theirs, compression, whose):
    """A byte flipped anywhere, a missing index, a lost end: what is read, only true messages, is saved for rosbag."""
    path = tmp_path / "ours.bag"
    if whose == "ours":
        write_ours(path, compression)
    else:
        path = theirs[compression]
    data, whole = path.read_bytes(), {str(row) for row in rows_by_us(path)}
    damaged = {"no index": data.replace(b"index_pos=", b"INDEX_POS=", 1), "no end": data[:-700]}
    for i in range(12):
        at = 13 + (len(data) - 13) * (2 * i + 1) // 24
        damaged[f"flip at {at}"] = data[:at] + bytes([data[at] ^ 0x5A]) + data[at + 1 :]
    saved, expected = [], []
    for number, (name, content) in enumerate(damaged.items()):
        bad, good = tmp_path / f"bad{number}.bag", tmp_path / f"good{number}.bag"
        bad.write_bytes(content)
        report = recover(bad, good, compression=compression)
        rows = rows_by_us(good)
        assert len(rows) == report.messages, name
        untrue = [row for row in rows if str(row) not in whole]
        # Nothing in an uncompressed chunk tells of a byte changed in the data or the time of a message.
        assert len(untrue) <= (1 if compression == "none" else 0), (name, untrue)
        assert len(rows) >= len(whole) * 0.8 or compression != "none", name
        saved.append(good)
        expected.append(sorted(rows))
    done = debian(READ_MANY, *saved)
    assert "WARN" not in done.stdout + done.stderr
    found = [sorted(json.loads(line)) for line in done.stdout.splitlines()]
    assert found == expected


@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_rosbag_plays_our_bag(tmp_path, our_master, compression):
    player = Path("/usr/lib/rosbag/play")
    ros.require(player.exists(), f"there is no {player}")
    path = tmp_path / "play.bag"
    with BagWriter(path, compression, 500) as writer:
        for i in range(20):
            writer.write("/chatter", String(data=f"{i}"), 100 + i * 0.05)
    with (
        rosproto.Node("/listener", master_uri=our_master.uri, host="127.0.0.1") as node,
        node.subscriber("/chatter", String, queue_size=100) as chatter,
        ros.start_program(player, our_master.uri, "--wait-for-subscribers", str(path)) as process,
    ):
        assert [chatter.next(60).data for _ in range(20)] == [str(i) for i in range(20)]
        assert process.wait(60) == 0, process.output


@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_we_read_what_rosbag_record_wrote_from_us(tmp_path, our_master, compression):
    recorder = Path("/usr/lib/rosbag/record")
    ros.require(recorder.exists(), f"there is no {recorder}")
    path = tmp_path / "recorded.bag"
    options = {"none": [], "bz2": ["-j"], "lz4": ["--lz4"]}[compression]
    with (
        rosproto.Node("/talker", master_uri=our_master.uri, host="127.0.0.1") as node,
        node.publisher("/chatter", String, latch=True, queue_size=100) as chatter,
        ros.start_program(
            recorder, our_master.uri, *options, "-l", "50", "-O", str(path), "/chatter"
        ) as process,
    ):
        chatter.wait_for_connection(60)
        sent = [String(data=f"message {i}") for i in range(50)]
        for message in sent:
            chatter.publish(message)
        assert process.wait(60) == 0, process.output  # it ends when it has as many as it was told to take
    with BagReader(path) as bag:
        assert bag.damage == []
        assert [encode(m) for _, m, _ in bag] == [encode(m) for m in sent]
        connection = bag.topics["/chatter"].connections[0]
        assert connection.callerid == "/talker"
        assert connection.latching


def test_compression_and_chunk_threshold_are_set_as_by_rosbag(tmp_path, ros_installed):
    """The same program prints the same with Debian's rosbag and with the rospy layer."""
    program = tmp_path / "theirs.py"
    program.write_text(textwrap.dedent(BAG_SETTERS), "utf-8")
    assert output(BAG_SETTERS, tmp_path) == ros.run_rospy(program, "http://127.0.0.1:1").stdout
