"""Feed a decoder of frames as a socket does."""

from __future__ import annotations

from collections.abc import Iterator

from rosproto.protocol.framing import FrameDecoder


def fill(decoder: FrameDecoder, data: bytes | memoryview) -> None:
    """Receive bytes without taking frames; a long frame must be the last one."""
    rest = memoryview(data)
    while rest:
        space = decoder.space()
        count = min(len(space), len(rest))
        space[:count] = rest[:count]
        decoder.received(count)
        rest = rest[count:]


def feed(decoder: FrameDecoder, data: bytes | memoryview) -> Iterator[bytes]:
    """Receive bytes; yield the frames that they complete."""
    rest = memoryview(data)
    while rest:
        count = min(len(decoder.space()), len(rest))
        fill(decoder, rest[:count])
        rest = rest[count:]
        yield from iter(decoder.next_frame, None)
