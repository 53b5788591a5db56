"""Splitting a stream into length-prefixed frames."""

from __future__ import annotations

import struct
import sys

import pytest

from rosproto.errors import LocalProtocolError, TooLarge
from rosproto.protocol.framing import BATCH, LARGE, MAX_ROOM, FrameDecoder, frame
from tests.support.frames import feed, fill
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
            frames += feed(decoder, piece)
        assert frames == PAYLOADS
        assert decoder.buffered == 0


def test_trailing_bytes_wait_for_the_rest() -> None:
    decoder = FrameDecoder(1000)
    assert list(feed(decoder, STREAM + b"\x05\0\0\0ab")) == PAYLOADS
    assert decoder.buffered == 6
    assert list(feed(decoder, b"cde")) == [b"abcde"]
    assert decoder.buffered == 0


def test_a_length_above_the_limit_is_refused_before_its_bytes_come_and_ever_after() -> None:
    decoder = FrameDecoder(100)
    fill(decoder, frame(b"x" * 100) + struct.pack("<I", 101))
    assert decoder.next_frame() == b"x" * 100
    for _ in range(2):
        with pytest.raises(TooLarge) as caught:
            decoder.next_frame()
        assert (caught.value.what, caught.value.size, caught.value.limit) == ("message_bytes", 101, 100)


@pytest.mark.promise("A length is checked before memory is taken")
def test_memory_follows_the_bytes_that_arrived_not_the_announced_length() -> None:
    decoder = FrameDecoder(1_000_000_000)
    fill(decoder, struct.pack("<I", 1_000_000_000) + b"abc")
    assert decoder.next_frame() is None
    assert decoder.buffer.__sizeof__() < 1000


def test_a_service_answer_is_an_ok_byte_and_a_frame() -> None:
    answer = b"\x01" + frame(b"") + b"\x00" + frame("Fehler: ß".encode())
    for pieces in every_split(answer):
        decoder, out = FrameDecoder(100), []
        for piece in pieces:
            fill(decoder, piece)
            while True:
                item = decoder.take(1) if len(out) % 2 == 0 else decoder.next_frame()
                if item is None:
                    break
                out.append(item)
        assert out == [b"\x01", b"", b"\x00", "Fehler: ß".encode()]


def test_a_frame_beyond_4_gib_is_our_error() -> None:
    class Huge(bytes):
        def __len__(self) -> int:
            return 1 << 32

    with pytest.raises(LocalProtocolError):
        frame(Huge())


def test_a_long_frame_is_received_into_memory_of_its_own() -> None:
    """In steps, between short ones."""
    long = bytes(range(256)) * 3000
    stream = frame(b"a") + frame(long) + frame(b"b")
    for step in (1000, 200_000, len(stream)):
        decoder, found = FrameDecoder(1 << 20, step=4096), []
        for position in range(0, len(stream), step):
            found += feed(decoder, stream[position : position + step])
        assert found == [b"a", long, b"b"]
        assert decoder.count == 3
    half = FrameDecoder(1 << 20)
    fill(half, frame(long)[:5000])
    half.space()
    assert half.is_large


def as_bytes(buffer: bytes, start: int, end: int) -> bytes:
    return bytes(buffer[start:end])


@pytest.mark.parametrize("owns", [False, True])
def test_frames_are_decoded_where_they_lie(owns: bool) -> None:
    """In portions; of a burst only the newest when no more are of use; long ones in their own memory."""
    bodies = [bytes([n]) for n in range(100)]
    decoder = FrameDecoder(1 << 20)
    fill(decoder, b"".join(map(frame, bodies)) + b"\x09")
    assert decoder.decoded(as_bytes, owns) == bodies[:BATCH]
    assert decoder.decoded(as_bytes, owns, newest=3) == bodies[-3:]
    assert (decoder.count, decoder.passed_over) == (100, 100 - BATCH - 3)
    assert decoder.decoded(as_bytes, owns) == decoder.decoded(as_bytes, owns, newest=3) == []
    fill(decoder, b"\0\0\0" + bytes(8))
    assert decoder.decoded(as_bytes, owns, newest=1) == []  # a byte is missing
    fill(decoder, b"!" + frame(bytes(LARGE + 1)))
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
        fill(decoder, frame(bytes(LARGE + 1)))
        assert decoder.next_frame() == bytes(LARGE + 1)


def test_a_buffer_that_a_read_filled_grows() -> None:
    """More would have come: the next read shall bring it. There is a bound to that."""
    decoder = FrameDecoder(100, room=8)
    fill(decoder, frame(b"abcd"))
    assert decoder.next_frame() == b"abcd"
    assert len(decoder.space()) > 8
    largest = FrameDecoder(MAX_ROOM, room=MAX_ROOM)
    fill(largest, frame(bytes(MAX_ROOM - 4)))
    assert largest.next_frame() == bytes(MAX_ROOM - 4)
    assert len(largest.space()) == MAX_ROOM


def test_a_length_that_is_refused_takes_no_room() -> None:
    """Asking for the frame, or for space to receive into, refuses it."""
    decoder = FrameDecoder(100, room=8)
    fill(decoder, struct.pack("<I", 1 << 30))
    for ask in (decoder.next_frame, decoder.space):
        with pytest.raises(TooLarge):
            ask()
    assert len(decoder.buffer) == 8
