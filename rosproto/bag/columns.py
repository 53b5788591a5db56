"""Fields of a topic's messages as numpy columns."""

from __future__ import annotations

from collections.abc import Iterable
from operator import attrgetter
from typing import TYPE_CHECKING, Any

from rosproto.errors import BagError
from rosproto.time import TVal

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from rosproto.bag.reader import BagReader

__all__ = ["to_numpy"]


def to_numpy(bag: BagReader, topic: str, fields: Iterable[str]) -> dict[str, NDArray[Any]]:
    """Read fields of all messages of a topic into arrays.

    Args:
        bag: The bag.
        topic: A topic of it.
        fields: Paths such as "pose.pose.position.x".

    Returns:
        "receive_time" (seconds since 1970, (N,) float64), and one array for each field: (N,) in the field's
        own type, times and durations as float64 seconds, arrays of one length as (N, length), arrays of
        varying length as (N,) object.

    Raises:
        BagError: No such topic, or no such field; the message lists what there is.
    """
    import numpy as np

    paths = list(fields)
    for connection in bag._topic(topic).connections:
        for path in paths:
            _check_path(bag.message_class(connection)(), path, topic)
    getters = [attrgetter(path) for path in paths]
    columns: list[list[Any]] = [[] for _ in paths]
    times: list[float] = []
    for _, message, stamp in bag.read_messages(topic):
        times.append(stamp.to_sec())
        for column, get in zip(columns, getters, strict=True):
            column.append(get(message))
    arrays: dict[str, NDArray[Any]] = {"receive_time": np.array(times, np.float64)}
    for path, column in zip(paths, columns, strict=True):
        arrays[path] = _as_array(column)
    return arrays


def _check_path(message: Any, path: str, topic: str) -> None:
    """Follow a path in an empty message, to complain before anything is read."""
    at = message
    for name in path.split("."):
        slots = getattr(at, "__slots__", ())
        if name not in slots:
            where = getattr(at, "_type", type(at).__name__)
            raise BagError(f"{topic}: no field {path!r}: {where} has {', '.join(slots) or 'no fields'}")
        at = getattr(at, name)


def _as_array(values: list[Any]) -> NDArray[Any]:
    import numpy as np

    if values and isinstance(values[0], TVal):
        return np.array([value.to_sec() for value in values], np.float64)
    if values and isinstance(values[0], (str, int, float, bool)):
        return np.array(values)
    lengths = {len(value) if hasattr(value, "__len__") else -1 for value in values}
    if len(lengths) == 1 and -1 not in lengths and all(isinstance(value, np.ndarray) for value in values):
        return np.stack(values)
    column = np.empty(len(values), object)
    column[:] = values
    return column
