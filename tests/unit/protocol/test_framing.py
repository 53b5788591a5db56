"""Cutting a stream into length-prefixed frames."""

from __future__ import annotations

import struct

import pytest

from rosproto.errors import LocalProtocolError, TooLarge
from rosproto.protocol.framing import FrameDecoder, frame
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
