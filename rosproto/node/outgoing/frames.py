"""Encoded messages on their way out: small ones as one `bytes`, large ones in parts that are not copied.

A TCPROS message is its uint32 length and its body (wiki.ros.org/ROS/TCPROS).
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from typing import Any

from rosproto.errors import CodecError

LARGE = 32 << 10  # bytes; below this one copy costs less than a second system-call argument
prefix = struct.Struct("<I").pack
_prefix_and_seq = struct.Struct("<II").pack

Part = bytes | memoryview


def small_frame(body: bytes, seq: int | None = None) -> bytes:
    """Length and body in one `bytes`; with `seq`, the first field (header.seq) is replaced by it."""
    if seq is None:
        return prefix(len(body)) + body
    return _prefix_and_seq(len(body), seq) + body[4:]


class LargeFrame:
    """A message in parts, some of them the caller's own arrays.

    Valid until `publish()` returns; what the sockets did not take by then is kept as a copy (`owned`), which
    all links share.

    Attributes:
        views: Length, then the body, as byte views.
        size: Bytes altogether, with the length.
    """

    __slots__ = ("_owned", "size", "views")

    def __init__(self, parts: Sequence[Part], seq: int | None = None) -> None:
        views = [memoryview(part).cast("B") for part in parts]
        size = sum(view.nbytes for view in views)
        if size > 0xFFFFFFFF:
            raise CodecError(f"a message of {size} bytes: TCPROS lengths end at 4294967295")
        if seq is None:
            views.insert(0, memoryview(prefix(size)))
        else:  # a Header is encoded in one part with whatever follows it, so seq is whole in the first one
            views[:1] = [memoryview(_prefix_and_seq(size, seq)), views[0][4:]]
        self.views = [view for view in views if view.nbytes]
        self.size = size + 4
        self._owned: bytes | None = None

    def owned(self) -> bytes:
        """The whole frame in memory of its own (copied once)."""
        if self._owned is None:
            self._owned = b"".join(self.views)
        return self._owned

    def __len__(self) -> int:
        return self.size

    def frozen(self) -> LargeFrame | bytes:
        """What may be kept after `publish()` returns: this, when its memory cannot change, else a copy."""
        if self._owned is None and all(map(_is_immutable, self.views)):
            return self
        return self.owned()

    def rest(self, sent: int) -> list[memoryview]:
        """What follows the first `sent` bytes, in memory that nobody changes."""
        if self._owned is not None:
            return [memoryview(self._owned)[sent:]]
        rest = remaining(self.views, sent)
        if all(_is_immutable(view) for view in rest):
            return rest
        return [memoryview(b"".join(rest))]


def remaining(views: Sequence[memoryview], sent: int) -> list[memoryview]:
    """The views without their first `sent` bytes."""
    rest = []
    for view in views:
        if sent >= view.nbytes:
            sent -= view.nbytes
        else:
            rest.append(view[sent:])
            sent = 0
    return rest


def _is_immutable(view: memoryview) -> bool:
    """True when the memory behind is a `bytes`: a read-only array may still be somebody's writable one."""
    owner: Any = view.obj
    while owner is not None and not isinstance(owner, bytes):
        owner = owner.obj if isinstance(owner, memoryview) else getattr(owner, "base", None)
    return isinstance(owner, bytes)
