"""Every type of msgdefs against bytes that nobody meant for it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st

from rosproto.codec import decode, decoder, encode, encode_parts, message_class
from rosproto.errors import CodecError
from rosproto.msg import bundled

COMMON = settings(deadline=None, max_examples=300)


def all_names() -> list[str]:
    library = bundled()
    names = [name for package in library.packages() for name in library.messages(package)]
    services = [name for package in library.packages() for name in library.services(package)]
    return names + [name + part for name in services for part in ("Request", "Response")]


NAMES = all_names()
FLAVOURS = st.sampled_from(["numpy", "rospy"])
# Small numbers are likely to be counts that fit.
NOISE = st.one_of(
    st.binary(max_size=300),
    st.lists(st.sampled_from([b"\0\0\0\0", b"\1\0\0\0", b"\2\0\0\0", b"ab", b"\xff"]), max_size=80).map(
        b"".join
    ),
)


def attempt(work: Callable[[], Any]) -> tuple[Any, CodecError | None]:
    """A result, or the one error that is allowed."""
    try:
        return work(), None
    except CodecError as error:
        return None, error


@COMMON
@given(st.sampled_from(NAMES), FLAVOURS, NOISE)
def test_any_bytes_give_a_message_or_a_codec_error(name: str, value_style: str, data: bytes) -> None:
    """And what gives a message can be encoded again, in whole and in parts, to something stable."""
    cls = message_class(name, value_style=value_style)
    message, error = attempt(lambda: decode(cls, data))
    if error is not None:
        assert error.type_name == name
        assert 0 <= (error.offset or 0) <= len(data)
        return
    again = encode(message)
    assert len(again) == len(data)
    assert b"".join(encode_parts(message)) == again
    assert encode(decode(cls, again)) == again


@COMMON
@given(st.sampled_from(NAMES), FLAVOURS, st.data())
def test_a_message_with_changed_bytes(name: str, value_style: str, data: Any) -> None:
    """Defaults, grown by noise: a message or a documented error; also inside a larger buffer."""
    cls = message_class(name, value_style=value_style)
    right = bytearray(encode(cls()))
    for _ in range(data.draw(st.integers(0, 3))):
        at = data.draw(st.integers(0, len(right)))
        right[at:at] = data.draw(st.sampled_from([b"\1", b"\0\0\0\0", b"\x01\0\0\0x", b"\xff\xff\xff\xff"]))
    for buffer, start in ((bytes(right), 0), (b"\1\2\3" + bytes(right) + b"\0" * 40, 3)):
        end = start + len(right)
        message, error = attempt(lambda b=buffer, i=start, e=end: decoder(cls)(b, i, e))
        if error is None:
            assert len(encode(message)) == len(right)
        else:
            assert error.type_name == name
