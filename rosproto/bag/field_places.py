"""Where fields lie in serialized messages of equal layout, so that columns are cut out without decoding.

The messages of one topic mostly differ only in their numbers: the strings in their headers are the same, and
so are the lengths of their arrays. The first message shows where each field is and which lengths put it
there; every message of the same size with the same lengths in the same places has its fields there, too.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

from rosproto.codec.layout import DTYPES

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from rosproto.codec import Message

__all__ = ["FieldPlaces", "dtype_of"]

_TIMES = {"time": "<u4", "duration": "<i4"}
_SIZES = {"?": 1, "i1": 1, "u1": 1} | {"<" + kind + size: int(size) for kind in "iuf" for size in "248"}
MOST_ELEMENTS = 16  # the longest array of messages whose elements are looked at


class _Place(NamedTuple):
    """A field: its first byte, number type, length (None for a single value), and whether it is a time."""

    offset: int
    dtype: str
    length: int | None
    is_time: bool = False


class _Irregular(Exception):
    """The message has a field that cannot be located this way."""


class FieldPlaces:
    """The field places of one message; `take` cuts columns out of the messages that share them.

    Args:
        message: The message, decoded.
    """

    def __init__(self, message: Message) -> None:
        self._places: dict[str, _Place] = {}
        self._lengths: list[tuple[int, int]] = []
        try:
            self.size = self._walk(message, "", 0)
        except _Irregular:
            self.size = -1

    def has(self, paths: list[str]) -> bool:
        """Whether all these fields can be cut out."""
        return self.size >= 0 and all(path in self._places for path in paths)

    def take(
        self, blob: bytes, start: NDArray[np.int64], end: NDArray[np.int64], paths: list[str]
    ) -> list[NDArray[Any]] | None:
        """Columns of the messages at these places; None when one is built differently."""
        if not (end - start == self.size).all():
            return None
        for offset, length in self._lengths:
            if not (_gather(blob, start + offset, "<u4", 1)[:, 0] == length).all():
                return None
        return [self._column(blob, start, self._places[path]) for path in paths]

    def _column(self, blob: bytes, start: NDArray[np.int64], place: _Place) -> NDArray[Any]:
        import numpy as np

        count = 2 if place.is_time else 1 if place.length is None else place.length
        if not count:
            return np.zeros((len(start), 0), place.dtype)
        values = _gather(blob, start + place.offset, place.dtype, count)
        if place.is_time:
            seconds: NDArray[Any] = values[:, 0] + values[:, 1] / 1e9
            return seconds
        column: NDArray[Any] = values[:, 0] if place.length is None else values
        return column

    def _walk(self, message: Any, prefix: str, at: int) -> int:
        """Note the fields of a message that begins there; returns where it ends."""
        for field in message._spec.fields:
            path, kind = prefix + field.name, field.type
            value = getattr(message, field.name)
            if kind.is_array and kind.array_length is None:
                self._lengths.append((at, len(value)))
                at += 4
            if kind.base in DTYPES:
                count = len(value) if kind.is_array else None
                self._places[path] = _Place(at, DTYPES[kind.base], count)
                at += _SIZES[DTYPES[kind.base]] * (1 if count is None else count)
            elif kind.is_array:
                at = self._walk_elements(value, kind.base, at)
            elif kind.base in _TIMES:
                self._places[path] = _Place(at, _TIMES[kind.base], None, True)
                at += 8
            elif kind.base == "string":
                at = self._walk_text(value, at)
            else:
                at = self._walk(value, path + ".", at)
        return at

    def _walk_elements(self, values: Any, base: str, at: int) -> int:
        if len(values) > MOST_ELEMENTS:
            raise _Irregular
        for value in values:
            if base == "string":
                at = self._walk_text(value, at)
            elif base in _TIMES:
                at += 8
            else:
                at = self._walk(value, "\0", at)  # elements have no path of their own
        return at

    def _walk_text(self, value: str | bytes, at: int) -> int:
        data = value.encode("utf-8", "surrogateescape") if isinstance(value, str) else value
        self._lengths.append((at, len(data)))
        return at + 4 + len(data)


def dtype_of(message: Any, path: str) -> str | None:
    """numpy's name for the type of a single number or array of numbers; None for anything else."""
    *way, last = path.split(".")
    for name in way:
        message = getattr(message, name)
    kind = {field.name: field.type for field in message._spec.fields}[last]
    return DTYPES.get(kind.base)


def _gather(blob: bytes, at: NDArray[np.int64], dtype: str, count: int) -> NDArray[Any]:
    """(N, count) values of a type, from any positions in the blob, aligned or not."""
    import numpy as np

    size = _SIZES[dtype] * count
    windows = np.ndarray((len(blob) - size + 1,), f"V{size}", blob, 0, (1,))
    values: NDArray[Any] = windows[at].view(dtype).reshape(len(at), count)
    return values
