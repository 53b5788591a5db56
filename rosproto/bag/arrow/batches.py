"""A topic as a stream of Arrow record batches: memory is bounded for any bag."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from math import prod
from typing import TYPE_CHECKING, Any, NamedTuple

from rosproto.bag.arrow.columns import Columns, DefinitionMismatch, from_numpy, listed, numbers, texts
from rosproto.bag.arrow.schema import (
    WantedFields,
    is_binary,
    layout_of,
    pyarrow,
    schema_of,
    struct_type,
    time_name,
    wanted_fields,
)
from rosproto.bag.inputs import Stamp, to_ns
from rosproto.bag.reader import BagReader
from rosproto.bag.records import NS
from rosproto.codec import Message
from rosproto.codec.layout import FieldLayout, Layout
from rosproto.errors import BagError

if TYPE_CHECKING:
    from numpy.typing import NDArray


BATCH_BYTES = 4 << 20
BATCH_ROWS = 1 << 16
"""A batch ends at the first of both limits; a single message may be larger."""


class TopicBatches:
    """Makes record batches of a topic's messages, added one by one.

    Args:
        bag: The bag they are from.
        topic: A topic of it.
        fields: See `schema_of`.

    Raises:
        BagError: No such field; the topic's messages have several definitions; pyarrow is missing.

    Attributes:
        schema: Of the batches, a pyarrow.Schema.
        connections: The numbers of the topic's connections.
        size: Bytes of the messages that are not yet in a batch.
    """

    def __init__(self, bag: BagReader, topic: str, fields: Iterable[str] | None = None) -> None:
        pyarrow()  # raises the error that names the extra
        connections = bag.topics[topic].connections
        first = connections[0]
        others = {c.md5sum for c in connections} - {first.md5sum}
        if others:
            raise BagError(
                f"{topic}: its messages have {len(others) + 1} definitions (md5sums "
                f"{', '.join(sorted({first.md5sum, *others}))}), a table has one; "
                "cut them apart with `bag filter`"
            )
        self._topic = topic
        self._cls = bag.message_class(first)
        paths = None if fields is None else list(dict.fromkeys(fields))
        self.schema = schema_of(self._cls, first, paths)
        self.connections = {connection.id for connection in connections}
        self._layout = layout_of(self._cls)
        self._want = wanted_fields(self._layout, paths, topic)
        self._names = [name for name in self.schema.names if name != time_name(self.schema.names[1:])]
        self._parts: list[bytes] = []
        self._times: list[int] = []
        self.size = 0

    def add(self, secs: int, nsecs: int, data: bytes) -> Any | None:
        """Add a message; returns a pyarrow.RecordBatch when one is full.

        Raises:
            CodecError: A message does not fit its definition.
        """
        self._parts.append(data)
        self._times.append(secs * NS + nsecs)
        self.size += len(data)
        return self.rest() if self.size >= BATCH_BYTES or len(self._times) >= BATCH_ROWS else None

    def rest(self) -> Any | None:
        """A batch of the remaining messages; None if there are none.

        Raises:
            CodecError: See `add`.
        """
        import numpy as np

        parts, times = self._parts, self._times
        if not times:
            return None
        self._parts, self._times, self.size = [], [], 0
        try:
            arrays = _arrays(parts, self._layout, self._want)
        except DefinitionMismatch:
            raise _misfit(self._cls, parts, self._topic) from None
        stamps = from_numpy(np.array(times, np.int64), self.schema.field(0).type)
        return pyarrow().record_batch([stamps, *(arrays[name] for name in self._names)], schema=self.schema)


def to_arrow(
    bag: BagReader,
    topic: str,
    fields: Iterable[str] | None = None,
    start_time: Stamp | None = None,
    end_time: Stamp | None = None,
) -> Any:
    """A topic's messages as a pyarrow.RecordBatchReader, which reads the bag on demand.

    Args:
        bag: The bag; keep it open as long as batches are read.
        topic: One of its topics.
        fields: See `schema_of`.
        start_time: Earliest receive time.
        end_time: Latest receive time.

    Raises:
        BagError: See `TopicBatches`.
    """
    made = TopicBatches(bag, topic, fields)
    return pyarrow().RecordBatchReader.from_batches(made.schema, _batches(bag, made, start_time, end_time))


def _batches(
    bag: BagReader, made: TopicBatches, start_time: Stamp | None, end_time: Stamp | None
) -> Iterator[Any]:
    for _, batch in batches_of(bag, [made], start_time, end_time):
        yield batch


def batches_of(
    bag: BagReader,
    tables: Sequence[TopicBatches],
    start_time: Stamp | None = None,
    end_time: Stamp | None = None,
    *,
    step: Callable[[int], object] | None = None,
) -> Iterator[tuple[int, Any]]:
    """Batches of several topics in one pass over the bag: the number of the table, and the batch.

    `step` is called after each chunk, with the number of its messages.

    Raises:
        BagError: See `BagReader.read_messages`.
        CodecError: See `TopicBatches.add`.
    """
    low = None if start_time is None else to_ns(start_time)
    high = None if end_time is None else to_ns(end_time)
    tables_by_connection = {
        conn: (number, table.add) for number, table in enumerate(tables) for conn in table.connections
    }
    for run in bag.runs(set(tables_by_connection), low, high):
        blob = run.blob
        for conn, secs, nsecs, start, end in run.places:
            number, add = tables_by_connection[conn]
            batch = add(secs, nsecs, blob[start:end])
            if batch is not None:
                yield number, batch
        if step is not None:
            step(len(run.places))
    for number, table in enumerate(tables):
        batch = table.rest()
        if batch is not None:
            yield number, batch


def _arrays(parts: list[bytes], layout: Layout, want: WantedFields) -> dict[str, Any]:
    """The wanted fields' arrays; DefinitionMismatch if a message does not fit its definition."""
    import numpy as np

    blob = b"".join(parts)
    sizes = {len(part) for part in parts}
    if len(sizes) == 1:
        try:
            return UniformMessages(blob, len(parts)).take(layout, want)
        except MessagesDiffer:
            pass
    ends = np.cumsum([len(part) for part in parts], dtype=np.int64)
    starts = np.concatenate([np.zeros(1, np.int64), ends[:-1]])
    return Columns(blob, starts, ends).take(layout, want)


