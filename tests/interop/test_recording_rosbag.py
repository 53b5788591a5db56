"""Recording and playing beside rosbag: each records what the other plays, on graphs of rospy nodes."""

from __future__ import annotations

import os
import re
import signal
import sys
import time
from pathlib import Path

import pytest

from rosproto import Node
from rosproto.bag import BagReader, BagWriter
from rosproto.codec import message_class
from rosproto.errors import BagError
from tests.support import ros

TALKER = """
import sys, rospy
from std_msgs.msg import String
from geometry_msgs.msg import PoseStamped
rospy.init_node("talker", disable_signals=True)
said = rospy.Publisher("/said", String, queue_size=5000)
pose = rospy.Publisher("/ns/pose", PoseStamped, queue_size=5000)
kept = rospy.Publisher("/kept", String, queue_size=10, latch=True)
kept.publish("the map")
rate = rospy.Rate(50)
i = 0
print("up", flush=True)
while not rospy.is_shutdown():
    i += 1
    said.publish(str(i))
    message = PoseStamped()
    message.pose.position.x = i
    message.header.frame_id = "map"
    pose.publish(message)
    rate.sleep()
"""
LISTENER = """
import sys, time, rospy
from std_msgs.msg import String
got = []
rospy.init_node("listener", disable_signals=True)
for name in sys.argv[2:]:
    rospy.Subscriber(name, String, lambda m, n=name: got.append((n, m.data, m._connection_header["latching"])))
print("up", flush=True)
end = time.time() + 100
while len(got) < int(sys.argv[1]) and time.time() < end:
    time.sleep(0.02)
print("GOT", sorted(got), flush=True)
"""
READ = """
import sys, rosbag
with rosbag.Bag(sys.argv[1]) as bag:
    kinds = bag.get_type_and_topic_info().topics
    print(sorted((t, k.msg_type, k.message_count) for t, k in kinds.items()))
    for topic, m, t in bag.read_messages("/said"):
        print(m.data, end=" ")
    print()
    print(sorted({(c.topic, *[str(c.header[k], "ascii") for k in ("callerid", "latching")]) for c in bag._connections.values()}))
"""


def ours(master_uri: str, *words: object) -> ros.RosProcess:
    """`rosproto bag ...` in a process of its own, to be used in a `with`."""
    return ros.RosProcess(
        [sys.executable, "-m", "rosproto", "bag", *map(str, words)], ros.environment(master_uri)
    )


def wait_for_size(directory: Path, size: int, timeout: float = 30.0) -> None:
    """Wait until the files there (a recorder's) have this size together."""
    end = time.monotonic() + timeout
    while sum(p.stat().st_size for p in directory.iterdir()) < size:
        assert time.monotonic() < end, list(directory.iterdir())
        time.sleep(0.05)


def wait_for_file(path: Path) -> None:
    """Until it is there."""
    end = time.monotonic() + 60
    while not path.exists():
        assert time.monotonic() < end, sorted(path.parent.iterdir())
        time.sleep(0.05)


def wait_for_messages(active: Path, at_least: dict[str, int]) -> None:
    """Until a bag that is being written (in small chunks, so that they get into it at once) holds so many."""
    end = time.monotonic() + 60
    found: dict[str, int] = {}
    while any(found.get(topic, 0) < count for topic, count in at_least.items()):
        assert time.monotonic() < end, f"{active} has {found}"
        time.sleep(0.05)
        try:
            with BagReader(active, skip_damaged=True) as bag:
                found = {topic: known.message_count for topic, known in bag.topics.items()}
        except BagError:
            pass  # not there yet, or not more than its first bytes


