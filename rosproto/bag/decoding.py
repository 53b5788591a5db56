"""Decoded messages of a bag: the loop that gives them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from rosproto.bag.records import Connection
from rosproto.bag.runs import Run
from rosproto.time import Time

__all__ = ["Takers", "decoded_messages"]


class Takers(dict[int, tuple[str, Callable[[bytes, int, int], Any]]]):
    """Topic and decoding function by the number of a connection; each is made when it is asked for.

    Args:
        connections: By number.
    """

    def __init__(self, connections: Mapping[int, Connection]) -> None:
        super().__init__()
        self._connections = connections

    def __missing__(self, number: int) -> tuple[str, Callable[[bytes, int, int], Any]]:
        from rosproto.bag.types import decode_function, message_class_of

        connection = self._connections[number]
        taker = self[number] = connection.topic, decode_function(message_class_of(connection))
        return taker


def decoded_messages(run: Run, takers: Takers) -> Iterator[tuple[str, Any, Time]]:
    """A run's messages: topic, message, receive time.

    Raises:
        BagError: A connection has no usable definition.
        CodecError: A message does not fit its stored definition.
    """
    # The hot loop: no constructor runs.
    time_class, new = Time, object.__new__
    blob = run.blob
    assert blob is not None
    for conn, secs, nsecs, start, end in run.places:
        stamp = new(time_class)
        stamp.secs = secs
        stamp.nsecs = nsecs
        topic, decode = takers[conn]
        yield topic, decode(blob, start, end), stamp
