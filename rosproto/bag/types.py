"""The message class of a recorded connection, chosen by its md5sum and its stored definition."""

from __future__ import annotations

from collections.abc import Callable

from rosproto.bag.records import Connection
from rosproto.codec import Message, decoder, define, message_class
from rosproto.errors import BagError, DefinitionError
from rosproto.msg import bundled

__all__ = ["Decode", "decode_function", "message_class_of"]

Decode = Callable[[bytes, int, int], Message]


def message_class_of(connection: Connection) -> type[Message]:
    """The class for a connection's messages.

    The md5sum decides what the bytes are. When a bundled definition (or a bundled older revision) has it,
    that class is taken: it is the same definition, and `isinstance` works with what a program imported.
    Otherwise the text stored in the bag is used, as rosbag does even when its md5sum is another one.

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
    raise BagError(
        f"{connection.topic}: the bag has no usable definition of {connection.type} "
        f"(md5sum {connection.md5sum}), and none is bundled; read it with raw=True"
    ) from problem


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

    Arrays are views of the bytes they were decoded from. A message that is a large part of its chunk keeps
    the chunk alive; a small one is copied first, or a single message that is kept would hold a whole chunk in
    memory.
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