@pytest.mark.parametrize("option", ["", "--lz4", "--bz2"])
def test_rosbag_reads_what_we_record(any_master: str, tmp_path: Path, option: str) -> None:
    """A graph of rospy nodes, recorded by `rosproto bag record`: rosbag's tools and its Python agree with us."""
    name = tmp_path / "run.bag"
    words = ["record", "-a", "-x", "/rosout.*", "-O", name, "-l", 25, "--chunksize", 1]
    with ros.start_rospy(TALKER, any_master) as talker:
        talker.wait_for("up")
        with ours(any_master, *words, *([option] if option else [])) as recorder:
            recorder.wait_for("recording to")
            # What does not fill a chunk goes to the disk within five seconds.
            wait_for_messages(tmp_path / "run.bag.active", {"/said": 25, "/ns/pose": 25, "/kept": 1})
            recorder.process.send_signal(signal.SIGINT)
            assert recorder.wait(60) == 0, recorder.output
            assert "0 dropped" in recorder.output
    with BagReader(name) as bag:
        counts = {topic: known.message_count for topic, known in bag.topics.items()}
        said = [m.data for _, m, _ in bag.read_messages("/said")]
        assert [m.pose.position.x for _, m, _ in bag.read_messages("/ns/pose")]
    assert counts == {"/said": 25, "/ns/pose": 25, "/kept": 1}
    assert said == [str(int(said[0]) + i) for i in range(25)], "without a gap"
    info = ros.ros_tool(["rosbag", "info", str(name)], any_master).stdout
    assert re.search(r"^messages: +51$", info, re.MULTILINE), info
    check = ros.ros_tool(["rosbag", "check", str(name)], any_master).stdout
    assert "does not need any migrations" in check
    read = ros.run_rospy(READ, any_master, str(name)).stdout.splitlines()
    assert read[0] == str(
        [
            ("/kept", "std_msgs/String", 1),
            ("/ns/pose", "geometry_msgs/PoseStamped", 25),
            ("/said", "std_msgs/String", 25),
        ]
    )
    assert read[1].split() == said
    assert read[2] == str(
        [("/kept", "/talker", "1"), ("/ns/pose", "/talker", "0"), ("/said", "/talker", "0")]
    )


@pytest.mark.parametrize("how", [signal.SIGTERM, signal.SIGKILL])
def test_a_recorder_that_is_ended(any_master: str, tmp_path: Path, how: signal.Signals) -> None:
    """SIGTERM finishes the bag; after kill -9 what was written can be read, and `rosbag reindex` mends it."""
    with ros.start_rospy(TALKER, any_master) as talker:
        talker.wait_for("up")
        with ours(
            any_master, "record", "/said", "/kept", "-O", tmp_path / "run.bag", "--chunksize", 1
        ) as recorder:
            wait_for_size(tmp_path, 12000)
            recorder.process.send_signal(how)
            recorder.wait(60)
    if how is signal.SIGTERM:
        assert recorder.process.returncode == 0, recorder.output
        found = tmp_path / "run.bag"
    else:
        found = tmp_path / "mended.bag"
        (tmp_path / "run.bag.active").rename(found)
        with BagReader(found) as bag:
            alive = bag.message_count
        ros.ros_tool(["rosbag", "reindex", str(found)], any_master)
        with BagReader(found) as bag:
            assert bag.message_count == alive
    with BagReader(found) as bag:
        assert bag.damage == []
        assert bag.topics["/kept"].message_count == 1
        assert bag.topics["/said"].message_count > 10


def test_each_split_can_be_played_alone(any_master: str, tmp_path: Path) -> None:
    """`--split` by duration: rosbag's names, and the latched message at the start of every bag."""
    with ros.start_rospy(TALKER, any_master) as talker:
        talker.wait_for("up")
        words = ["--split", "--duration", "0.5", "-O", tmp_path / "run.bag"]
        with ours(any_master, "record", "/said", "/kept", *words) as recorder:
            recorder.wait_for("recording to")
            wait_for_file(tmp_path / "run_2.bag")
            recorder.interrupt()
            assert recorder.wait(60) == 0, recorder.output
    paths = sorted(tmp_path.iterdir())
    assert [p.name for p in paths] == [f"run_{i}.bag" for i in range(len(paths))]
    assert len(paths) >= 3
    said: list[int] = []
    for path in paths:
        with BagReader(path) as bag:
            assert bag.topics["/kept"].message_count == 1
            said += [int(m.data) for _, m, _ in bag.read_messages("/said")]
        assert "/kept" in ros.ros_tool(["rosbag", "info", str(path)], any_master).stdout
    assert said == list(range(said[0], said[0] + len(said))), "nothing is lost between two bags"


def test_we_play_what_rosbag_records(any_master: str, tmp_path: Path) -> None:
    """`rosbag record` -> `rosproto bag play` with a remapping -> a rospy listener, latched again."""
    with ros.start_rospy(TALKER, any_master) as talker:
        talker.wait_for("up")
        words = ["rosbag", "record", "/said", "/kept", "-O", str(tmp_path / "run.bag"), "-l", "20"]
        with ros.start_tool([*words, "--chunksize=1"], any_master) as recorder:
            wait_for_messages(tmp_path / "run.bag.active", {"/said": 15, "/kept": 1})
            # `rosbag record` is a wrapper, which ends before the recorder has finished the bag.
            os.killpg(recorder.process.pid, signal.SIGINT)
            wait_for_file(tmp_path / "run.bag")
    with BagReader(tmp_path / "run.bag") as bag:
        expected = [("/again", m.data, "0") for _, m, _ in bag.read_messages("/said")]
        expected += [("/kept", "the map", "1")]
    with ros.start_rospy(LISTENER, any_master, str(len(expected)), "/again", "/kept") as listener:
        listener.wait_for("up")
        words = ["play", tmp_path / "run.bag", "/said:=/again", "--wait-for-subscribers", "-d", "0.5"]
        with ours(any_master, *words) as player:
            assert player.wait(60) == 0, player.output
            assert listener.wait_for("GOT .*")[0] == f"GOT {sorted(expected)}"


