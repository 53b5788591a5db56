"""The pacer, with the test's clock, and the span that is played."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from rosproto import Master, Node
from rosproto.bag import BagReader, BagWriter
from rosproto.codec import message_class
from rosproto.errors import BagError
from rosproto.recording import Pacer, Player, Timeline
from rosproto.recording.timeline import TimelineEntry
from rosproto.time import Time

String = message_class("std_msgs/String")


class FakeTime:
    """A clock that only sleeping moves; each sleep is late by `late`."""

    def __init__(self, late: float) -> None:
        self.now = 100.0
        self.late = late
        self.long_sleeps: list[float] = []

    def read(self) -> float:
        return self.now

    def sleep(self, seconds: float) -> None:
        if seconds:
            self.long_sleeps.append(seconds)
            self.now += seconds + self.late
        else:
            self.now += 1e-5


def test_the_pacer_learns_how_late_it_is_woken() -> None:
    """After one late wake-up it sleeps less and spins more, and hits the moment."""
    time = FakeTime(late=0.002)
    pacer = Pacer(time.read, time.sleep)
    pacer.wait_until(100.1)
    assert time.now - 100.1 > 0.001, "the first time it could not know"
    for step in range(2, 6):
        pacer.wait_until(100 + step / 10)
        assert 0 <= time.now - (100 + step / 10) < 1e-4


def test_the_pacer_does_not_spin_for_ever_on_a_coarse_system() -> None:
    """15 ms late, as an old Windows: spinning is bounded to 3 ms."""
    time = FakeTime(late=0.015)
    pacer = Pacer(time.read, time.sleep)
    for step in range(5):
        pacer.wait_until(100 + step)
    assert pacer.spin == 0.003


def test_a_moment_that_has_passed_is_not_waited_for() -> None:
    """No sleep at all."""
    time = FakeTime(late=0.0)
    Pacer(time.read, time.sleep).wait_until(99.0)
    assert time.now == 100.0


@pytest.fixture
def bags(tmp_path: Path) -> list[BagReader]:
    """Two bags that overlap in time; the first has two latched publishers on one topic."""
    with BagWriter(tmp_path / "a.bag") as a, BagWriter(tmp_path / "b.bag") as b:
        for name in "xy":
            header = {"callerid": f"/{name}", "latching": "1"}
            a.write("/tf_static", String(data=f"old {name}"), 100.0, header=header)
            a.write("/tf_static", String(data=f"new {name}"), 101.0, header=header)
        for i in range(10):
            a.write("/a", String(data=f"a{i}"), 100.0 + i)
            b.write("/b", String(data=f"b{i}"), 100.5 + i)
    return [BagReader(tmp_path / "a.bag"), BagReader(tmp_path / "b.bag")]


def text(data: bytes) -> str:
    return data[4:].decode()


def test_several_bags_are_played_by_time(bags: list[BagReader]) -> None:
    """Messages of all bags in one order; the span covers all."""
    line = Timeline(bags, topics=["/a", "/b"])
    assert [text(e.message.data) for e in line] == [f"{x}{i}" for i in range(10) for x in "ab"]
    assert (line.start_ns, line.end_ns) == (100 * 10**9, 1095 * 10**8)


def test_a_span_and_what_was_latched_before_it(bags: list[BagReader]) -> None:
    """Start and duration cut; each latched publisher's last message before is told."""
    line = Timeline(bags, start=5.0, duration=1.0)
    assert [text(e.message.data) for e in line] == ["a5", "b5", "a6"]
    assert [text(e.message.data) for e in line.latched_before()] == ["new x", "new y"]
    assert Timeline(bags).latched_before() == []


def test_unknown_topics_are_an_error(bags: list[BagReader]) -> None:
    """The text lists what there is."""
    with pytest.raises(BagError, match="/a, /b, /tf_static"):
        Timeline(bags, topics=["/nowhere"])
    with pytest.raises(ValueError, match="negative"):
        Timeline(bags, start=-1)


class Late(Pacer):
    """A computer so busy that every wait takes 30 ms too long."""

    def wait_until(self, moment: float) -> None:
        super().wait_until(moment + 0.03)


def test_the_clock_never_goes_back_on_a_busy_computer(tmp_path: Path) -> None:
    """Messages that come late do not set /clock back to their own time; a loop begins again at the start."""
    with BagWriter(tmp_path / "x.bag") as writer:
        for i in range(20):
            writer.write("/x", String(data=str(i)), 100.0 + i * 0.02)
    with (
        Master() as master,
        Node("/player", master_uri=master.uri) as node,
        BagReader(tmp_path / "x.bag") as bag,
        Player(node, bag, clock_hz=500.0, pacer=Late()) as player,
    ):
        assert player._clock is not None
        published: list[int] = []
        send = player._clock.publish
        player._clock.publish = lambda ns: (published.append(ns), send(ns))  # type: ignore[method-assign, assignment, func-returns-value, return-value]
        player.play()
        assert published == sorted(published)
        assert published[0] == 100 * 10**9
        assert published[-1] >= 100_380_000_000
        count = len(published)
        player.play()
        assert published[count] == 100 * 10**9


def test_reading_the_first_chunk_makes_no_message_late(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It takes a while (numpy is imported with it); the bag's time begins to run afterwards, in a loop too."""
    with BagWriter(tmp_path / "x.bag") as writer:
        for i in range(4):
            writer.write("/x", String(data=str(i)), 100.0 + i * 0.02)
    fake = FakeTime(late=0.0)
    read = Timeline.__iter__

    def slowly(timeline: Timeline) -> Iterator[TimelineEntry]:
        fake.now += 0.3
        yield from read(timeline)

    monkeypatch.setattr(Timeline, "__iter__", slowly)
    moments: list[float] = []
    with (
        Master() as master,
        Node("/player", master_uri=master.uri) as node,
        BagReader(tmp_path / "x.bag") as bag,
        Player(node, bag, pacer=Pacer(fake.read, fake.sleep), loop=True) as player,
    ):

        def published(topic: str, stamp: Time) -> None:
            moments.append(fake.now)
            if len(moments) == 8:
                player.stop()

        player.play(published)
    for round_ in (moments[:4], moments[4:]):
        assert [moment - round_[0] for moment in round_] == pytest.approx([0.0, 0.02, 0.04, 0.06], abs=0.002)
