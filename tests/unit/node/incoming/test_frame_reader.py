"""Messages cut out of a stream, however it arrives."""

from __future__ import annotations

import socket
import struct
import sys
import threading
from collections.abc import Iterator
from typing import Any

import pytest

from rosproto.errors import ConnectionLost, TooLarge
from rosproto.node.incoming.tcpros_link import FIRST_BUFFER, FrameReader
from rosproto.protocol.framing import BATCH, LARGE
from rosproto.protocol.framing import MAX_ROOM as BUFFER
from tests.support.memory import peak_of


class Pieces:
    """A socket that delivers a stream in given pieces."""

    def __init__(self, pieces: Iterator[bytes] | list[bytes]) -> None:
        self._pieces = iter(pieces)
        self._rest = b""
        self.room = 0  # the largest that was offered

    def recv_into(self, view: memoryview, size: int = 0, flags: int = 0) -> int:
        self.room = max(self.room, len(view))
        data = self._rest or next(self._pieces, b"")
        count = min(len(view), len(data))
        view[:count] = data[:count]
        self._rest = data[count:]
        return count


def frames(*bodies: bytes) -> bytes:
    return b"".join(struct.pack("<I", len(body)) + body for body in bodies)


def as_bytes(buffer: Any, start: int, end: int) -> bytes:
    return bytes(buffer[start:end])


def read_all(
    sock: Any, *, owns: bool = False, newest: int | None = None, limit: int = 1 << 30
) -> list[bytes]:
    reader = FrameReader(sock, limit, peer="test")
    out: list[bytes] = []
    while True:
        try:
            out += reader.receive(as_bytes, owns=owns, newest=newest)
        except ConnectionLost:
            return out


@pytest.mark.parametrize("owns", [False, True])
def test_messages_that_come_alone_are_decoded_at_once(owns: bool) -> None:
    """Where they lie in the buffer, or each in bytes of its own."""
    buffers = []

    def decode(buffer: Any, start: int, end: int) -> bytes:
        buffers.append(buffer)
        return as_bytes(buffer, start, end)

    pieces = [frames(b"one"), frames(b""), frames(b"two"), frames(b"three", b"four"), b"\x04"]
    reader = FrameReader(Pieces(pieces), 100, peer="test")  # type: ignore[arg-type]
    assert [reader.receive(decode, owns) for _ in range(3)] == [[b"one"], [b""], [b"two"]]
    assert len({id(buffer) for buffer in buffers}) == (3 if owns else 1)
    assert reader.receive(decode, owns) == [b"three", b"four"]
    with pytest.raises(ConnectionLost, match=r"inside a message \(1 bytes"):
        reader.receive(decode, owns)
    assert (reader.messages, reader.bytes) == (5, sum(map(len, pieces)))


def test_a_message_alone_may_fill_the_buffer_or_be_too_long() -> None:
    pieces = [frames(bytes(FIRST_BUFFER - 4)), frames(bytes(101))[:20]]
    reader = FrameReader(Pieces(pieces), 100, peer="test")  # type: ignore[arg-type]
    assert reader.receive(as_bytes, owns=False) == [bytes(FIRST_BUFFER - 4)]
    with pytest.raises(TooLarge):
        reader.receive(as_bytes, owns=False)


BODIES = [b"", b"a", b"bc" * 10, b"", bytes(5000), b"end"]


@pytest.mark.parametrize("owns", [False, True])
@pytest.mark.parametrize("step", [1, 2, 3, 5, 7, 1000, 1 << 20])
def test_any_split_gives_the_same_messages(owns: bool, step: int) -> None:
    """Whole, byte by byte, cut anywhere; empty messages are messages."""
    stream = frames(*BODIES)
    pieces = [stream[i : i + step] for i in range(0, len(stream), step)]
    assert read_all(Pieces(pieces), owns=owns) == BODIES


