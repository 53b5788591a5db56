"""Fields of a message as text: paths (`/pose/pose/position/x`, `/ranges[0]`) and lines of CSV.

The CSV has the column names of `rostopic echo -p`.
"""

from __future__ import annotations

import re
from collections.abc import Callable

from rosproto.codec import Message
from rosproto.time import TVal

STEP = re.compile(r"(?P<name>[A-Za-z_]\w*)(?P<indices>(?:\[[^\]]*\])*)", re.ASCII)
INDEX = re.compile(r"\[\s*(-?\d*)\s*(:?)\s*(-?\d*)\s*(?::\s*(-?\d+)\s*)?\]", re.ASCII)


class FieldPathError(ValueError):
    """A path is malformed, or the message lacks its field.

    Attributes:
        path: The path as typed.
    """

    def __init__(self, message: str, path: str) -> None:
        super().__init__(f"{path}: {message}")
        self.path = path


class MissingElement(FieldPathError):
    """This message's array is too short."""


def split_topic(text: str, topics: list[str]) -> tuple[str, str]:
    """Split `/odom/pose/pose/position/x` at the longest known topic name.

    Returns:
        (topic, field path); the path is "" when the whole text is a topic or no topic is known.
    """
    for end in sorted((i for i, c in enumerate(text + "/") if c in "/[" and i), reverse=True):
        if text[:end] in topics:
            return text[:end], text[end:].lstrip("/")
    return text, ""


def parse_field_path(path: str, shown: str | None = None) -> Callable[[object], object]:
    """Return a function that gets the path's part of a message; "" is the whole message.

    Args:
        path: `pose/position/x`, `ranges[0]`.
        shown: The path in errors: as typed, with the topic.

    Raises:
        FieldPathError: The path is malformed. The returned function raises it, too, with the known fields.
    """
    shown = shown or path
    steps = [_parse_step(part, shown) for part in path.strip("/").split("/")] if path.strip("/") else []

    def take(message: object) -> object:
        value = message
        for name, indices in steps:
            value = _field(value, name, shown)
            for index in indices:
                value = _element(value, index, shown)
        return value

    return take


def _parse_step(part: str, path: str) -> tuple[str, list[int | slice]]:
    match = STEP.fullmatch(part)
    if match is None:
        raise FieldPathError(f"{part!r} is not a field name, with or without [index] or [from:to]", path)
    indices: list[int | slice] = []
    for text in re.findall(r"\[[^\]]*\]", match["indices"]):
        found = INDEX.fullmatch(text)
        if found is None or not (found[1] or found[2]):
            raise FieldPathError(f"{text} is not an index: write [3], [-1] or [10:20]", path)
        start, colon, stop, step = found.groups()
        if colon:
            indices.append(slice(*(int(x) if x else None for x in (start, stop, step))))
        else:
            indices.append(int(start))
    return match["name"], indices


def _field(value: object, name: str, path: str) -> object:
    if isinstance(value, list):
        return [_field(item, name, path) for item in value]
    slots = getattr(type(value), "__slots__", ())
    if name in slots:
        return getattr(value, name)
    kind = getattr(value, "_type", type(value).__name__)
    raise FieldPathError(f"{kind} has no field {name!r}; it has: {', '.join(slots) or 'none'}", path)


def _element(value: object, index: int | slice, path: str) -> object:
    try:
        found = value[index]  # type: ignore[index]
    except IndexError:
        raise MissingElement(f"index {index} is out of range, the length is {len(value)}", path) from None  # type: ignore[arg-type]
    except TypeError:
        raise FieldPathError(f"{type(value).__name__} is not an array", path) from None
    # numpy numbers print and compare differently, and JSON does not support them.
    return found.item() if getattr(found, "ndim", None) == 0 else found


def header(value: object, prefix: str) -> list[str]:
    """Return the column names: `field.pose.position.x`; `field.ranges0` and `field.ranges1` for an array."""
    value = _items(value)
    if isinstance(value, Message):
        return [n for f in value.__slots__ for n in header(getattr(value, f), f"{prefix}.{f}")]
    if isinstance(value, (list, tuple, bytes)):
        return [n for i, item in enumerate(value) for n in header(item, f"{prefix}{i}")]
    return [prefix]


def row(value: object) -> list[str]:
    """Return the values in the order of `header`, quoted for CSV; times in nanoseconds, bools 0 and 1."""
    value = _items(value)
    if isinstance(value, Message):
        return [cell for f in value.__slots__ for cell in row(getattr(value, f))]
    if isinstance(value, (list, tuple, bytes)):
        return [cell for item in value for cell in row(item)]
    if isinstance(value, bool):
        return ["1" if value else "0"]
    if isinstance(value, TVal):
        return [str(value.to_nsec())]
    if isinstance(value, str) and any(c in value for c in ',"\n\r'):
        return ['"' + value.replace('"', '""') + '"']
    return [str(value)]


def _items(value: object) -> object:
    return value.tolist() if hasattr(value, "tolist") else value