def test_rosbag_plays_what_we_record(any_master: str, tmp_path: Path) -> None:
    """`rosproto bag record` -> `rosbag play` -> our subscriber: bytes as they were, latched again."""
    with ros.start_rospy(TALKER, any_master) as talker:
        talker.wait_for("up")
        with ours(
            any_master,
            "record",
            "/said",
            "/ns/pose",
            "/kept",
            "-O",
            tmp_path / "run.bag",
            "-l",
            20,
            "--chunksize",
            1,
        ) as recorder:
            wait_for_messages(tmp_path / "run.bag.active", {"/said": 15, "/ns/pose": 15, "/kept": 1})
            recorder.interrupt()
            recorder.wait(60)
    with BagReader(tmp_path / "run.bag") as bag:
        recorded = [raw.data for _, raw, _ in bag.read_messages("/ns/pose", raw=True)]
    with (
        Node("/ours", master_uri=any_master) as node,
        node.subscriber("/ns/pose", raw=True, queue_size=100) as poses,
        node.subscriber("/kept", "std_msgs/String") as kept,
        node.subscriber("/said", "std_msgs/String"),  # all that is played is waited for
        ros.start_tool(
            ["rosbag", "play", "--wait-for-subscribers", "-q", str(tmp_path / "run.bag")], any_master
        ) as player,
    ):
        got = [poses.next(60)._buff for _ in range(len(recorded))]
        message = kept.next(60)
        assert player.wait(60) == 0
    assert got == recorded
    assert (message.data, message._connection_header["latching"]) == ("the map", "1")


@pytest.mark.parametrize("compression", ["none", "bz2", "lz4"])
def test_info_is_the_text_of_rosbag_info(our_master: object, tmp_path: Path, compression: str) -> None:
    """Text (without curves) and YAML, with and without frequencies, line by line."""
    path = tmp_path / "mixed.bag"
    text, twist = message_class("std_msgs/String"), message_class("geometry_msgs/Twist")
    with BagWriter(path, compression, 4000) as writer:  # type: ignore[arg-type]
        for i in range(300):
            writer.write(
                "/said", text(data="x" * (i % 50)), 1.7e9 + i * 0.3, header={"callerid": f"/n{i % 3}"}
            )
            if i % 7 == 0:
                writer.write("/a/long/topic/name", twist(), 1.7e9 + i * 0.3)
        writer.write("/once", text(), 1.7e9 + 200)
    uri = str(our_master.uri)  # type: ignore[attr-defined]
    for theirs, mine in ((["info"], ["--plain"]), (["info", "--freq"], ["--plain", "--freq"]), (["info", "-y"], ["-y"]), (["info", "-y", "--freq"], ["-y", "--freq"])):  # fmt: skip
        expected = ros.ros_tool(["rosbag", *theirs, str(path)], uri).stdout
        with ours(uri, "info", *mine, path) as found:
            assert found.wait(60) == 0
            assert found.output == expected


def test_a_clock_drives_rospy(any_master: str, tmp_path: Path) -> None:
    """`--clock`: a rospy node with use_sim_time sees the bag's time."""
    text = message_class("std_msgs/String")
    with BagWriter(tmp_path / "run.bag") as writer:
        for i in range(30):
            writer.write("/said", text(data=str(i)), 5000.0 + i / 10)
    code = """
import rospy, time
rospy.init_node("simulated", disable_signals=True)
print("up", flush=True)
now = 0.0
while now < 5001:
    time.sleep(0.02)
    now = rospy.Time.now().to_sec()
print("NOW", int(now), flush=True)
"""
    with Node("/setter", master_uri=any_master) as node:
        node.params["/use_sim_time"] = True
        try:
            with ros.start_rospy(code, any_master) as simulated:
                simulated.wait_for("up")
                with ours(any_master, "play", tmp_path / "run.bag", "--clock", "--loop", "-q") as player:
                    assert simulated.wait_for(r"NOW (\d+)")[1] in ("5001", "5002")  # the bag ends before 5003
                    player.interrupt()
                    player.wait(60)
        finally:
            del node.params["/use_sim_time"]
