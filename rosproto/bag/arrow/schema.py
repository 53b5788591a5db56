"""The Arrow schema of a topic, from its message definition.

Nested messages are structs, arrays are lists (fixed-size lists where the definition fixes the length),
`uint8[]` and `char[]` are binary, times are UTC timestamps and durations are durations, both in nanoseconds,
and a single string is dictionary-encoded, so that a frame's name is stored once. Bytes that are not UTF-8
become U+FFFD. A message without fields becomes a column of nulls.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from functools import lru_cache
from types import ModuleType
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

from rosproto.bag.records import Connection
from rosproto.codec import Message
from rosproto.codec.layout import DTYPES, FieldLayout, Layout
from rosproto.errors import BagError, DefinitionError
from rosproto.extras import optional_module

if TYPE_CHECKING:
    from pyarrow import DataType, Schema

WantedFields: TypeAlias = "Mapping[str, Literal[True] | WantedFields]"
"""Wanted fields by name: True, or the wanted nested fields."""


def schema_of(cls: type[Message], connection: Connection, fields: Iterable[str] | None = None) -> Schema:
    """The schema that `to_arrow` gives a topic's messages.

    Args:
        cls: Their class.
        connection: Their connection; its md5sum and definition become metadata.
        fields: Paths such as "pose.pose.position.x", each a column of that name; None for all of the message.

    Returns:
        A pyarrow.Schema: the receive time, then the fields. Its metadata have `topic`, `type`, `md5sum` and
        `definition`; a field's have its `comment` in the definition, and the `unit` stated there.

    Raises:
        BagError: No such field, or pyarrow is missing.
    """
    pa = pyarrow()
    layout = layout_of(cls)
    paths = None if fields is None else list(fields)
    wanted_fields(layout, paths, connection.topic)
    names = [field.name for field in layout.fields] if paths is None else list(dict.fromkeys(paths))
    columns = [pa.field(time_name(names), pa.timestamp("ns", "UTC"), nullable=False)]
    for path in names:
        owner, field = _find(layout, path)
        metadata = _metadata(owner).get(field.name)
        columns.append(pa.field(path, arrow_type(field, single=True), metadata=metadata))
    definition = connection.definition or cls._full_text
    facts = {
        "topic": connection.topic,
        "type": connection.type,
        "md5sum": connection.md5sum,
        "definition": definition,
    }
    return pa.schema(columns, {name: text.encode("utf-8", "surrogateescape") for name, text in facts.items()})


def time_name(names: Iterable[str]) -> str:
    """The name of the receive time's column; a message's own field of that name takes precedence."""
    return "_receive_time" if "receive_time" in names else "receive_time"


def layout_of(cls: type[Message]) -> Layout:
    """The resolved definition of a message class."""
    assert cls._binding is not None
    return cls._binding.layout


def wanted_fields(layout: Layout, paths: Iterable[str] | None, topic: str) -> WantedFields:
    """The wanted fields as a tree.

    Raises:
        BagError: There is no such field; names those that exist.
    """
    if paths is None:
        return {field.name: True for field in layout.fields}
    tree: dict[str, Any] = {}
    for path in paths:
        at, inside = layout, tree
        parts = path.split(".")
        for number, name in enumerate(parts):
            field = next((field for field in at.fields if field.name == name), None)
            last = number == len(parts) - 1
            if field is None or not (last or (field.layout is not None and not field.is_array)):
                names = ", ".join(f.name for f in at.fields) or "no fields"
                why = f"{at.spec.name} has {names}"
                if field is not None:
                    why = f"{name} is {field.type_text}, a column as a whole"
                raise BagError(f"{topic}: no field {path!r}: {why}")
            if last:
                inside.setdefault(name, {})[""] = True
            else:
                assert field.layout is not None
                at, inside = field.layout, inside.setdefault(name, {})
    return tree


def _find(layout: Layout, path: str) -> tuple[Layout, FieldLayout]:
    *outer, last = path.split(".")
    for name in outer:
        layout = next(field.layout for field in layout.fields if field.name == name)  # type: ignore[assignment]
    return layout, next(field for field in layout.fields if field.name == last)


def is_binary(field: FieldLayout) -> bool:
    """Whether an array of this type is binary data."""
    return field.is_array and field.code == "B"


def arrow_type(field: FieldLayout, *, single: bool) -> DataType:
    """A field's Arrow type.

    Args:
        field: The field.
        single: True outside of arrays, where strings are dictionary-encoded.
    """
    pa = pyarrow()
    if is_binary(field):
        return pa.binary(field.length) if field.length else pa.binary()
    if field.layout is not None:
        one = struct_type(field.layout, single=single and not field.is_array)
    elif field.kind == "string":
        one = pa.dictionary(pa.int32(), pa.string()) if single and not field.is_array else pa.string()
    elif field.kind == "time":
        one = pa.timestamp("ns", "UTC") if field.base == "time" else pa.duration("ns")
    else:
        one = number_type(field)
    if not field.is_array:
        return one
    return pa.list_(one, field.length) if field.length else pa.list_(one)


def struct_type(layout: Layout, *, single: bool) -> DataType:
    """A message's Arrow type."""
    pa = pyarrow()
    if not layout.fields:
        return pa.null()
    facts = _metadata(layout)
    return pa.struct(
        [
            pa.field(field.name, arrow_type(field, single=single), metadata=facts.get(field.name))
            for field in layout.fields
        ]
    )


def _metadata(layout: Layout) -> dict[str, dict[str, str]]:
    """Comment and unit in the definition, by field."""
    found: dict[str, dict[str, str]] = {}
    for name, comment in comments_of(layout.spec.text).items():
        found.setdefault(name, {})["comment"] = comment
    for name, unit in units_of(layout.spec.name, layout.spec.text).items():
        found.setdefault(name, {})["unit"] = unit
    return found


def number_type(field: FieldLayout) -> DataType:
    """The Arrow type of a number, or of a number in an array."""
    return pyarrow().from_numpy_dtype(DTYPES[field.base])


# -- the optional library -----------------------------------------------------------------------------------


def pyarrow() -> ModuleType:
    """Import pyarrow.

    Raises:
        BagError: It is not installed; names the extra.
    """
    return optional_module("pyarrow", BagError('tables need the package pyarrow: pip install ".[arrow]"'))


# -- units, from the comments of a definition ---------------------------------------------------------------
# Units of fields, if comments of the definition state them.
#
# In bundled definitions the unit is a part of the comment, between commas. If a recording has another
# definition, fields with the same name and type as in the bundled one have the same units.


_FIELD = re.compile(r"^\s*([A-Za-z][\w/]*(?:\[\d*\])?)\s+([A-Za-z]\w*)\s*(?:#(.*))?$")
_COMMENT = re.compile(r"^\s*#(.*)$")
_NAMES = {"degrees Celsius": "°C", "degrees": "°", "0 to 100 %": "%"}
_UNITS = (
    *_NAMES, "m/s^2", "m/s", "m^2", "m", "rad/s^2", "rad/s", "rad^2", "rad", "s", "V", "A h", "A", "W",
    "kg m^2", "kg", "N m", "N", "Hz", "1/min", "%",
)  # fmt: skip
# A unit as a whole part of a comment, or at the beginning of the first part: `m per cell`.
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
    """Units by type and name of a field."""
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
