"""Messages of a run, raw or decoded, and the class of a connection, chosen by md5sum and definition."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import NamedTuple, cast

from rosproto.bag.message_offsets import MESSAGE_HEAD
from rosproto.bag.records import Connection
from rosproto.bag.time_order import ChunkMessages
from rosproto.codec import AnyMsg, Message, decoder, define, message_class
from rosproto.codec.message import MessageMeta
from rosproto.errors import BagError, DefinitionError
from rosproto.msg import bundled
from rosproto.sentence import say
from rosproto.time import Time

Decode = Callable[[bytes, int, int], Message]
ConnectionFacts = tuple[str, str, str, Connection]
"""Of a connection: topic, type, md5sum, itself."""


class RawMessage(NamedTuple):
    """A message as stored in the bag; the first four fields are those of rosbag with raw=True.

    Attributes:
        type: "package/Type".
        data: Serialized message; a read-only memoryview of the chunk with raw="view".
        md5sum: Of its definition.
        position: (byte position of the chunk in the file, of the message in the uncompressed chunk).
        connection: Its connection, with the definition; `BagWriter.write` stores it unchanged.
    """

    type: str
    data: bytes
    md5sum: str
    position: tuple[int, int]
    connection: Connection


def raw_messages(
    run: ChunkMessages, facts: Mapping[int, ConnectionFacts], view: bool
) -> Iterator[tuple[str, RawMessage, Time]]:
    """A run's messages, not decoded: topic, message, receive time; with `view` memoryviews of the chunk."""
    # The hot loop: no constructor runs.
    time_class, new, make = Time, object.__new__, tuple.__new__
    pos = run.info.pos
    blob = memoryview(run.blob) if view else run.blob
    base = run.base + MESSAGE_HEAD
    for conn, secs, nsecs, start, end in run.places:
        stamp = new(time_class)
        stamp.secs = secs
        stamp.nsecs = nsecs
        topic, kind, md5sum, connection = facts[conn]
        place = (pos, start - base)
        yield topic, make(RawMessage, (kind, blob[start:end], md5sum, place, connection)), stamp


class Decoders(dict[int, tuple[str, Decode]]):
    """Topic and decoding function by connection id; each is created on first use.

    Args:
        connections: By number.
    """

    def __init__(self, connections: Mapping[int, Connection]) -> None:
        super().__init__()
        self._connections = connections

    def __missing__(self, number: int) -> tuple[str, Decode]:
        connection = self._connections[number]
        decoder_of_connection = self[number] = connection.topic, decode_function(message_class_of(connection))
        return decoder_of_connection


def decoded_messages(run: ChunkMessages, decoders: Decoders) -> Iterator[tuple[str, Message, Time]]:
    """A run's messages: topic, message, receive time.

    Raises:
        BagError: A connection has no usable definition.
        CodecError: A message does not fit its stored definition.
    """
    # The hot loop: no constructor runs.
    time_class, new = Time, object.__new__
    blob = run.blob
    for conn, secs, nsecs, start, end in run.places:
        stamp = new(time_class)
        stamp.secs = secs
        stamp.nsecs = nsecs
        topic, decode = decoders[conn]
        yield topic, decode(blob, start, end), stamp


def message_class_of(connection: Connection) -> type[Message]:
    """The class for a connection's messages.

    If a bundled definition (or a bundled older revision) has the md5sum, its class is used, so `isinstance`
    works with imported classes. Otherwise the text stored in the bag is used; like rosbag, even if its md5sum
    differs.

    Raises:
        BagError: There is no bundled definition, and the stored text is missing or wrong.
    """
    known = _bundled(connection)
    if known is not None:
        return known
    problem: DefinitionError | None = None
    try:
        stored = define(connection.type, connection.definition)
        if connection.definition.strip() or connection.md5sum == stored._md5sum:
            return stored
    except DefinitionError as error:
        problem = error
    text = (
        "{topic}: the bag has no usable definition of {type} (md5sum {md5sum}), and none is bundled; its "
        "messages can be copied and played, not decoded: `rosproto bag filter --exclude {topic} IN OUT` "
        "writes a bag without them"
    )
    text = say(text, topic=connection.topic, type=connection.type, md5sum=connection.md5sum)
    raise BagError(text) from problem


def publishable_class_of(connection: Connection) -> type[Message]:
    """The class under which a connection's messages are published as they are: with its type and md5sum.

    It is that of `message_class_of`; if that does not exist or has another md5sum, one that is not decoded.
    """
    try:
        found = message_class_of(connection)
    except BagError:
        found = AnyMsg
    if found._md5sum == connection.md5sum:
        return found
    recorded = {"_type": connection.type, "_md5sum": connection.md5sum, "_full_text": connection.definition}
    return cast("type[Message]", MessageMeta("AnyMsg", (AnyMsg,), {"__slots__": (), **recorded}))


def _bundled(connection: Connection) -> type[Message] | None:
    library = bundled()
    try:
        if library.md5sum(connection.type) == connection.md5sum:
            return message_class(connection.type)
        for revision in library.revisions(connection.type):
            if revision.md5sum == connection.md5sum:
                return message_class(connection.type, revision.library)
    except DefinitionError:
        pass
    return None


def decode_function(cls: type[Message]) -> Decode:
    """The fast decoder for messages that lie in a chunk.

    Arrays are views of the decoded bytes. A message that is a large part of its chunk keeps the chunk in
    memory; a smaller one is copied first.
    """
    fast = decoder(cls)
    if not cls._has_views:
        return fast

    def decode(blob: bytes, start: int, end: int) -> Message:
        size = end - start
        if size * 4 >= len(blob):
            return fast(blob, start, end)
        return fast(blob[start:end], 0, size)

    return decode
