"""Messages as they lie in a bag, and the loop that gives them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from rosproto.bag.records import Connection
from rosproto.bag.rows import MESSAGE_HEAD
from rosproto.bag.runs import Run
from rosproto.time import Time

__all__ = ["Facts", "RawMessage", "raw_messages"]

Facts = tuple[str, str, str, Connection]
"""Of a connection: topic, type, md5sum, itself."""


class RawMessage(NamedTuple):
    """A message as it lies in the bag; the first four are what rosbag gives with raw=True.

    Attributes:
        type: "package/Type".
        data: Serialized message; a read-only memoryview of the chunk with raw="view".
        md5sum: Of its definition.
        position: (byte position of the chunk in the file, of the message in the uncompressed chunk).
        connection: Its connection, with the definition; `BagWriter.write` stores it as it is.
    """

    type: str
    data: bytes
    md5sum: str
    position: tuple[int, int]
    connection: Connection


def raw_messages(run: Run, facts: Mapping[int, Facts], view: bool) -> Iterator[tuple[str, RawMessage, Time]]:
    """A run's messages, not decoded: topic, message, receive time.

    Args:
        run: The run; messages read one by one are taken out of it.
        facts: By the number of a connection.
        view: Give memoryviews of the chunk.
    """
    # The hot loop: no constructor runs.
    time_class, new, make = Time, object.__new__, tuple.__new__
    pos = run.info.pos
    if run.blob is None:
        found, fetch = run.found, run.fetch
        assert found is not None
        assert fetch is not None
        found.reverse()
        while found:  # so that messages already handed out are not kept in memory
            conn, secs, nsecs, offset, size, data = found.pop()
            if data is None and (data := fetch(offset, size)) is None:
                return
            stamp = new(time_class)
            stamp.secs = secs
            stamp.nsecs = nsecs
            topic, kind, md5sum, connection = facts[conn]
            yield topic, make(RawMessage, (kind, data, md5sum, (pos, offset), connection)), stamp
        return
    blob = memoryview(run.blob) if view else run.blob
    base = run.base + MESSAGE_HEAD
    for conn, secs, nsecs, start, end in run.places:
        stamp = new(time_class)
        stamp.secs = secs
        stamp.nsecs = nsecs
        topic, kind, md5sum, connection = facts[conn]
        place = (pos, start - base)
        yield topic, make(RawMessage, (kind, blob[start:end], md5sum, place, connection)), stamp
