"""Recording from and playing to a graph in this process."""

from __future__ import annotations

import threading
import time

import pytest

import rosproto
from rosproto.bag import BagReader, BagWriter
from rosproto.bag.output import BagOutputFile
from rosproto.codec import encode, message_class
from rosproto.errors import BagError
from rosproto.recording import Player, Recorder

String = message_class("std_msgs/String")
Twist = message_class("geometry_msgs/Twist")


@pytest.fixture
def nodes():
    with (
        rosproto.Master() as master,
        rosproto.Node("/one", master_uri=master.uri, host="127.0.0.1") as one,
        rosproto.Node("/two", master_uri=master.uri, host="127.0.0.1") as two,
    ):
        yield one, two


def wait(what, seconds=20.0):
    end = time.monotonic() + seconds
    while not what():
        assert time.monotonic() < end
        threading.Event().wait(0.005)


@pytest.mark.parametrize("compression", ["none", "lz4"])
def test_what_is_published_is_in_the_bag_with_its_publishers_header(nodes, tmp_path, compression):
    one, two = nodes
    chatter = one.publisher("/chatter", String, latch=True, queue_size=1000)
    with Recorder(two, tmp_path / "a.bag", ["/chatter"], compression=compression) as recorder:
        chatter.wait_for_connection(20)
        for i in range(100):
            chatter.publish(String(data=str(i)))
        wait(lambda: recorder.messages == 100)
    with BagReader(tmp_path / "a.bag") as bag:
        assert bag.damage == []
        assert [m.data for _, m, _ in bag] == [str(i) for i in range(100)]
        (connection,) = bag.connections.values()
        assert (connection.callerid, connection.latching) == ("/one", True)
        assert connection.md5sum == String._md5sum
    assert recorder.dropped == 0


def test_a_pattern_finds_topics_as_they_appear_and_exclude_leaves_some_out(nodes, tmp_path):
    one, two = nodes
    with Recorder(two, tmp_path / "a.bag", pattern="/a/.*", exclude=".*/secret") as recorder:
        found = one.publisher("/a/b", String)
        one.publisher("/a/secret", String)
        one.publisher("/other", String)
        found.wait_for_connection(20)
        wait(lambda: recorder.topics == ["/a/b"])
        found.publish(String(data="x"))
        wait(lambda: recorder.messages == 1)
    with BagReader(tmp_path / "a.bag") as bag:
        assert list(bag.topics) == ["/a/b"]


def test_splitting_begins_each_bag_with_what_was_latched(nodes, tmp_path):
    one, two = nodes
    map_ = one.publisher("/map", String, latch=True)
    chatter = one.publisher("/chatter", String, queue_size=1000)
    with Recorder(
        two, tmp_path / "run.bag", ["/map", "/chatter"], split_bytes=20_000, chunk_bytes=5000
    ) as recorder:
        map_.wait_for_connection(20)
        chatter.wait_for_connection(20)
        map_.publish(String(data="the map"))
        wait(lambda: recorder.messages == 1)
        for i in range(300):
            chatter.publish(String(data=f"{i:0100}"))
        wait(lambda: recorder.messages == 301)
    assert [p.name for p in recorder.paths] == [f"run_{i}.bag" for i in range(len(recorder.paths))]
    assert len(recorder.paths) > 2
    numbers = []
    for path in recorder.paths:
        with BagReader(path) as bag:
            assert [m.data for _, m, _ in bag.read_messages("/map")] == ["the map"]
            numbers += [int(m.data) for _, m, _ in bag.read_messages("/chatter")]
    assert numbers == list(range(300))


def test_a_limit_and_a_full_buffer(nodes, tmp_path):
    one, two = nodes
    chatter = one.publisher("/chatter", String, queue_size=1000)
    with (
        Recorder(two, tmp_path / "limit.bag", ["/chatter"], limit=3) as limited,
        Recorder(two, tmp_path / "small.bag", ["/chatter"], buffer_bytes=10) as small,
    ):
        chatter.wait_for_connection(20)
        for _ in range(10):
            chatter.publish(String(data="twelve bytes"))
        wait(lambda: small.dropped == 10 and limited.messages == 3)
    with BagReader(tmp_path / "limit.bag") as bag:
        assert bag.message_count == 3