@pytest.mark.parametrize("numpy_loaded", [True, False])
def test_large_messages_get_their_own_memory(numpy_loaded: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """Around the bound, and larger than the buffer, between small ones; from numpy only where it is there."""
    if numpy_loaded:
        pytest.importorskip("numpy")
    else:
        monkeypatch.delitem(sys.modules, "numpy", raising=False)
    bodies = [b"s", bytes(LARGE), b"t", bytes([1]) * (LARGE + 1), b"u", bytes([2]) * (3 * BUFFER), b"v"]
    stream = frames(*bodies)
    for step in (4096, 100_000, len(stream)):
        pieces = [stream[i : i + step] for i in range(0, len(stream), step)]
        assert read_all(Pieces(pieces)) == bodies


def test_many_small_messages_come_in_portions() -> None:
    """A full buffer is handed on in portions, all of it."""
    bodies = [struct.pack("<I", n) for n in range(1000)]
    reader = FrameReader(Pieces([frames(*bodies)]), 100, peer="test")  # type: ignore[arg-type]
    out: list[bytes] = []
    while len(out) < 1000:
        batch = reader.receive(as_bytes, owns=False)
        assert len(batch) <= BATCH
        out += batch
    assert out == bodies
    assert reader.messages == 1000
    assert reader.bytes == 8000


@pytest.mark.parametrize("size", [60, 48, 5000, LARGE - 4, LARGE])
def test_the_buffer_grows_with_what_reads_bring(size: int) -> None:
    """A quiet topic costs 4 KiB, a stream gets what is worth a system call; 64 with the length fill it exactly."""
    body = bytes(range(256)) * (size // 256) + bytes(size % 256)
    count = 3000 if size < 1000 else 300 if size < 10_000 else 20
    sock: Any = Pieces([frames(b"first"), frames(*[body] * count)])
    reader = FrameReader(sock, 1 << 30, peer="test")
    assert reader.receive(as_bytes, owns=False) == [b"first"]
    assert sock.room == FIRST_BUFFER
    while reader.messages < 1 + count:
        assert set(reader.receive(as_bytes, owns=False)) == {body}
    with pytest.raises(ConnectionLost):
        reader.receive(as_bytes, owns=False)
    assert sock.room == BUFFER


def test_only_the_newest_are_decoded() -> None:
    """With a queue of two, eight of ten messages are passed over and counted."""
    bodies = [bytes([n]) for n in range(10)]
    reader = FrameReader(Pieces([frames(*bodies)]), 100, peer="test")  # type: ignore[arg-type]
    assert reader.receive(as_bytes, owns=False, newest=2) == bodies[-2:]
    assert reader.skipped == 8
    assert reader.messages == 10


@pytest.mark.promise("A length is checked before memory is taken")
def test_a_length_above_the_limit_is_refused_before_memory_is_taken() -> None:
    """4 GiB announced: an error at once."""
    reader = FrameReader(Pieces([b"\xff\xff\xff\xff"]), 1000, peer="test")  # type: ignore[arg-type]
    with pytest.raises(TooLarge) as caught:
        reader.receive(as_bytes, owns=False)
    assert caught.value.what == "message_bytes"


def test_memory_follows_what_arrives() -> None:
    """900 MB announced and 1 MB sent: the end of the stream comes before the memory is taken."""

    def read() -> None:
        reader = FrameReader(Pieces([struct.pack("<I", 900_000_000), bytes(1 << 20)]), 1 << 30, peer="p")  # type: ignore[arg-type]
        with pytest.raises(ConnectionLost, match="inside a message"):
            reader.receive(as_bytes, owns=False)

    assert peak_of(read) < 40 << 20


def test_a_real_socket_with_a_message_larger_than_its_buffers() -> None:
    """30 MB through a socket pair, growing in steps."""
    left, right = socket.socketpair()
    body = bytes(range(256)) * 120_000
    sender = threading.Thread(target=lambda: (left.sendall(frames(body, b"after")), left.close()))
    sender.start()
    with right:
        assert read_all(right) == [body, b"after"]
    sender.join(20)
