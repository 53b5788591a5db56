"""Encoded messages on their way out."""

from __future__ import annotations

import numpy as np

from rosproto.node.outgoing.frames import LargeFrame, small_frame


def test_header_seq_is_written_into_the_bytes_only() -> None:
    """The first four bytes of the body are replaced, the rest stays."""
    body = b"\xff\xff\xff\xffrest"
    assert small_frame(body) == b"\x08\0\0\0" + body
    assert small_frame(body, 7) == b"\x08\0\0\0\x07\0\0\0rest"
    assert LargeFrame([body, b"more"], 7).owned() == b"\x0c\0\0\0\x07\0\0\0restmore"


def test_what_the_socket_did_not_take_is_copied_when_it_can_change() -> None:
    """A caller's array is copied, immutable bytes are not."""
    array = np.arange(100, dtype="u1")
    rest = LargeFrame([b"head", memoryview(array)]).rest(10)
    array[:] = 0
    assert b"".join(rest) == bytes(range(2, 100))
    data = bytes(100)
    (view,) = LargeFrame([data]).rest(4)
    assert view.obj is data


def test_a_read_only_view_of_a_writable_array_is_copied_too() -> None:
    """Read-only is not the same as immutable."""
    array = np.zeros(50, "u1")
    view = array[:]
    view.flags.writeable = False
    rest = LargeFrame([memoryview(view)]).rest(4)
    array[:] = 9
    assert not any(b"".join(rest))


def test_rest_of_every_length() -> None:
    """`rest(n)` is the frame without its first n bytes."""
    frame = LargeFrame([b"abc", b"", b"defg"])
    whole = b"\x07\0\0\0abcdefg"
    assert frame.size == len(whole)
    for sent in range(1, len(whole)):
        assert b"".join(frame.rest(sent)) == whole[sent:]
