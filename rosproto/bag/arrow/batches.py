"""A topic as a stream of Arrow record batches: memory is bounded for any bag."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

from rosproto.bag.arrow.arrays import from_numpy
from rosproto.bag.arrow.columns import Columns, Misfit
from rosproto.bag.arrow.library import pyarrow
from rosproto.bag.arrow.schema import layout_of, schema_of, time_name, wanted_fields
from rosproto.bag.arrow.uniform import NotUniform, Uniform
from rosproto.bag.records import NS
from rosproto.bag.stamps import to_ns
from rosproto.errors import BagError

if TYPE_CHECKING:
    from rosproto.bag.arrow.schema import Want
    from rosproto.bag.reader import BagReader
    from rosproto.bag.stamps import Stamp
    from rosproto.codec import Message
    from rosproto.codec.layout import Layout

__all__ = ["BATCH_BYTES", "BATCH_ROWS", "TopicBatches", "batches_of", "to_arrow"]

BATCH_BYTES = 4 << 20
BATCH_ROWS = 1 << 16
"""A batch ends at whichever comes first; a single message may be larger."""


class TopicBatches:
    """Makes record batches of a topic's messages, which are added one by one.

    Args:
        bag: The bag they are from.
        topic: A topic of it.
        fields: See `schema_of`.

    Raises:
        BagError: No such field; the topic's messages have several definitions; pyarrow is missing.

    Attributes:
        schema: Of the batches, a pyarrow.Schema.
        connections: The numbers of the topic's connections.
        size: Bytes of the messages that wait for their batch.
    """

    def __init__(self, bag: BagReader, topic: str, fields: Iterable[str] | None = None) -> None:
        pyarrow()  # or what is missing is told by whatever needs it first
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
        """Add a message; a pyarrow.RecordBatch when there are enough for one.

        Raises:
            CodecError: One of them does not have the form of its definition.
        """
        self._parts.append(data)
        self._times.append(secs * NS + nsecs)
        self.size += len(data)
        return self.rest() if self.size >= BATCH_BYTES or len(self._times) >= BATCH_ROWS else None

    def rest(self) -> Any | None:
        """A batch of what there is; None when nothing waits.

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
        except Misfit:
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
    """A topic's messages as a pyarrow.RecordBatchReader, which reads the bag as batches are read.

    Args:
        bag: The bag; keep it open as long as batches are read.
        topic: One of its topics.
        fields: See `schema_of`.
        start_time: Not earlier than this.
        end_time: Not later than this.

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
) -> Iterator[tuple[int, Any]]:
    """Batches of several topics in one pass over the bag: which of the tables, and the batch.

    Raises:
        BagError: See `BagReader.read_messages`.
        CodecError: See `TopicBatches.add`.
    """
    low = None if start_time is None else to_ns(start_time)
    high = None if end_time is None else to_ns(end_time)
    takers = {conn: (number, table.add) for number, table in enumerate(tables) for conn in table.connections}
    for run in bag.runs(set(takers), low, high):
        blob = run.blob
        for conn, secs, nsecs, start, end in run.places:
            number, add = takers[conn]
            batch = add(secs, nsecs, blob[start:end])
            if batch is not None:
                yield number, batch
    for number, table in enumerate(tables):
        batch = table.rest()
        if batch is not None:
            yield number, batch


def _arrays(parts: list[bytes], layout: Layout, want: Want) -> dict[str, Any]:
    """The wanted fields' arrays; Misfit when a message does not have the form of its definition."""
    import numpy as np

    blob = b"".join(parts)
    sizes = {len(part) for part in parts}
    if len(sizes) == 1:
        try:
            return Uniform(blob, len(parts)).take(layout, want)
        except NotUniform:
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
