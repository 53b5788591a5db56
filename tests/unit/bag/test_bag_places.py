"""The plain loop for a few messages of a chunk gives what numpy gives, whatever is odd about them."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import pytest

from rosproto.bag import BagReader, BagWriter, chunk
from rosproto.bag.message_offsets import locate_few
from rosproto.codec import encode, message_class
from rosproto.errors import BagError
from rosproto.time import Time
from tests.unit.bag.bagmaker import bag_bytes, read

Image = message_class("sensor_msgs/Image")
String = message_class("std_msgs/String")


def pictures(count: int = 12, *, backwards: bool = False) -> list[tuple[str, Any, Time]]:
    """Pictures of 20 kB with a text between them."""
    made: list[tuple[str, Any, Time]] = []
    for i in range(count):
        number = count - i if backwards else i
        made.append(("/image", Image(height=1, width=20_000, data=bytes([i]) * 20_000), Time(10 + number)))
        made.append(("/said", String(data=f"text {i}"), Time(10 + number, 500)))
    return made


def seen(data: bytes, **options: Any) -> list[tuple[str, bytes, Time, tuple[int, int]]]:
    found = read(data).read_messages(raw=True, **options)
    return [(topic, bytes(raw.data), stamp, raw.position) for topic, raw, stamp in found]


def general(monkeypatch: pytest.MonkeyPatch, data: bytes, **options: Any) -> Any:
    """The same by numpy."""
    with monkeypatch.context() as patch:
        patch.setattr(chunk, "locate_few", lambda *_: None)
        return seen(data, **options)


@pytest.mark.parametrize("compression", ["none", "lz4", "bz2"])
@pytest.mark.parametrize("backwards", [False, True])
@pytest.mark.parametrize(
    "options",
    [
        {},
        {"topics": "/said"},
        {"topics": "/image"},
        {"start_time": 13.0, "end_time": 17.0},
        {"topics": "/no"},
    ],
)
def test_the_same_as_by_numpy(
    monkeypatch: pytest.MonkeyPatch, compression: str, backwards: bool, options: dict[str, Any]
) -> None:
    """Messages, times, order and positions."""
    data = bag_bytes(pictures(backwards=backwards), compression, 60_000)
    expected = general(monkeypatch, data, **options)
    assert seen(data, **options) == expected
    viewed = [raw.data for _, raw, _ in read(data).read_messages(raw="view", **options)]
    assert [bytes(view) for view in viewed] == [entry[1] for entry in expected]
    assert all(isinstance(view, memoryview) and view.readonly for view in viewed)
    decoded = [encode(message) for _, message, _ in read(data).read_messages(**options)]
    assert decoded == [entry[1] for entry in expected]


def test_views_are_written_again() -> None:
    """A raw message with a view is as good as one with bytes."""
    data = bag_bytes(pictures(), "lz4", 60_000)
    copy = io.BytesIO()
    with BagWriter(copy) as writer:
        for topic, raw, stamp in read(data).read_messages(raw="view"):
            writer.write(topic, raw, stamp)
    assert [entry[:3] for entry in seen(copy.getvalue())] == [entry[:3] for entry in seen(data)]


def test_another_order_of_fields(monkeypatch: pytest.MonkeyPatch) -> None:
    """Heads as rospy's rosbag writes them: op before conn."""
    data = bag_bytes(pictures(), "none", 60_000)
    ours = b"\4\0\0\0op=\2"
    for number in range(2):
        conn = b"\x09\0\0\0conn=" + number.to_bytes(4, "little")
        assert conn + ours in data
        data = data.replace(conn + ours + b"\x0d", ours + conn + b"\x0d")
    bag = read(data)
    held = bag._read_chunk(bag.chunks[0])
    found = locate_few(held.blob, held.base, held.end, held.info.counts)
    assert found is not None
    assert len(found) == sum(held.info.counts.values())
    assert seen(data) == general(monkeypatch, data)


@pytest.mark.parametrize("compression", ["none", "lz4"])
def test_every_changed_byte_gives_the_same_as_by_numpy(
    monkeypatch: pytest.MonkeyPatch, compression: str
) -> None:
    """Messages or the same error, byte for byte around the heads."""
    whole = bag_bytes(pictures(2), compression, 60_000)
    start = read(whole).chunks[0].pos

    def outcome(data: bytes, find: Any) -> Any:
        try:
            return find(data)
        except BagError as problem:
            return str(problem)

    for at in range(start, start + 500, 3):
        data = whole[:at] + bytes([whole[at] ^ 0x55]) + whole[at + 1 :]
        theirs = outcome(data, lambda d: general(monkeypatch, d))
        assert outcome(data, seen) == theirs, at


def test_damage_is_left_out_when_asked() -> None:
    """The chunk that cannot be unpacked, and nothing else."""
    data = bytearray(bag_bytes(pictures(), "lz4", 60_000))
    bag = read(bytes(data))
    broken = bag.chunks[1]
    data[broken.pos + 120] ^= 0xFF
    skipping = read(bytes(data), skip_damaged=True)
    count = sum(1 for _ in skipping.read_messages(raw=True))
    assert count == bag.message_count - sum(broken.counts.values())
    assert f"byte {broken.pos}" in skipping.damage[0]


def test_a_bag_that_is_closed_between_messages(tmp_path: Path) -> None:
    """The iterator fails with the reason, when the next chunk is to be read."""
    (tmp_path / "a.bag").write_bytes(bag_bytes(pictures(), "none", 60_000))
    bag = BagReader(tmp_path / "a.bag")
    messages = bag.read_messages(raw=True)
    next(messages)
    bag.close()
    with pytest.raises(BagError, match="the bag is closed"):
        list(messages)


def test_raw_is_true_false_or_view() -> None:
    """Another word is refused at once."""
    with pytest.raises(ValueError, match="view"):
        read(bag_bytes(pictures(1))).read_messages(raw="bytes")  # type: ignore[arg-type]