def test_a_disk_that_is_full_ends_the_recording_with_an_error(nodes, tmp_path, monkeypatch):
    one, two = nodes
    chatter = one.publisher("/chatter", String)

    def full(self, pieces, at):
        raise OSError(28, "No space left on device")

    recorder = Recorder(two, tmp_path / "a.bag", ["/chatter"], chunk_bytes=1)
    chatter.wait_for_connection(20)
    monkeypatch.setattr(BagOutputFile, "put", full)
    chatter.publish(String(data="x"))
    wait(lambda: recorder.error is not None)
    with pytest.raises(BagError, match="No space left"):
        recorder.close()
    recorder.close()


def test_nothing_to_record_and_bad_patterns_are_refused(nodes, tmp_path):
    with pytest.raises(ValueError, match="nothing to record"):
        Recorder(nodes[0], tmp_path / "a.bag")
    with pytest.raises(ValueError, match="not a regular expression"):
        Recorder(nodes[0], tmp_path / "a.bag", pattern="(")
    assert not (tmp_path / "a.bag").exists()


@pytest.fixture
def bag(tmp_path):
    path = tmp_path / "play.bag"
    with BagWriter(path) as writer:
        for i in range(40):
            writer.write("/chatter", String(data=str(i)), 100 + i * 0.01)
            writer.write("/cmd", Twist(), 100 + i * 0.01)
        writer.write("/map", String(data="map"), 100.0, header={"latching": "1"})
    with BagReader(path) as bag:
        yield bag


def test_messages_are_played_at_their_time(nodes, bag):
    one, two = nodes
    moments = []
    with (
        Player(one, bag) as player,
        two.subscriber("/chatter", String, queue_size=100) as chatter,
        two.subscriber("/cmd", Twist, queue_size=100) as cmd,
        two.subscriber("/map", String) as map_,
    ):
        player.wait_for_subscribers()
        began = time.perf_counter()
        assert player.play(lambda topic, stamp: moments.append((stamp.to_sec(), time.perf_counter()))) == 81
        assert [chatter.next(20).data for _ in range(40)] == [str(i) for i in range(40)]
        assert [encode(cmd.next(20)) for _ in range(40)] == [encode(Twist())] * 40
        assert map_.next(20).data == "map"
        with two.subscriber("/map", String) as late:
            assert late.next(20).data == "map", "latched again"
    late = [(now - began) - (at - 100.0) for at, now in moments]
    assert min(late) > -0.001, "never before its time"


def test_rate_part_topics_and_remap(nodes, bag):
    one, two = nodes
    options = {
        "topics": ["/chatter"],
        "rate": 0.5,
        "start": 0.1,
        "duration": 0.2,
        "remap": {"/chatter": "/said"},
    }
    with Player(one, bag, **options) as player, two.subscriber("/said", String, queue_size=100) as said:
        player.wait_for_subscribers()
        began = time.perf_counter()
        count = player.play()
        assert time.perf_counter() - began > 0.35, "0.2 s at half the pace"
        assert count in (20, 21)
        assert said.next(20).data == "10"


def test_pause_step_and_stop(nodes, bag):
    one, _ = nodes
    seen = []
    with Player(one, bag, topics=["/chatter"], rate=1000.0) as player:
        player.pause()
        thread = threading.Thread(target=player.play, args=(lambda topic, stamp: seen.append(stamp),))
        thread.start()
        for count in (1, 2):
            player.step()
            wait(lambda count=count: len(seen) == count)
        player.stop()
        thread.join(10)
        assert not thread.is_alive()
        assert len(seen) == 2
        player.resume()
        assert player.play() == 40


def test_the_clock_of_the_bag(nodes, bag):
    one, two = nodes
    with (
        two.subscriber("/clock", "rosgraph_msgs/Clock", queue_size=1000) as clock,
        Player(one, bag, topics=["/chatter"], clock_hz=200.0) as player,
    ):
        clock.wait_for_connection(20)
        player.play()
        times = [clock.next(20).clock.to_sec() for _ in range(5)]  # of 80, on a quiet computer
    assert times == sorted(times)
    assert 99.9 < times[0] < times[-1] < 100.5


def test_a_rate_must_be_positive_and_topics_must_be_there(nodes, bag):
    with pytest.raises(ValueError, match="greater than 0"):
        Player(nodes[0], bag, rate=0)
    with pytest.raises(BagError, match="no messages on topic '/nowhere'"):
        Player(nodes[0], bag, topics=["/nowhere"])
