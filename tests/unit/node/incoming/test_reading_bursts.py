"""A connection in a burst is left alone for a moment, so that one read brings many messages; no other is."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator

import pytest

from rosproto.errors import ConnectionLost
from rosproto.node.incoming import tcpros_link
from rosproto.node.incoming.tcpros_link import (
    BURST_GAP_SECONDS,
    LOOK_AFTER,
    MAX_PAUSED_BYTES,
    NO_PAUSE_SECONDS,
    PAUSE_SECONDS,
    FrameReader,
)
from tests.unit.node.incoming.test_frame_reader import Pieces, as_bytes, frames

SINGLE = frames(bytes(48))


class Clock:
    """The time that passes is the time between messages, and that of rests."""

    def __init__(self) -> None:
        self.now = 1000.0
        self.rests: list[float] = []
        self.rest_takes = PAUSE_SECONDS

    def time(self) -> float:
        return self.now

    def sleep(self, seconds: float) -> None:
        self.rests.append(seconds)
        self.now += self.rest_takes


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    clock = Clock()
    monkeypatch.setattr(tcpros_link, "perf_counter", clock.time)
    monkeypatch.setattr(tcpros_link, "sleep", clock.sleep)
    return clock


def read_all(pieces: Iterator[bytes]) -> None:
    reader = FrameReader(Pieces(pieces), 1 << 30, peer="test")  # type: ignore[arg-type]
    while True:
        reader.receive(as_bytes, False)


@pytest.fixture
def read() -> Callable[[Iterator[bytes]], None]:
    def until_the_end(pieces: Iterator[bytes]) -> None:
        with pytest.raises(ConnectionLost):
            read_all(pieces)

    return until_the_end


def stream(clock: Clock, count: int, apart: float, piece: bytes = SINGLE) -> Iterator[bytes]:
    for _ in range(count):
        clock.now += apart * (len(piece) // len(SINGLE))
        yield piece


def test_messages_that_come_one_by_one_and_close_together_are_left_to_gather(
    clock: Clock, read: Callable[[Iterator[bytes]], None]
) -> None:
    """A rest for every so many of them."""
    read(stream(clock, 10 * LOOK_AFTER, BURST_GAP_SECONDS / 4))
    assert len(clock.rests) >= 5
    assert set(clock.rests) == {PAUSE_SECONDS}


def test_messages_with_time_between_them_are_read_at_once(
    clock: Clock, read: Callable[[Iterator[bytes]], None]
) -> None:
    """Round trips, and topics of any rate that a robot has: not one rest."""
    read(stream(clock, 10 * LOOK_AFTER, BURST_GAP_SECONDS * 1.5))
    read(stream(clock, 10 * LOOK_AFTER, 1 / 2000))
    assert clock.rests == []


def test_a_read_that_brought_much_needs_no_rest(
    clock: Clock, read: Callable[[Iterator[bytes]], None]
) -> None:
    """The rest is for wake-ups that bring little: a full buffer is read on."""
    much = SINGLE * (2 * MAX_PAUSED_BYTES // len(SINGLE))
    read(stream(clock, 2, BURST_GAP_SECONDS / 10, much))  # the buffer grows to it
    clock.rests.clear()
    reader_sees = iter([much * 40])
    read(reader_sees)
    assert len(clock.rests) <= 3  # while the buffer was small


def test_rests_that_take_long_are_given_up_for_a_while(
    clock: Clock, read: Callable[[Iterator[bytes]], None]
) -> None:
    """Another thread computes: each rest is one more wait of a whole turn for the interpreter."""
    clock.rest_takes = sys.getswitchinterval() + PAUSE_SECONDS
    read(stream(clock, 100 * LOOK_AFTER, BURST_GAP_SECONDS / 4))
    assert len(clock.rests) == 2


def test_rests_come_back(clock: Clock, read: Callable[[Iterator[bytes]], None]) -> None:
    """After a second one is tried again."""

    def pieces() -> Iterator[bytes]:
        clock.rest_takes = sys.getswitchinterval() + PAUSE_SECONDS
        yield from stream(clock, 20 * LOOK_AFTER, BURST_GAP_SECONDS / 4)
        clock.rest_takes = PAUSE_SECONDS
        clock.now += NO_PAUSE_SECONDS
        clock.rests.clear()
        yield from stream(clock, 20 * LOOK_AFTER, BURST_GAP_SECONDS / 4)

    read(pieces())
    assert len(clock.rests) > 5
