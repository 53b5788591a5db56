"""encode and decode: the public functions of the codec."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from rosproto.codec.binding import Octets
from rosproto.codec.message import AnyMsg, Message

M = TypeVar("M", bound=Message)

LARGE_PART = 4096
"""Smaller arrays are copied together: a system call's overhead per part costs more."""


def encode(msg: Message) -> bytes:
    """Encode a message to its wire form (without the length that precedes it on a connection).

    Raises:
        CodecError: A value does not fit its field; names the field and the range.
        TypeError: `msg` is not a message.
    """
    try:
        return msg._encode()
    except AttributeError:
        if isinstance(msg, Message):
            raise
        raise TypeError(f"a message is expected, not {type(msg).__name__} {str(msg)[:60]!r}") from None


def decode(cls: type[M], data: bytes | bytearray | memoryview) -> M:
    """Decode a whole message.

    Arrays of numbers are read-only numpy views of `data`, which is copied first if it is not bytes. The
    result of `array.copy()` is writable and does not keep the whole message alive.

    Raises:
        CodecError: Bytes and definition disagree, bytes are missing or left over; names field and offset.
        TypeError: `data` is not a buffer of bytes.
    """
    if type(data) is not bytes:
        data = memoryview(data).tobytes()
    return cls._decode(data, 0, len(data))


def encoder(cls: type[M]) -> Callable[[M], bytes]:
    """The function behind `encode` for one class, for frequent calls."""
    if cls._binding is not None:
        cls._binding.function("encode")  # replaces cls._encode
    return cls._encode


def decoder(cls: type[M]) -> Callable[[Octets, int, int], M]:
    """The function behind `decode` for one class: (buffer, start, end) -> message, without a copy.

    If `cls._has_views`, the message refers to the buffer and keeps it alive: pass bytes, or a bytearray,
    memoryview or uint8 array that does not change any more. Otherwise the message is independent of the
    buffer, which may be reused (bytes and bytearray are fastest).
    """
    if cls._binding is not None:
        cls._binding.function("decode")  # replaces cls._decode
    return cls._decode


def prepare(cls: type[Message], *, parts: bool = False) -> None:
    """Generate the functions that make and encode messages of a class before first use (1 to 3 ms).

    Args:
        cls: The class. Classes without generated functions (`AnyMsg`) need nothing.
        parts: For `encode_parts`, not for `encode`.
    """
    if cls._binding is not None:
        cls._binding.function("fill")
        cls._binding.function("parts" if parts else "encode")


def encode_parts(msg: Message) -> list[bytes | memoryview]:
    """Encode to a list of parts that join to `encode(msg)`; large arrays are not copied.

    The memoryviews refer to the message's own arrays. Send them before the message changes, for example with
    one `socket.sendmsg`.

    Raises:
        CodecError: A value does not fit its field; names the field and the range.
    """
    if isinstance(msg, AnyMsg) or msg._binding is None:
        return [encode(msg)]
    gathered: list[bytes | memoryview] = []
    small: list[bytes | bytearray | memoryview] = []
    part: bytes | bytearray | memoryview
    for made in msg._binding.function("parts")(msg):
        if isinstance(made, (bytes, bytearray)):
            part = made
        else:
            # Strided arrays are copied. Viewed as uint8, because memoryview.cast refuses unaligned arrays.
            contiguous = made if made.flags.c_contiguous else made.copy()
            part = contiguous.reshape(-1).view("u1").data
        if len(part) < LARGE_PART:
            small.append(part)
            continue
        if small:
            gathered.append(b"".join(small))
            small = []
        gathered.append(memoryview(part) if isinstance(part, bytearray) else part)
    if small or not gathered:
        gathered.append(b"".join(small))
    return gathered
