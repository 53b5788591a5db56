"""Hypothesis draws definitions together with values of them."""

from __future__ import annotations

import struct
from typing import Any

from hypothesis import strategies as st

from rosproto.codec.layout import RANGES_BY_CODE, FieldLayout, Layout, resolve
from rosproto.msg import DefinitionLibrary, Field, FieldType, MessageSpec

NUMBERS = "bool int8 uint8 byte char int16 uint16 int32 uint32 int64 uint64 float32 float64".split()
NAMES = ["x", "y", "header", "in", "class", "serialize", "data", "e", "b", "o", "i", "p", "m1", "n2", "None"]


@st.composite
def libraries(draw: st.DrawFn) -> tuple[DefinitionLibrary, MessageSpec]:
    """One to four types, each made of the ones before; the last is the one to test."""
    library = DefinitionLibrary()
    known: list[str] = []
    for index in range(draw(st.integers(1, 4))):
        bases = st.sampled_from([*NUMBERS, "string", "string", "time", "duration", *known, *known])
        count = draw(st.integers(0 if index == 0 else 1, 6))
        names = draw(st.lists(st.sampled_from(NAMES), min_size=count, max_size=count, unique=True))
        fields = tuple(Field(name, draw(field_types(bases))) for name in names)
        text = "".join(f"{field.type} {field.name}\n" for field in fields)
        spec = MessageSpec(f"pkg/T{index}", fields, (), text)
        library.add(spec)
        known.append(spec.name)
    return library, spec


@st.composite
def field_types(draw: st.DrawFn, bases: st.SearchStrategy[str]) -> FieldType:
    base = draw(bases)
    shape = draw(st.sampled_from(["one", "one", "many", "fixed"]))
    if shape == "one":
        return FieldType(base)
    return FieldType(base, True, draw(st.integers(0, 5)) if shape == "fixed" else None)


def plain_values(layout: Layout) -> st.SearchStrategy[dict[str, Any]]:
    """Values as the reference codec has them."""
    return st.fixed_dictionaries({field.name: field_values(field) for field in layout.fields})


def field_values(field: FieldLayout) -> st.SearchStrategy[Any]:
    if not field.is_array:
        return one_value(field)
    low, high = (0, 6) if field.length is None else (field.length, field.length)
    if field.code == "B":
        return st.binary(min_size=low, max_size=high)
    if field.kind == "string":
        # Neighbours of equal length take another way through the decoder than others.
        return st.one_of(
            st.lists(one_value(field), min_size=low, max_size=high),
            st.lists(st.just("same"), min_size=low, max_size=high),
        )
    return st.lists(one_value(field), min_size=low, max_size=high)


def one_value(field: FieldLayout) -> st.SearchStrategy[Any]:
    if field.layout is not None:
        return plain_values(field.layout)
    if field.kind == "string":
        return texts()
    if field.kind == "time":
        part = st.integers(*RANGES_BY_CODE[field.code[0]])
        return st.tuples(part, part)
    if field.code == "?":
        return st.booleans()
    if field.code in RANGES_BY_CODE:
        return st.integers(*RANGES_BY_CODE[field.code])
    # From bytes: every pattern, NaN payloads and denormals too.
    size = 4 if field.code == "f" else 8
    return st.binary(min_size=size, max_size=size).map(lambda b: struct.unpack("<" + field.code, b)[0])


def texts() -> st.SearchStrategy[str]:
    """Text, and bytes that are not UTF-8 as surrogates."""
    return st.one_of(
        st.sampled_from(["", "map", "odom", "map"]),
        st.text(max_size=5).filter(lambda t: not any(0xD800 <= ord(c) < 0xE000 for c in t)),
        st.binary(max_size=4).map(lambda b: b.decode("utf-8", "surrogateescape")),
    )


@st.composite
def cases(draw: st.DrawFn) -> tuple[DefinitionLibrary, MessageSpec, dict[str, Any]]:
    """A library, a type of it and a value."""
    library, spec = draw(libraries())
    return library, spec, draw(plain_values(resolve(spec, library)))