def _misfit(cls: type[Message], parts: list[bytes], topic: str) -> Exception:
    """The codec's error about the message that does not fit its definition."""
    from rosproto.codec import decode
    from rosproto.errors import CodecError

    for part in parts:
        try:
            decode(cls, part)
        except CodecError as problem:
            return problem
    return BagError(f"{topic}: a message of {cls._type} does not have the form of its definition")


# -- messages that all have one size ------------------------------------------------------------------------
# Arrays of messages with equal layout: columns of one table of bytes.
#
# Messages of a topic mostly differ in numbers only: their strings and arrays have equal lengths. Then they
# have one size, every field has one offset in all of them, and a column is a strided view of their bytes,
# copied once. This is checked field by field; if it does not hold, `MessagesDiffer` is raised and `Columns`
# handles the messages.


class MessagesDiffer(Exception):
    """The messages differ in more than numbers, or have an unsupported layout."""


class _Grid(NamedTuple):
    """Locations of repeated messages: the count and the stride in bytes of each dimension."""

    shape: tuple[int, ...]
    strides: tuple[int, ...]


class UniformMessages:
    """Arrow arrays of consecutive messages of one size.

    Args:
        blob: The messages.
        count: How many; at least one.
    """

    def __init__(self, blob: bytes, count: int) -> None:
        self._pa = pyarrow()
        self._blob = blob
        self._size = len(blob) // count
        self._grid = _Grid((count,), (self._size,))

    def take(self, layout: Layout, want: WantedFields) -> dict[str, Any]:
        """The wanted fields' arrays, by path.

        Raises:
            MessagesDiffer: The messages differ, or do not fit their definition.
        """
        if self._message(self._grid, layout, 0, take=False, single=True)[1] != self._size:
            raise MessagesDiffer
        found: dict[str, Any] = {}
        self._wanted(layout, 0, want, "", found)
        return found

    def _wanted(
        self, layout: Layout, at: int, want: WantedFields, prefix: str, found: dict[str, Any]
    ) -> None:
        for field in layout.fields:
            inside = want.get(field.name)
            path = prefix + field.name
            if inside is not None:
                if inside is True or "" in inside:
                    found[path], _ = self._field(self._grid, field, at, take=True, single=True)
                if inside is not True and any(inside):
                    assert field.layout is not None
                    self._wanted(field.layout, at, inside, path + ".", found)
            _, at = self._field(self._grid, field, at, take=False, single=True)

    def _field(
        self, grid: _Grid, field: FieldLayout, at: int, *, take: bool, single: bool
    ) -> tuple[Any, int]:
        """A field's array (None unless `take`) and the offset after it."""
        if field.is_array:
            return self._array(grid, field, at, take)
        if field.layout is not None:
            return self._message(grid, field.layout, at, take=take, single=single)
        if field.kind == "string":
            size = self._length(grid, at)
            after = self._within(at + 4, size)
            return (self._texts(grid, at + 4, size, single) if take else None), after
        after = self._within(at, field.size)
        return (numbers(field, self._cut(grid, at, field.size)) if take else None), after

    def _message(self, grid: _Grid, layout: Layout, at: int, *, take: bool, single: bool) -> tuple[Any, int]:
        if not layout.fields:
            return (self._pa.nulls(prod(grid.shape)) if take else None), at
        if not take and layout.fixed_size is not None:
            return None, self._within(at, layout.fixed_size)
        arrays: list[Any] = []
        for field in layout.fields:
            array, at = self._field(grid, field, at, take=take, single=single)
            arrays.append(array)
        if not take:
            return None, at
        kind = struct_type(layout, single=single)
        return self._pa.StructArray.from_arrays(arrays, fields=list(kind)), at

    def _array(self, grid: _Grid, field: FieldLayout, at: int, take: bool) -> tuple[Any, int]:
        import numpy as np

        if field.length is None:
            count = self._length(grid, at)
            at += 4
        else:
            count = field.length
        size = field.size if field.layout is None else field.layout.fixed_size
        if field.kind == "string" or size is None or (field.layout is not None and field.layout.is_light):
            raise MessagesDiffer
        after = self._within(at, count * size)
        if not take:
            return None, after
        if field.layout is None:
            plain = self._cut(grid, at, count * size)
            values = plain if is_binary(field) else numbers(field, plain)
        else:
            inner = _Grid((*grid.shape, count), (*grid.strides, size))
            values = self._message(inner, field.layout, at, take=True, single=False)[0]
        return listed(field, values, np.full(prod(grid.shape), count, np.int64)), after

    # -- bytes -------------------------------------------------------------------------------------------

    def _within(self, at: int, size: int) -> int:
        if at + size > self._size:
            raise MessagesDiffer
        return at + size

    def _length(self, grid: _Grid, at: int) -> int:
        """A length, which must be the same in all messages."""
        self._within(at, 4)
        lengths = self._view(grid, at, "<u4")
        if not lengths.size:
            raise MessagesDiffer
        first = int(lengths.flat[0])
        if (lengths != first).any():
            raise MessagesDiffer
        return first

    def _texts(self, grid: _Grid, at: int, size: int, coded: bool) -> Any:
        import numpy as np

        pa = self._pa
        count = prod(grid.shape)
        plain = self._cut(grid, at, size)
        table = plain.reshape(count, size) if size else None
        if coded and (table is None or (table == table[0]).all()):
            first = b"" if table is None else table[0].tobytes()
            only = texts(first, np.array([size], np.int64), coded=False)
            return pa.DictionaryArray.from_arrays(from_numpy(np.zeros(count, np.int32), pa.int32()), only)
        return texts(plain.tobytes(), np.full(count, size, np.int64), coded=coded)

    def _cut(self, grid: _Grid, at: int, size: int) -> NDArray[Any]:
        """`size` bytes of each message, in one array."""
        import numpy as np

        if not size or not prod(grid.shape):
            return np.zeros(0, np.uint8)
        kind = f"<u{size}" if size in (2, 4, 8) else f"V{size}" if size > 1 else "u1"
        plain: NDArray[Any] = self._view(grid, at, kind).copy().reshape(-1).view(np.uint8)
        return plain

    def _view(self, grid: _Grid, at: int, kind: str) -> NDArray[Any]:
        import numpy as np

        view: NDArray[Any] = np.ndarray(grid.shape, kind, self._blob, at, grid.strides)
        return view
