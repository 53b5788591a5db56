"""Fields of a topic's messages as numpy columns."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from operator import attrgetter
from typing import TYPE_CHECKING, Any, NamedTuple

from rosproto.bag.reader import BagReader
from rosproto.bag.records import Connection
from rosproto.codec import Message
from rosproto.codec.layout import DTYPES
from rosproto.errors import BagError
from rosproto.time import TVal

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


def to_numpy(
    bag: BagReader,
    topic: str,
    connections: Iterable[Connection],
    fields: Iterable[str],
    step: Callable[[int], None] = lambda _: None,
) -> dict[str, NDArray[Any]]:
    """Read fields of all messages of a topic into arrays.

    Args:
        bag: The bag.
        topic: A topic of the bag.
        connections: The connections of that topic.
        fields: Paths such as "pose.pose.position.x".
        step: Called with the number of messages processed since the last call.

    Returns:
        "receive_time" (seconds since 1970, (N,) float64), and one array for each field: (N,) in the field's
        own type, times and durations as float64 seconds, arrays of one length as (N, length), arrays of
        varying length as (N,) object. If the message has a field `receive_time` itself, the receive time is
        called `_receive_time`.

    Raises:
        BagError: No such field; the error text lists the fields.
    """
    import numpy as np

    paths = list(fields)
    connections = list(connections)
    for connection in connections:
        for path in paths:
            _check_path(bag.message_class(connection)(), path, topic)
    columns = _cut_out(bag, topic, paths, step) if len(connections) == 1 else None
    times, values = columns or _decoded(bag, topic, paths, step)
    # A field name never begins with `_`, so this one is free when the message has a `receive_time`.
    name = "_receive_time" if "receive_time" in paths else "receive_time"
    arrays: dict[str, NDArray[Any]] = {name: np.array(times, np.float64)}
    return arrays | dict(zip(paths, values, strict=True))


def _cut_out(
    bag: BagReader, topic: str, paths: list[str], step: Callable[[int], None] = lambda _: None
) -> tuple[NDArray[np.float64], list[NDArray[np.generic]]] | None:
    """Times and columns, decoding only the first message; None unless all messages share its layout."""
    import numpy as np

    first = next(bag.read_messages(topic), None)
    if first is None:  # every chunk is damaged, and damage is skipped
        return None
    places = FieldOffsets(first[1])
    if not places.has(paths):
        return None
    times: list[NDArray[np.float64]] = []
    pieces: list[list[NDArray[np.generic]]] = []
    for batch in bag.batches(topic):
        rows = batch.rows
        found = None  # of chunks that overlap in time
        if batch.chunk is not None:
            found = places.take(batch.chunk.blob, rows.start, rows.end, paths)
        if found is None:
            step(-sum(map(len, times)))  # taken back: `_decoded` reads them all again
            return None
        times.append(rows.secs + rows.nsecs / 1e9)
        pieces.append(found)
        step(len(rows.conn))
    return np.concatenate(times), [np.concatenate(column) for column in zip(*pieces, strict=True)]


def _decoded(
    bag: BagReader, topic: str, paths: list[str], step: Callable[[int], None]
) -> tuple[list[float], list[NDArray[np.generic]]]:
    """Times and columns of messages of any layout; decodes every message."""
    getters = [attrgetter(path) for path in paths]
    columns: list[list[Any]] = [[] for _ in paths]
    times: list[float] = []
    example: Message | None = None
    for _, message, stamp in bag.read_messages(topic):
        example = message
        times.append(stamp.to_sec())
        for column, get in zip(columns, getters, strict=True):
            column.append(get(message))
        step(1)
    types = [None if example is None else dtype_of(example, path) for path in paths]
    return times, [_as_array(column, kind) for column, kind in zip(columns, types, strict=True)]


def _check_path(message: object, path: str, topic: str) -> None:
    """Follow a path in an empty message, so that a wrong one is reported before anything is read."""
    at = message
    for name in path.split("."):
        slots = getattr(at, "__slots__", ())
        if name not in slots:
            where = getattr(at, "_type", type(at).__name__)
            raise BagError(f"{topic}: no field {path!r}: {where} has {', '.join(slots) or 'no fields'}")
        at = getattr(at, name)


def _as_array(values: list[Any], dtype: str | None) -> NDArray[np.generic]:
    import numpy as np

    if values and isinstance(values[0], TVal):
        return np.array([value.to_sec() for value in values], np.float64)
    if values and isinstance(values[0], (str, int, float, bool)):
        return np.array(values, dtype)
    lengths = {len(value) if hasattr(value, "__len__") else -1 for value in values}
    if len(lengths) == 1 and -1 not in lengths and all(isinstance(value, np.ndarray) for value in values):
        return np.stack(values)
    column = np.empty(len(values), object)
    column[:] = values
    return column


# -- fields at fixed offsets --------------------------------------------------------------------------------
# Offsets of fields in serialized messages of equal layout; columns are extracted without decoding.
#
# Messages of one topic usually differ only in their numbers: strings in headers and array lengths are
# equal. The first message gives the offset of each field and the lengths that determine it. Every message
# of the same size, with the same lengths at the same offsets, has the same layout.


_TIMES = {"time": "<u4", "duration": "<i4"}
_SIZES = {"?": 1, "i1": 1, "u1": 1} | {"<" + kind + size: int(size) for kind in "iuf" for size in "248"}
MAX_ELEMENTS = 16  # the longest array of messages whose elements are looked at


class _FieldOffset(NamedTuple):
    """A field: its first byte, number type, length (None for a single value), and whether it is a time."""

    offset: int
    dtype: str
    length: int | None
    is_time: bool = False


class _NoFixedOffsets(Exception):
    """The message has a field without a fixed offset."""


class FieldOffsets:
    """Field offsets of one message; `take` extracts columns from messages with the same layout.

    Args:
        message: The message, decoded.
    """

    def __init__(self, message: Message) -> None:
        self._places: dict[str, _FieldOffset] = {}
        self._lengths: list[tuple[int, int]] = []
        try:
            self.size = self._walk(message, "", 0)
        except _NoFixedOffsets:
            self.size = -1

    def has(self, paths: list[str]) -> bool:
        """Whether all these fields have fixed offsets."""
        return self.size >= 0 and all(path in self._places for path in paths)

    def take(
        self, blob: bytes, start: NDArray[np.int64], end: NDArray[np.int64], paths: list[str]
    ) -> list[NDArray[np.generic]] | None:
        """Columns of the messages at these locations; None if any has another layout."""
        if not (end - start == self.size).all():
            return None
        for offset, length in self._lengths:
            if not (_gather(blob, start + offset, "<u4", 1)[:, 0] == length).all():
                return None
        return [self._column(blob, start, self._places[path]) for path in paths]

    def _column(self, blob: bytes, start: NDArray[np.int64], place: _FieldOffset) -> NDArray[np.generic]:
        import numpy as np

        count = 2 if place.is_time else 1 if place.length is None else place.length
        if not count:
            return np.zeros((len(start), 0), place.dtype)
        values = _gather(blob, start + place.offset, place.dtype, count)
        if place.is_time:
            seconds: NDArray[np.generic] = values[:, 0] + values[:, 1] / 1e9
            return seconds
        column: NDArray[np.generic] = values[:, 0] if place.length is None else values
        return column

    def _walk(self, message: Message, prefix: str, at: int) -> int:
        """Record the field offsets of the message at `at`; return the offset of its end."""
        for field in message._spec.fields:
            path, kind = prefix + field.name, field.type
            value = getattr(message, field.name)
            if kind.is_array and kind.array_length is None:
                self._lengths.append((at, len(value)))
                at += 4
            if kind.base in DTYPES:
                count = len(value) if kind.is_array else None
                self._places[path] = _FieldOffset(at, DTYPES[kind.base], count)
                at += _SIZES[DTYPES[kind.base]] * (1 if count is None else count)
            elif kind.is_array:
                at = self._walk_elements(value, kind.base, at)
            elif kind.base in _TIMES:
                self._places[path] = _FieldOffset(at, _TIMES[kind.base], None, True)
                at += 8
            elif kind.base == "string":
                at = self._walk_text(value, at)
            else:
                at = self._walk(value, path + ".", at)
        return at

    def _walk_elements(self, values: Any, base: str, at: int) -> int:
        if len(values) > MAX_ELEMENTS:
            raise _NoFixedOffsets
        for value in values:
            if base == "string":
                at = self._walk_text(value, at)
            elif base in _TIMES:
                at += 8
            else:
                at = self._walk(value, "\0", at)  # elements have no path
        return at

    def _walk_text(self, value: str | bytes, at: int) -> int:
        data = value.encode("utf-8", "surrogateescape") if isinstance(value, str) else value
        self._lengths.append((at, len(data)))
        return at + 4 + len(data)


def dtype_of(message: Message, path: str) -> str | None:
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
