"""Length-prefixed frames: how TCPROS cuts its byte stream (wiki.ros.org/ROS/TCPROS).

Both the connection header and each message come as a little-endian uint32 length and that many bytes.
A service answer has one more byte in front; `FrameDecoder.take` reads it.
"""

from __future__ import annotations

from collections.abc import Iterator
from struct import Struct

from rosproto.errors import LocalProtocolError, TooLarge

__all__ = ["FrameDecoder", "frame"]

_LENGTH = Struct("<I")


def frame(payload: bytes | bytearray | memoryview) -> bytes:
    """The payload with its length in front.

    Raises:
        LocalProtocolError: The payload does not fit a uint32 length.
    """
    size = payload.nbytes if isinstance(payload, memoryview) else len(payload)
    if size > 0xFFFFFFFF:
        raise LocalProtocolError(f"a frame of {size} bytes: TCPROS lengths end at 4294967295")
    return _LENGTH.pack(size) + payload


class FrameDecoder:
    """Bytes in, whole frames out; what is left over waits for more.

    Memory grows with the bytes that arrived, never with a length that was merely announced. A length
    above `limit` is refused as soon as it is seen, and again on every later try: the stream cannot be
    brought back into step, drop the link.

    Attributes:
        limit: Most bytes of one frame's payload; change it when the header is over and messages follow.
        what: Field of `Limits` named in the error.
    """

    __slots__ = ("_buffer", "limit", "what")

    def __init__(self, limit: int, what: str = "message_bytes") -> None:
        self.limit = limit
        self.what = what
        self._buffer = bytearray()

    def receive(self, data: bytes | bytearray | memoryview) -> None:
        """Add bytes from the stream; they are copied."""
        self._buffer += data

    def frames(self) -> Iterator[bytes]:
        """Take out each frame that is complete. An empty payload is a frame too (std_msgs/Empty).

        Raises:
            TooLarge: A frame announces more than `limit`.
        """
        while (payload := self.next_frame()) is not None:
            yield payload

    def next_frame(self) -> bytes | None:
        """Take out one frame; None while it is incomplete.

        Raises:
            TooLarge: The frame announces more than `limit`.
        """
        buffer = self._buffer
        if len(buffer) < 4:
            return None
        (size,) = _LENGTH.unpack_from(buffer)
        if size > self.limit:
            raise TooLarge(self.what, size, self.limit)
        end = 4 + size
        if len(buffer) < end:
            return None
        with memoryview(buffer) as view:
            payload = bytes(view[4:end])
        del buffer[:end]  # cheap: CPython moves the start, not the bytes
        return payload

    def take(self, size: int) -> bytes | None:
        """Take out `size` bytes that are no frame (a service's ok byte); None while they are incomplete."""
        if len(self._buffer) < size:
            return None
        taken = bytes(self._buffer[:size])
        del self._buffer[:size]
        return taken

    def left_over(self) -> bytes:
        """Take out everything that no frame was made of yet."""
        taken = bytes(self._buffer)
        self._buffer.clear()
        return taken

    @property
    def buffered(self) -> int:
        """Bytes waiting."""
        return len(self._buffer)

    @property
    def missing(self) -> int:
        """Bytes that must still arrive before a frame can be complete; 0 when one is."""
        have = len(self._buffer)
        if have < 4:
            return 4 - have
        return max(0, 4 + int(_LENGTH.unpack_from(self._buffer)[0]) - have)
