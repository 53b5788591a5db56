"""Splitting a stream into length-prefixed frames."""

from __future__ import annotations

import struct
import sys

import pytest

from rosproto.errors import LocalProtocolError, TooLarge
from rosproto.protocol.framing import BATCH, LARGE, MOST_ROOM, FrameDecoder, frame
from tests.support.splits import every_split, slices_of_one_buffer

PAYLOADS = [b"one", b"", b"x" * 300, b"last"]
STREAM = b"".join(map(frame, PAYLOADS))


def test_a_frame_is_the_little_endian_length_and_the_payload() -> None:
    assert frame(b"abc") == b"\x03\0\0\0abc"
    assert frame(memoryview(struct.pack("<2I", 1, 2)).cast("I")) == b"\x08\0\0\0\x01\0\0\0\x02\0\0\0"


def test_every_split_of_a_stream_gives_the_same_frames() -> None:
    for pieces in every_split(STREAM):
        decoder, frames = FrameDecoder(1000), []
        for piece in slices_of_one_buffer(pieces):
            decoder.receive(piece)
            frames += decoder.frames()
        assert frames == PAYLOADS
        assert decoder.buffered == 0


def test_frames_may_be_added_while_they_are_taken_out() -> None:
    decoder = FrameDecoder(10)
    decoder.receive(frame(b"a"))
    taken = []
    for payload in decoder.frames():
        taken.append(payload)
        if len(taken) == 1:
            decoder.receive(frame(b"b"))
    assert taken == [b"a", b"b"]


def test_trailing_bytes_wait_and_are_handed_over() -> None:
    decoder = FrameDecoder(1000)
    decoder.receive(STREAM + b"\x05\0\0\0ab")
    assert list(decoder.frames()) == PAYLOADS
    assert (decoder.buffered, decoder.missing) == (6, 3)
    assert decoder.left_over() == b"\x05\0\0\0ab"
    assert (decoder.buffered, decoder.missing) == (0, 4)


def test_a_length_above_the_limit_is_refused_before_its_bytes_come_and_ever_after() -> None:
    decoder = FrameDecoder(100, "header_bytes")
    decoder.receive(frame(b"x" * 100) + struct.pack("<I", 101))
    assert decoder.next_frame() == b"x" * 100
    for _ in range(2):
        with pytest.raises(TooLarge) as caught:
            decoder.next_frame()
        assert (caught.value.what, caught.value.size, caught.value.limit) == ("header_bytes", 101, 100)


@pytest.mark.promise("A length is checked before memory is taken")
def test_memory_follows_the_bytes_that_arrived_not_the_announced_length() -> None:
    decoder = FrameDecoder(1_000_000_000)
    decoder.receive(struct.pack("<I", 1_000_000_000) + b"abc")
    assert decoder.next_frame() is None
    assert decoder.buffer.__sizeof__() < 1000
    assert decoder.missing == 1_000_000_000 - 3


def test_a_service_answer_is_an_ok_byte_and_a_frame() -> None:
    answer = b"\x01" + frame(b"") + b"\x00" + frame("Fehler: ß".encode())
    for pieces in every_split(answer):
        decoder, out = FrameDecoder(100), []
        for piece in pieces:
            decoder.receive(piece)
            while True:
                item = decoder.take(1) if len(out) % 2 == 0 else decoder.next_frame()
                if item is None:
                    break
                out.append(item)
        assert out == [b"\x01", b"", b"\x00", "Fehler: ß".encode()]


@pytest.mark.promise("One segment may carry the rest of a")
def test_a_header_and_the_messages_behind_it_may_share_a_segment() -> None:
    decoder = FrameDecoder(10, "header_bytes")
    decoder.receive(frame(b"head") + frame(b"m" * 50))
    assert decoder.next_frame() == b"head"
    decoder.limit, decoder.what = 1000, "message_bytes"
    assert list(decoder.frames()) == [b"m" * 50]


def test_a_frame_beyond_4_gib_is_our_error() -> None:
    class Huge(bytes):
        def __len__(self) -> int:
            return 1 << 32

    with pytest.raises(LocalProtocolError):
        frame(Huge())


def test_one_frame_that_came_whole_is_taken_at_once_and_anything_else_is_not() -> None:
    """Bytes before it may be left out; what is not taken waits as if nothing had been asked."""
    for ahead in (b"", b"\x01"):
        for stream, taken in (
            (ahead + frame(b"abc"), b"abc"),
            (ahead + frame(b""), b""),
            (ahead + frame(b"abc") + b"\x01", None),
            (ahead + frame(b"abc")[:-1], None),
            (ahead + frame(bytes(101)), None),
            (b"\x01\0", None),
        ):
            decoder = FrameDecoder(100)
            decoder.space()[: len(stream)] = stream
            assert decoder.whole(len(stream), len(ahead)) == taken
            assert decoder.buffered == 0
            if taken is None:
                decoder.received(len(stream))
                assert decoder.left_over() == stream
    waiting = FrameDecoder(100)
    waiting.receive(b"\x03\0")
    waiting.space()[:5] = b"\0\0abc"
    assert waiting.whole(5) is None


