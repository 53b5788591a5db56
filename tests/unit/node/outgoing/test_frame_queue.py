"""The queue of one subscriber: order, bound, and messages that are half on the wire."""

from __future__ import annotations

from rosproto.node.outgoing.frames import LargeFrame
from rosproto.node.outgoing.queued_link import FrameQueue


def drain(queue: FrameQueue, at_most: int = 1 << 30) -> bytes:
    """Take everything out, `at_most` bytes per send."""
    out = b""
    while queue:
        data = b"".join(bytes(part) for part in queue.take())
        out += data[:at_most]
        queue.sent(min(at_most, len(data)))
    return out


def test_frames_come_out_in_order() -> None:
    """What was put first is sent first."""
    queue = FrameQueue(10)
    for frame in (b"one", b"two", b"three"):
        queue.put(frame)
    assert drain(queue) == b"onetwothree"
    assert not queue


def test_the_oldest_is_dropped_and_counted() -> None:
    """With room for two, two new ones push two old ones out."""
    queue = FrameQueue(2)
    for frame in (b"1", b"2", b"3", b"4"):
        queue.put(frame)
    assert queue.dropped == 2
    assert drain(queue) == b"34"


def test_a_frame_begun_is_finished_whatever_is_dropped() -> None:
    """Bytes already sent bind: the rest of that frame goes first, and is not dropped."""
    queue = FrameQueue(1)
    queue.begin([memoryview(b"rest")])
    for frame in (b"old", b"new"):
        queue.put(frame)
    assert len(queue) == 2
    assert drain(queue) == b"restnew"


def test_any_cut_gives_the_same_bytes() -> None:
    """However few bytes a send takes, nothing is lost, doubled or reordered."""
    frames = [bytes([number]) * (number % 7 + 1) for number in range(50)]
    for at_most in range(1, 20):
        queue = FrameQueue(100)
        for frame in frames:
            queue.put(frame)
        assert drain(queue, at_most) == b"".join(frames)


def test_a_frame_in_parts_is_sent_in_parts() -> None:
    """Immutable parts are kept as they are, between small frames, and cut anywhere."""
    for at_most in (1, 3, 7, 1000):
        queue = FrameQueue(10)
        queue.put(b"small")
        large = LargeFrame([b"head", b"body" * 3])
        kept = large.frozen()
        assert kept is large
        queue.put(kept)
        queue.put(b"after")
        assert drain(queue, at_most) == b"small" + large.owned() + b"after"


def test_clear_counts_what_is_lost() -> None:
    """A dead link's queue is dropped, the frame begun included."""
    queue = FrameQueue(5)
    queue.begin([memoryview(b"x")])
    queue.put(b"y")
    assert queue.clear() == 2
    assert not queue
    assert queue.take() == []
