"""A topic as a stream of Arrow record batches: memory is bounded for any bag."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import TYPE_CHECKING

from rosproto.bag.arrow.columns import Columns, DefinitionMismatch, from_numpy, offsets_of
from rosproto.bag.arrow.schema import WantedFields, layout_of, pyarrow, schema_of, time_name, wanted_fields
from rosproto.bag.inputs import Stamp, to_ns
from rosproto.bag.message_offsets import MessageLocation
from rosproto.bag.reader import BagReader
from rosproto.bag.records import NS
from rosproto.codec import Message
from rosproto.codec.layout import Layout
from rosproto.errors import BagError

if TYPE_CHECKING:
    from pyarrow import Array, RecordBatch, RecordBatchReader

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
        self._size = 0

    def add(self, blob: bytes, places: Iterable[MessageLocation]) -> Iterator[RecordBatch]:
        """Add messages of a chunk; yields a pyarrow.RecordBatch whenever one is full.

        Args:
            blob: Bytes that contain them.
            places: Their locations.

        Raises:
            CodecError: A message does not fit its definition.
        """
        parts, times, size = self._parts, self._times, self._size
        for _, secs, nsecs, start, end in places:
            parts.append(blob[start:end])
            times.append(secs * NS + nsecs)
            size += end - start
            if size >= BATCH_BYTES or len(times) >= BATCH_ROWS:
                yield self.rest()
                parts, times, size = self._parts, self._times, self._size
        self._size = size

    def rest(self) -> RecordBatch | None:
        """A batch of the remaining messages; None if there are none.

        Raises:
            CodecError: See `add`.
        """
        import numpy as np

        parts, times = self._parts, self._times
        if not times:
            return None
        self._parts, self._times, self._size = [], [], 0
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
) -> RecordBatchReader:
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
) -> Iterator[RecordBatch]:
    for _, batch in batches_of(bag, [made], start_time, end_time):
        yield batch


def batches_of(
    bag: BagReader,
    tables: Sequence[TopicBatches],
    start_time: Stamp | None = None,
    end_time: Stamp | None = None,
    *,
    step: Callable[[int], object] | None = None,
) -> Iterator[tuple[int, RecordBatch]]:
    """Batches of several topics in one pass over the bag: the number of the table, and the batch.

    `step` is called after each chunk, with the number of its messages.

    Raises:
        BagError: See `BagReader.read_messages`.
        CodecError: See `TopicBatches.add`.
    """
    low = None if start_time is None else to_ns(start_time)
    high = None if end_time is None else to_ns(end_time)
    number_of = {conn: number for number, table in enumerate(tables) for conn in table.connections}
    for run in bag.runs(set(number_of), low, high):
        found: dict[int, list[MessageLocation]] = {}
        for place in run.places:
            found.setdefault(number_of[place[0]], []).append(place)
        for number, places in found.items():
            for batch in tables[number].add(run.blob, places):
                yield number, batch
        if step is not None:
            step(len(run.places))
    for number, table in enumerate(tables):
        batch = table.rest()
        if batch is not None:
            yield number, batch


def _arrays(parts: list[bytes], layout: Layout, want: WantedFields) -> dict[str, Array | None]:
    """The wanted fields' arrays; DefinitionMismatch if a message does not fit its definition."""
    import numpy as np

    edges = offsets_of(np.array([len(part) for part in parts], np.int64))
    return Columns(b"".join(parts), edges[:-1], edges[1:]).take(layout, want)


def _misfit(cls: type[Message], parts: list[bytes], topic: str) -> Exception:
    """The codec's error about the message that does not fit its definition."""
    from rosproto.codec import decode
    from rosproto.errors import CodecError

    for part in parts:
        try:
            decode(cls, part)
        except CodecError as problem:
            return problem
    return BagError(f"{topic}: a message of {cls._type} does not match its definition")
