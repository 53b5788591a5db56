"""`Player`: several bags, latched messages before the start, loops, gaps, speed."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from rosproto import Master, Node
from rosproto.bag import BagReader, BagWriter
from rosproto.codec import define, message_class
from rosproto.errors import BagError, RosTimeout
from rosproto.recording import Player
from rosproto.recording.pacer import Pacer
from rosproto.time import Time

String = message_class("std_msgs/String")


@pytest.fixture
def nodes() -> Iterator[tuple[Node, Node]]:
    with (
        Master() as master,
        Node("/player", master_uri=master.uri) as one,
        Node("/listener", master_uri=master.uri) as two,
    ):
        yield one, two


@pytest.fixture
def bags(tmp_path: Path) -> Iterator[list[BagReader]]:
    """Two bags that interleave; two nodes latched on /tf at the start; a minute of silence in the middle."""
    with BagWriter(tmp_path / "a.bag") as a, BagWriter(tmp_path / "b.bag") as b:
        for name in "xy":
            a.write("/tf", String(data=name), 100.0, header={"callerid": f"/{name}", "latching": "1"})
        for i in range(10):
            moment = 100.5 + i * 0.01 + (60 if i >= 5 else 0)
            a.write("/a", String(data=f"a{i}"), moment)
            b.write("/b", String(data=f"b{i}"), moment + 0.005)
    with BagReader(tmp_path / "a.bag") as first, BagReader(tmp_path / "b.bag") as second:
        yield [first, second]


def test_several_bags_as_one_and_silence_left_out(nodes: tuple[Node, Node], bags: list[BagReader]) -> None:
    """All in the order of time, a prefix before the names; the silent minute takes no time."""
    order: list[str] = []
    with Player(nodes[0], bags, prefix="/old", skip_empty=0.2, rate=2.0) as player:
        assert {p.topic for p in player.publishers} == {"/old/a", "/old/b", "/old/tf"}
        assert player.play(lambda topic, stamp: order.append(topic)) == 22
    assert order == ["/tf", "/tf", *["/a", "/b"] * 10]
    assert player.position_ns == 160_595_000_000


def test_latched_messages_before_the_start_come_first(
    nodes: tuple[Node, Node], bags: list[BagReader]
) -> None:
    """Starting late, each latched publisher's message is published first, and again to late subscribers."""
    one, two = nodes
    with Player(one, bags, start=60.5, topics=["/tf", "/a"], keep_alive=True) as player:
        thread = threading.Thread(target=player.play, daemon=True)
        with two.subscriber("/tf", "std_msgs/String") as early:
            thread.start()
            assert sorted(early.next(20).data for _ in range(2)) == ["x", "y"]
        with two.subscriber("/tf", "std_msgs/String") as late:
            assert sorted(late.next(20).data for _ in range(2)) == ["x", "y"]
        player.stop()
        thread.join(20)
        assert not thread.is_alive()


def test_a_loop_goes_on_until_stopped(nodes: tuple[Node, Node], bags: list[BagReader]) -> None:
    """Three times the same, then stop; nothing to play ends even a loop."""
    seen: list[str] = []

    def count(topic: str, stamp: object) -> None:
        seen.append(topic)
        if len(seen) == 30:
            player.stop()

    with Player(nodes[0], bags, topics=["/a"], loop=True, immediate=True) as player:
        assert player.play(count) == 30
    with Player(nodes[0], bags, topics=["/a"], loop=True, start=1000.0) as player:
        assert player.play() == 0


def test_immediate_waits_for_slow_subscribers(nodes: tuple[Node, Node], tmp_path: Path) -> None:
    """Without pacing nothing is dropped on our side, however many messages there are."""
    with BagWriter(tmp_path / "many.bag") as writer:
        for i in range(3000):
            writer.write("/many", String(data=f"{i:01000}"), 100.0 + i)
    one, two = nodes
    with (
        BagReader(tmp_path / "many.bag") as bag,
        two.subscriber("/many", raw=True, queue_size=4000) as many,
        Player(one, bag, immediate=True, queue_size=100) as player,
    ):
        player.wait_for_subscribers(5)
        assert player.play() == 3000
        assert [int(many.next(20)._buff[4:]) for _ in range(3000)] == list(range(3000))


def test_ticks_come_while_waiting_and_keys_may_pause(nodes: tuple[Node, Node], bags: list[BagReader]) -> None:
    """on_tick runs in the playing thread, before the first message too; from it one may pause, step, stop."""
    calls: list[int] = []

    def tick(player: Player) -> None:
        calls.append(player.published)
        if len(calls) == 1:
            assert player.paused
        elif player.published < 3:
            player.step()
        else:
            player.stop()

    with Player(nodes[0], bags, topics=["/a"], paused=True, on_tick=tick) as player:
        assert player.play() == 3
    assert calls == [0, 0, 1, 2, 3]


def test_waiting_for_subscribers_names_who_has_none(nodes: tuple[Node, Node], bags: list[BagReader]) -> None:
    """RosTimeout tells the topics."""
    one, two = nodes
    with (
        Player(one, bags) as player,
        two.subscriber("/a", "std_msgs/String"),
        pytest.raises(RosTimeout, match="/b, /tf"),
    ):
        player.wait_for_subscribers(0.3)


