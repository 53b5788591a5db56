"""A topic as a stream of Arrow record batches: memory is bounded for any bag."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any

from rosproto.bag.arrow.columns import Columns, Misfit
from rosproto.bag.arrow.library import pyarrow
from rosproto.bag.arrow.schema import layout_of, schema_of, time_name, wanted_fields
from rosproto.errors import BagError

if TYPE_CHECKING:
    from rosproto.bag.reader import BagReader
    from rosproto.bag.records import Connection
    from rosproto.bag.stamps import Stamp
    from rosproto.codec import Message
    from rosproto.codec.layout import Layout

__all__ = ["BATCH_BYTES", "BATCH_ROWS", "to_arrow"]

BATCH_BYTES = 4 << 20
BATCH_ROWS = 1 << 16
"""A batch ends at whichever comes first; a single message may be larger."""


def to_arrow(
    bag: BagReader,
    topic: str,
    connections: Iterable[Connection],
    fields: Iterable[str] | None = None,
    start_time: Stamp | None = None,
    end_time: Stamp | None = None,
) -> Any:
    """A topic's messages as a pyarrow.RecordBatchReader, which reads the bag as batches are read.

    Args:
        bag: The bag; keep it open as long as batches are read.
        topic: One of its topics.
        connections: The topic's connections.
        fields: See `schema_of`.
        start_time: Not earlier than this.
        end_time: Not later than this.

    Raises:
        BagError: No such field; the topic's messages have several definitions; pyarrow is missing.
    """
    pa = pyarrow()
    connections = list(connections)
    first = connections[0]
    others = {c.md5sum for c in connections} - {first.md5sum}
    if others:
        raise BagError(
            f"{topic}: its messages have {len(others) + 1} definitions (md5sums "
            f"{', '.join(sorted({first.md5sum, *others}))}), a table has one; "
            "cut them apart with `bag filter`"
        )
    cls = bag.message_class(first)
    paths = None if fields is None else list(dict.fromkeys(fields))
    schema = schema_of(cls, first, paths)
    batches = _batches(bag, topic, cls, paths, schema, start_time, end_time)
    return pa.RecordBatchReader.from_batches(schema, batches)


def _batches(
    bag: BagReader,
    topic: str,
    cls: type[Message],
    paths: list[str] | None,
    schema: Any,
    start_time: Stamp | None,
    end_time: Stamp | None,
) -> Iterator[Any]:
    layout = layout_of(cls)
    want = wanted_fields(layout, paths, topic)
    names = [name for name in schema.names if name != time_name(schema.names[1:])]
    parts: list[bytes] = []
    times: list[int] = []
    size = 0
    for _, raw, stamp in bag.read_messages(topic, start_time, end_time, raw=True):
        parts.append(raw.data)
        times.append(stamp.secs * 1_000_000_000 + stamp.nsecs)
        size += len(raw.data)
        if size >= BATCH_BYTES or len(times) >= BATCH_ROWS:
            yield _batch(cls, layout, want, names, schema, times, parts, topic)
            parts, times, size = [], [], 0
    if times:
        yield _batch(cls, layout, want, names, schema, times, parts, topic)


def _batch(
    cls: type[Message],
    layout: Layout,
    want: Any,
    names: list[str],
    schema: Any,
    times: list[int],
    parts: list[bytes],
    topic: str,
) -> Any:
    import numpy as np

    pa = pyarrow()
    ends = np.cumsum([len(part) for part in parts], dtype=np.int64)
    starts = np.concatenate([np.zeros(1, np.int64), ends[:-1]])
    try:
        arrays = Columns(b"".join(parts), starts, ends).take(layout, want)
    except Misfit:
        raise _misfit(cls, parts, topic) from None
    stamps = pa.array(np.array(times, np.int64)).view(schema.field(0).type)
    return pa.record_batch([stamps, *(arrays[name] for name in names)], schema=schema)


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
