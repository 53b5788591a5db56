"""Units of fields, as far as the definitions' comments tell them.

The definitions that come with this package say them in one way: the unit is a part of the comment, between
commas. Where a recording has a definition of its own, its fields that the bundled one has, too, of the same
type, have the same units.
"""

from __future__ import annotations

import re
from functools import lru_cache

from rosproto.errors import DefinitionError

__all__ = ["comments_of", "units_of"]

_FIELD = re.compile(r"^\s*([A-Za-z][\w/]*(?:\[\d*\])?)\s+([A-Za-z]\w*)\s*(?:#(.*))?$")
_COMMENT = re.compile(r"^\s*#(.*)$")
_NAMES = {"degrees Celsius": "°C", "degrees": "°", "0 to 100 %": "%"}
_UNITS = (
    *_NAMES, "m/s^2", "m/s", "m^2", "m", "rad/s^2", "rad/s", "rad^2", "rad", "s", "V", "A h", "A", "W",
    "kg m^2", "kg", "N m", "N", "Hz", "1/min", "%",
)  # fmt: skip
# A part of a comment that is a unit, or a first part that goes on with what it counts: `m per cell`.
_UNIT = "|".join(re.escape(unit) for unit in _UNITS)
_PART = re.compile(_UNIT)
_FIRST = re.compile(rf"({_UNIT}) (?:per|from|along|above|left|when)\b")


def comments_of(text: str) -> dict[str, str]:
    """A definition's comments by field: the one on the field's line, or else those on the lines above it."""
    found: dict[str, str] = {}
    above: list[str] = []
    for line in text.splitlines():
        comment = _COMMENT.match(line)
        field = _FIELD.match(line)
        if comment:
            above.append(comment.group(1).strip())
        elif field:
            said = (field.group(3) or "").strip() or " ".join(filter(None, above))
            if said:
                found[field.group(2)] = said
            above = []
        else:
            above = []
    return found


def units_of(name: str, text: str) -> dict[str, str]:
    """The units of a message's fields, by field.

    Args:
        name: "package/Type".
        text: Its definition.
    """
    known = {**_bundled(name), **_units(text)}
    fields = [match for line in text.splitlines() if (match := _FIELD.match(line))]
    return {match[2]: known[match[1], match[2]] for match in fields if (match[1], match[2]) in known}


@lru_cache(maxsize=256)
def _bundled(name: str) -> dict[tuple[str, str], str]:
    from rosproto.msg import bundled

    try:
        return _units(bundled().message(name).text)
    except DefinitionError:
        return {}


def _units(text: str) -> dict[tuple[str, str], str]:
    """By type and name of a field."""
    found: dict[tuple[str, str], str] = {}
    for line in text.splitlines():
        match = _FIELD.match(line)
        if match and match[3] and (unit := _unit(match[3].strip())):
            found[match[1], match[2]] = unit
    return found


def _unit(comment: str) -> str:
    parts = [part.strip() for part in re.split("[,;]", comment)]
    units = [part for part in parts if _PART.fullmatch(part)]
    if not units and (match := _FIRST.match(comment)):
        units = [match[1]]
    return _NAMES.get(units[0], units[0]) if len(units) == 1 else ""
