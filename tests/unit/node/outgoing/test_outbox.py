"""The outbox of one subscriber: order, bound, and messages that are half on the wire."""

from __future__ import annotations

from rosproto.node.outgoing.frames import LargeFrame
from rosproto.node.outgoing.queued_link import Outbox


def drain(outbox: Outbox, at_most: int = 1 << 30) -> bytes:
    """Take everything out, `at_most` bytes per send."""
    out = b""
    while outbox:
        data = b"".join(bytes(part) for part in outbox.take())
        out += data[:at_most]
        outbox.sent(min(at_most, len(data)))
    return out


def test_frames_come_out_in_order() -> None:
    """What was put first is sent first."""
    outbox = Outbox(10)
    for frame in (b"one", b"two", b"three"):
        outbox.put(frame)
    assert drain(outbox) == b"onetwothree"
    assert not outbox


def test_the_oldest_is_dropped_and_counted() -> None:
    """With room for two, two new ones push two old ones out."""
    outbox = Outbox(2)
    for frame in (b"1", b"2", b"3", b"4"):
        outbox.put(frame)
    assert outbox.dropped == 2
    assert drain(outbox) == b"34"


def test_a_frame_begun_is_finished_whatever_is_dropped() -> None:
    """Bytes already sent bind: the rest of that frame goes first, and is not dropped."""
    outbox = Outbox(1)
    outbox.begin([memoryview(b"rest")])
    for frame in (b"old", b"new"):
        outbox.put(frame)
    assert len(outbox) == 2
    assert drain(outbox) == b"restnew"


def test_any_cut_gives_the_same_bytes() -> None:
    """However few bytes a send takes, nothing is lost, doubled or reordered."""
    frames = [bytes([number]) * (number % 7 + 1) for number in range(50)]
    for at_most in range(1, 20):
        outbox = Outbox(100)
        for frame in frames:
            outbox.put(frame)
        assert drain(outbox, at_most) == b"".join(frames)


def test_a_frame_in_parts_is_sent_in_parts() -> None:
    """Immutable parts are kept as they are, between small frames, and cut anywhere."""
    for at_most in (1, 3, 7, 1000):
        outbox = Outbox(10)
        outbox.put(b"small")
        large = LargeFrame([b"head", b"body" * 3])
        kept = large.frozen()
        assert kept is large
        outbox.put(kept)
        outbox.put(b"after")
        assert drain(outbox, at_most) == b"small" + large.owned() + b"after"


def test_clear_counts_what_is_lost() -> None:
    """A dead link's queue is dropped, the frame begun included."""
    outbox = Outbox(5)
    outbox.begin([memoryview(b"x")])
    outbox.put(b"y")
    assert outbox.clear() == 2
    assert not outbox
    assert outbox.take() == []
