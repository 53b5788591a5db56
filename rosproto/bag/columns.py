"""Fields of a topic's messages as numpy columns."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from operator import attrgetter
from typing import TYPE_CHECKING, Any

from rosproto.bag.field_places import FieldPlaces, dtype_of
from rosproto.errors import BagError
from rosproto.time import TVal

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from rosproto.bag.reader import BagReader
    from rosproto.bag.records import Connection

__all__ = ["to_numpy"]


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
        topic: A topic of it.
        connections: That topic's.
        fields: Paths such as "pose.pose.position.x".
        step: Called with the number of messages that are done since the last time.

    Returns:
        "receive_time" (seconds since 1970, (N,) float64), and one array for each field: (N,) in the field's
        own type, times and durations as float64 seconds, arrays of one length as (N, length), arrays of
        varying length as (N,) object. If the message has a field `receive_time` itself, the receive time is
        called `_receive_time`.

    Raises:
        BagError: No such field; the message lists what there is.
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
) -> tuple[NDArray[np.float64], list[NDArray[Any]]] | None:
    """Times and columns, decoding only the first message; None when the messages are not all alike."""
    import numpy as np

    first = next(bag.read_messages(topic), None)
    if first is None:  # every chunk is damaged, and damage is skipped
        return None
    places = FieldPlaces(first[1])
    if not places.has(paths):
        return None
    times: list[NDArray[np.float64]] = []
    pieces: list[list[NDArray[Any]]] = []
    for batch in bag.batches(topic):
        rows = batch.rows
        found = None  # of chunks that overlap in time
        if batch.chunk is not None:
            found = places.take(batch.chunk.blob, rows.start, rows.end, paths)
        if found is None:
            step(-sum(map(len, times)))
            return None
        times.append(rows.secs + rows.nsecs / 1e9)
        pieces.append(found)
        step(len(rows.conn))
    return np.concatenate(times), [np.concatenate(column) for column in zip(*pieces, strict=True)]


def _decoded(
    bag: BagReader, topic: str, paths: list[str], step: Callable[[int], None]
) -> tuple[list[float], list[NDArray[Any]]]:
    """The same by decoding every message, for messages of any layout."""
    getters = [attrgetter(path) for path in paths]
    columns: list[list[Any]] = [[] for _ in paths]
    times: list[float] = []
    example: Any = None
    for _, message, stamp in bag.read_messages(topic):
        example = message
        times.append(stamp.to_sec())
        for column, get in zip(columns, getters, strict=True):
            column.append(get(message))
        step(1)
    types = [None if example is None else dtype_of(example, path) for path in paths]
    return times, [_as_array(column, kind) for column, kind in zip(columns, types, strict=True)]


def _check_path(message: Any, path: str, topic: str) -> None:
    """Follow a path in an empty message, so that a wrong one is reported before anything is read."""
    at = message
    for name in path.split("."):
        slots = getattr(at, "__slots__", ())
        if name not in slots:
            where = getattr(at, "_type", type(at).__name__)
            raise BagError(f"{topic}: no field {path!r}: {where} has {', '.join(slots) or 'no fields'}")
        at = getattr(at, name)


def _as_array(values: list[Any], dtype: str | None) -> NDArray[Any]:
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