def test_a_long_frame_is_received_into_memory_of_its_own() -> None:
    """By `space`, in steps, between short ones, and by `receive`, which may bring more than the frame."""
    long = bytes(range(256)) * 3000
    stream = frame(b"a") + frame(long) + frame(b"b")
    for step in (1000, 200_000, len(stream)):
        for by_space in (True, False):
            decoder, found = FrameDecoder(1 << 20, step=4096), []
            position = 0
            while position < len(stream):
                piece = stream[position : position + step]
                if by_space:
                    space = decoder.space()
                    piece = piece[: len(space)]
                    space[: len(piece)] = piece
                    decoder.received(len(piece))
                else:
                    decoder.receive(piece)
                position += len(piece)
                found += decoder.frames()
            assert found == [b"a", long, b"b"]
            assert decoder.count == 3


def test_a_long_frame_that_is_not_taken_out_waits_with_what_follows() -> None:
    """`receive` may be called before anybody looks."""
    long = bytes(200_000)
    decoder = FrameDecoder(1 << 20)
    for piece in (frame(long)[:1000], frame(long)[1000:], frame(b"x"), b"\x01"):
        decoder.receive(piece)
    assert decoder.next_frame() == long
    assert decoder.next_frame() == b"x"
    assert decoder.left_over() == b"\x01"
    half = FrameDecoder(1 << 20)
    half.receive(frame(long)[:5000])
    half.space()
    assert half.missing == 200_004 - 5000
    assert half.is_large
    assert half.left_over() == frame(long)[:5000]


def as_bytes(buffer: bytes, start: int, end: int) -> bytes:
    return bytes(buffer[start:end])


@pytest.mark.parametrize("owns", [False, True])
def test_frames_are_decoded_where_they_lie(owns: bool) -> None:
    """In portions; of a burst only the newest when no more are of use; long ones in their own memory."""
    bodies = [bytes([n]) for n in range(100)]
    decoder = FrameDecoder(1 << 20)
    decoder.receive(b"".join(map(frame, bodies)) + b"\x09")
    assert decoder.decoded(as_bytes, owns) == bodies[:BATCH]
    assert decoder.decoded(as_bytes, owns, newest=3) == bodies[-3:]
    assert (decoder.count, decoder.passed_over) == (100, 100 - BATCH - 3)
    assert decoder.decoded(as_bytes, owns) == decoder.decoded(as_bytes, owns, newest=3) == []
    decoder.receive(b"\0\0\0" + bytes(8))
    assert decoder.decoded(as_bytes, owns, newest=1) == []  # a byte is missing
    decoder.receive(b"!" + frame(bytes(LARGE + 1)))
    assert decoder.decoded(as_bytes, owns) == [bytes(8) + b"!", bytes(LARGE + 1)]


def test_memory_of_a_long_frame_doubles_with_what_has_arrived() -> None:
    """A megabyte announced, four kilobytes taken at first."""
    body = bytes(range(256)) * 4000
    decoder, stream = FrameDecoder(1 << 20, step=4096), memoryview(frame(body))
    position, sizes = 0, set()
    while not (found := decoder.decoded(as_bytes, owns=False)):
        space = decoder.space()
        sizes.add(len(space))
        count = min(len(space), 3000, len(stream) - position)
        space[:count] = stream[position : position + count]
        decoder.received(count)
        position += count
    assert found == [body]
    assert max(sizes) <= len(body) // 2 + 4096


def test_memory_is_numpys_where_it_is_loaded(monkeypatch: pytest.MonkeyPatch) -> None:
    """It is not filled with zeros first; without numpy a bytearray does as well."""
    for loaded in (True, False):
        if not loaded:
            monkeypatch.delitem(sys.modules, "numpy", raising=False)
        decoder = FrameDecoder(1 << 20)
        decoder.receive(frame(bytes(LARGE + 1)))
        assert decoder.next_frame() == bytes(LARGE + 1)


def test_a_buffer_that_a_read_filled_grows() -> None:
    """More would have come: the next read shall bring it. There is a bound to that."""
    decoder = FrameDecoder(100, room=8)
    decoder.receive(frame(b"abcd"))
    assert decoder.next_frame() == b"abcd"
    assert len(decoder.space()) > 8
    largest = FrameDecoder(MOST_ROOM, room=MOST_ROOM)
    largest.receive(frame(bytes(MOST_ROOM - 4)))
    assert largest.next_frame() == bytes(MOST_ROOM - 4)
    assert len(largest.space()) == MOST_ROOM


def test_what_follows_a_length_that_is_refused_takes_no_room_of_that_length() -> None:
    """`receive` takes it; asking for the frame, or for space to receive into, refuses it."""
    decoder = FrameDecoder(100, room=8)
    decoder.receive(struct.pack("<I", 1 << 30) + bytes(300_000))
    assert decoder.buffered == 300_004
    assert len(decoder.buffer) < 700_000
    for ask in (decoder.next_frame, decoder.space):
        with pytest.raises(TooLarge):
            ask()