def test_two_definitions_on_one_topic_are_refused(nodes: tuple[Node, Node], tmp_path: Path) -> None:
    """A node can publish one; the error says what to do."""
    other = define("my_msgs/Other", "int32 x\n")
    with BagWriter(tmp_path / "mixed.bag") as writer:
        writer.write("/a", String(data="x"), 1.0)
        writer.write("/a", other(x=1), 2.0)
    with BagReader(tmp_path / "mixed.bag") as bag, pytest.raises(BagError, match="different definitions"):
        Player(nodes[0], bag)


def test_the_clock_stands_while_paused_and_ticks_on(nodes: tuple[Node, Node], bags: list[BagReader]) -> None:
    """/clock goes on while paused, with the same time; after that it runs on from there."""
    one, two = nodes
    with (
        two.subscriber("/clock", "rosgraph_msgs/Clock", queue_size=1000) as clock,
        Player(one, bags, topics=["/a"], clock_hz=200.0, paused=True, duration=0.9) as player,
    ):
        clock.wait_for_connection(20)
        thread = threading.Thread(target=player.play, daemon=True)
        thread.start()
        paused = [clock.next(20).clock.to_sec() for _ in range(30)]
        assert set(paused) == {100.0}
        player.resume()
        thread.join(20)
        times = []
        while not times or times[-1] < 100.54:
            times.append(clock.next(20).clock.to_sec())
    assert times == sorted(times)
    assert len(set(times)) > 20


def test_playing_pauses_before_messages_of_chosen_topics(
    nodes: tuple[Node, Node], bags: list[BagReader]
) -> None:
    """Each of them waits for a step or for resume; without `pause_on_topics` none does."""
    order: list[str] = []
    held: list[tuple[int, str]] = []

    def tick(player: Player) -> None:
        if player.paused and not player._steps:
            held.append((len(order), "/b"))
            if len(held) == 3:
                player.pause_on_topics = False
            (player.step if len(held) == 1 else player.resume)()

    options = {"topics": ["/a", "/b"], "skip_empty": 0.2, "pause_topics": ["/b"], "on_tick": tick}
    with Player(nodes[0], bags, **options) as player:  # type: ignore[arg-type]
        assert player.play(lambda topic, stamp: order.append(topic)) == 20
    assert order == ["/a", "/b"] * 10
    # Before the first /b; then, as a step leaves it paused, before /a; then before the second /b.
    assert [count for count, _ in held] == [1, 2, 3]


def test_playing_waits_for_a_topic_that_tells_how_far_somebody_is(
    nodes: tuple[Node, Node], bags: list[BagReader]
) -> None:
    """The bags' time stands while it is more than the delay ahead of the newest header stamp."""
    one, two = nodes
    order: list[int] = []
    waited: list[str] = []
    stamped = two.publisher("/done", "geometry_msgs/PointStamped", queue_size=10)

    def tick(player: Player) -> None:
        if player.waits_for:
            waited.append(player.waits_for)
            message = message_class("geometry_msgs/PointStamped")()
            message.header.stamp = Time(160, 0)
            stamped.publish(message)

    options = {"topics": ["/a"], "rate": 100.0, "rate_control": "/done", "rate_control_delay": 2.0}
    with Player(one, bags, on_tick=tick, **options) as player:  # type: ignore[arg-type]
        stamped.wait_for_connection(20)
        assert player.play(lambda topic, stamp: order.append(stamp.secs)) == 10
    assert set(waited) == {"/done"}
    assert order == [100] * 5 + [160] * 5


def test_who_is_woken_late_does_not_pass_the_next_message_by(
    nodes: tuple[Node, Node], bags: list[BagReader]
) -> None:
    """/clock and who is waited for go by the bags' time: ahead of what was played, it would wait for ever."""
    now = 0.0

    def sleep(seconds: float) -> None:
        nonlocal now
        now += seconds + (3.0 if seconds > 0.01 else 1e-4)

    seen: list[tuple[int, int]] = []

    def tick(player: Player) -> None:
        seen.append((player.published, player.position_ns))

    pacer = Pacer(lambda: now, sleep)
    with Player(nodes[0], bags, topics=["/a"], rate=100.0, pacer=pacer, on_tick=tick) as player:
        times = [entry.time_ns for entry in player.timeline]
        assert player.play() == 10
    assert len(seen) > 1
    assert all(position <= times[published] for published, position in seen)


def test_a_rate_control_topic_without_header_counts_when_it_comes(
    nodes: tuple[Node, Node], bags: list[BagReader]
) -> None:
    """Each message lets playing go on for the delay, from where it is."""
    one, two = nodes
    told = two.publisher("/told", String, queue_size=10)
    waits = 0

    def tick(player: Player) -> None:
        nonlocal waits
        if player.waits_for:
            waits += 1
            told.publish(data="go on")

    options = {"topics": ["/a"], "rate": 25.0, "rate_control": "/told", "rate_control_delay": 20.0}
    with Player(one, bags, on_tick=tick, **options) as player:  # type: ignore[arg-type]
        told.wait_for_connection(20)
        assert player.play() == 10
    assert waits >= 2  # a minute in steps of 20 s and a little


def test_a_rate_control_delay_below_zero_is_refused(nodes: tuple[Node, Node], bags: list[BagReader]) -> None:
    """And says what it may be."""
    with pytest.raises(ValueError, match="rate_control_delay -1"):
        Player(nodes[0], bags, rate_control="/x", rate_control_delay=-1)
