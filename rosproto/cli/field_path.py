"""Paths into a message as people type them after a topic: `/pose/pose/position/x`, `/ranges[0]`."""

from __future__ import annotations

import re
from collections.abc import Callable

__all__ = ["FieldPathError", "parse_field_path", "split_topic"]

STEP = re.compile(r"(?P<name>[A-Za-z_]\w*)(?P<indices>(?:\[[^\]]*\])*)", re.ASCII)
INDEX = re.compile(r"\[\s*(-?\d*)\s*(:?)\s*(-?\d*)\s*(?::\s*(-?\d+)\s*)?\]", re.ASCII)


class FieldPathError(ValueError):
    """A path is malformed, or names what the message does not have.

    Attributes:
        path: The path as typed.
    """

    def __init__(self, message: str, path: str) -> None:
        super().__init__(f"{path}: {message}")
        self.path = path


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
    """A function that takes the part of a message a path names; "" is the message itself.

    Args:
        path: `pose/position/x`, `ranges[0]`.
        shown: How errors call it: as typed, with the topic.

    Raises:
        FieldPathError: The path is malformed. The returned function raises it too, naming the fields.
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
        raise FieldPathError(f"index {index} is outside, the array has {len(value)} elements", path) from None  # type: ignore[arg-type]
    except TypeError:
        raise FieldPathError(f"{type(value).__name__} is not an array", path) from None
    # numpy's own numbers print and compare unlike Python's, and JSON does not know them.
    return found.item() if getattr(found, "ndim", None) == 0 else found
