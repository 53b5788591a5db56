"""The buffer before the disk, and the selection of topics."""

from __future__ import annotations

import threading

import pytest

from rosproto.bag import Connection, RawMessage
from rosproto.recording import MessageBuffer, TopicSelection
from rosproto.recording.buffer import OVERHEAD, SLICE_BYTES, Entry
from rosproto.time import Time

CONNECTION = Connection(-1, "/a", "std_msgs/String", "0" * 32, "string data", {})


def entry(number: int, size: int = 100) -> Entry:
    raw = RawMessage("std_msgs/String", bytes(size), "0" * 32, (0, 0), CONNECTION)
    return Entry("/a", raw, Time(number, 0))


def test_the_oldest_is_dropped_and_counted() -> None:
    """What is kept is the newest that fits, and every lost message is counted."""
    buffer = MessageBuffer(3 * (100 + OVERHEAD))
    for number in range(10):
        buffer.put(entry(number))
    assert (buffer.received, buffer.dropped) == (10, 7)
    assert [e.time.secs for e in buffer.take(0)] == [7, 8, 9]
    assert buffer.bytes == 3 * (100 + OVERHEAD), "they are not written yet"
    assert buffer.take(0) == []
    assert buffer.bytes == 0


def test_a_slice_is_bounded() -> None:
    """One take hands out about SLICE_BYTES, so that the rest can still be dropped."""
    buffer = MessageBuffer(1 << 30)
    for number in range(5):
        buffer.put(entry(number, SLICE_BYTES // 2))
    assert [len(buffer.take(0)) for _ in range(4)] == [2, 2, 1, 0]


def test_the_writer_is_woken_by_much_and_by_the_end() -> None:
    """It sleeps through small messages, wakes for a chunk's worth, and when closed."""
    buffer = MessageBuffer(1 << 20, wake_bytes=1000)
    got: list[int] = []
    ready = threading.Event()

    def write() -> None:
        for _ in range(2):
            ready.set()
            got.append(len(buffer.take(30.0)))

    thread = threading.Thread(target=write, daemon=True)
    thread.start()
    ready.wait(20)
    for number in range(4):
        buffer.put(entry(number))
    while not got and thread.is_alive():
        thread.join(0.01)
    buffer.put(entry(9))
    buffer.close()
    thread.join(20)
    assert not thread.is_alive()
    assert sum(got) == 5
    buffer.put(entry(10))
    assert buffer.received == 5, "closed: nothing more is taken"


def test_topics_by_name_pattern_node_and_exclusion() -> None:
    """Patterns match whole names; exclusion does not touch what was named."""
    chosen = TopicSelection(["/kept"], patterns=["/cam.*"], exclude=["/camera/raw", "/kept"], node="/nav")
    assert chosen.takes("/kept")
    assert chosen.takes("/camera/info")
    assert not chosen.takes("/camera/raw")
    assert not chosen.takes("/x/camera")
    assert chosen.takes("/scan", ["/nav", "/other"])
    assert not chosen.takes("/scan", ["/other"])
    assert chosen.is_open
    assert not TopicSelection(["/a"]).is_open
    everything = TopicSelection(all=True, exclude=["/b.*"])
    assert everything.takes("/a")
    assert not everything.takes("/bb")


def test_wrong_choices_are_refused() -> None:
    """Nothing chosen, and a pattern that is none."""
    with pytest.raises(ValueError, match="nothing to record"):
        TopicSelection()
    with pytest.raises(ValueError, match="not a regular expression"):
        TopicSelection(patterns=["("])
    with pytest.raises(ValueError, match="buffer"):
        MessageBuffer(0)
