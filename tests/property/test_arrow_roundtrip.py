"""Any definition and its values through Arrow and Parquet, and back."""

from __future__ import annotations

import io
import math
import struct
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rosproto.bag import BagReader, BagWriter, Connection, RawMessage
from rosproto.codec.layout import FieldLayout, Layout, resolve
from rosproto.codec.reference import encode_layout
from rosproto.time import Time
from tests.property.codec_strategies import libraries, plain_values

pytest.importorskip("pyarrow", reason="pyarrow is not installed (extra arrow)")

quick = settings(max_examples=60, deadline=None, suppress_health_check=list(HealthCheck))
NS = 10**9
Recording = tuple[Layout, tuple[str, str], list[dict[str, Any]]]


@st.composite
def recordings(draw: st.DrawFn) -> Recording:
    library, spec = draw(libraries())
    layout = resolve(spec, library)
    values = draw(st.lists(plain_values(layout), min_size=1, max_size=7))
    return layout, (library.full_text(spec.name), library.md5sum(spec.name)), values


def bag_of(layout: Layout, definition: tuple[str, str], values: list[dict[str, Any]]) -> BagReader:
    file = io.BytesIO()
    text, md5sum = definition
    facts = {"type": layout.spec.name, "md5sum": md5sum, "message_definition": text}
    connection = Connection(0, "/t", facts["type"], facts["md5sum"], text, facts)
    with BagWriter(file) as bag:
        for number, value in enumerate(values):
            data = encode_layout(layout, value)
            raw = RawMessage(facts["type"], data, facts["md5sum"], (0, 0), connection)
            bag.write("/t", raw, Time(number))
    return BagReader(file)


def expected(layout: Layout, value: dict[str, Any]) -> Any:
    if not layout.fields:
        return None
    return {field.name: expected_field(field, value[field.name]) for field in layout.fields}


def expected_field(field: FieldLayout, value: Any) -> Any:
    if not field.is_array:
        return expected_one(field, value)
    if field.code == "B":
        return bytes(value)
    return [expected_one(field, each) for each in value]


def expected_one(field: FieldLayout, value: Any) -> Any:
    if field.layout is not None:
        return expected(field.layout, value)
    if field.kind == "time":
        return value[0] * NS + value[1]
    if field.kind == "string":
        return value.encode("utf-8", "surrogateescape").decode("utf-8", "replace")
    if field.code in ("f", "d"):
        return bits(value, field.code)
    return value


def bits(value: float, code: str) -> Any:
    return "nan" if math.isnan(value) else struct.pack("<" + code, value)


def plain(array: Any, field: FieldLayout, *, element: bool = False) -> list[Any]:
    """An Arrow array as `expected` has it."""
    import pyarrow as pa

    if field.is_array and not element:
        if field.code == "B":
            return array.to_pylist()
        whole = []
        for number in range(len(array)):
            part = array[number].values
            whole.append(plain(part, field, element=True) if part is not None else None)
        return whole
    if field.layout is not None:
        if not field.layout.fields:
            return [None] * len(array)
        columns = {f.name: plain(array.field(f.name), f) for f in field.layout.fields}
        return [{name: column[i] for name, column in columns.items()} for i in range(len(array))]
    if field.kind == "time":
        return array.view(pa.int64()).to_pylist()
    if field.code in ("f", "d"):
        return [bits(value, field.code) for value in array.to_pylist()]
    return array.to_pylist()


def rows(table: Any, layout: Layout) -> list[Any]:
    columns = {f.name: plain(table.column(f.name).combine_chunks(), f) for f in layout.fields}
    return [{name: column[i] for name, column in columns.items()} for i in range(table.num_rows)]


@quick
@given(recordings())
def test_values_come_back_from_arrow(recording: Recording) -> None:
    """Every field of every message, bit by bit."""
    layout, _, values = recording
    table = bag_of(*recording).to_arrow("/t").read_all()
    table.validate(full=True)
    assert table.column(0).cast("int64").to_pylist() == [number * NS for number in range(len(values))]
    assert rows(table, layout) == (
        [expected(layout, value) for value in values] if layout.fields else [{}] * len(values)
    )


@quick
@given(recordings(), st.data())
def test_a_chosen_field_is_the_same_as_in_the_whole(recording: Recording, data: st.DataObject) -> None:
    """Whatever stands before and behind it is passed over rightly."""
    layout, _, _ = recording
    paths = list(leaves(layout, ""))
    if not paths:
        return
    chosen = data.draw(st.lists(st.sampled_from(paths), min_size=1, max_size=3, unique=True))
    bag = bag_of(*recording)
    table = bag.to_arrow("/t", chosen).read_all()
    whole = bag.to_arrow("/t").read_all()
    assert table.schema.names[1:] == chosen
    for path in chosen:
        first, *inner = path.split(".")
        column = whole.column(first).combine_chunks()
        for name in inner:
            column = column.field(name)
        assert same(table.column(path).combine_chunks().to_pylist(), column.to_pylist())


def same(a: Any, b: Any) -> bool:
    return repr(a) == repr(b)


def leaves(layout: Layout, prefix: str) -> Any:
    for field in layout.fields:
        yield prefix + field.name
        if field.layout is not None and not field.is_array:
            yield from leaves(field.layout, prefix + field.name + ".")


@quick
@given(recordings())
def test_values_come_back_from_parquet(recording: Recording) -> None:
    """Written and read by pyarrow."""
    import pyarrow.parquet as parquet

    layout, _, _values = recording
    table = bag_of(*recording).to_arrow("/t").read_all()
    file = io.BytesIO()
    parquet.write_table(table, file)
    again = parquet.read_table(file)
    assert rows(again, layout) == rows(table, layout)


@quick
@given(recordings(), st.data())
def test_cut_messages_are_a_documented_error(recording: Recording, data: st.DataObject) -> None:
    """What the codec refuses, the table refuses with the same words; what it takes, the table takes."""
    import numpy as np

    from rosproto.bag.arrow.columns import Columns, DefinitionMismatch
    from rosproto.codec.reference import decode_layout
    from rosproto.errors import CodecError

    layout, _, values = recording
    if not layout.fields:
        return
    whole = encode_layout(layout, values[0])
    blob = bytearray(whole)
    if blob:
        at = data.draw(st.integers(0, len(blob) - 1))
        blob[at] = data.draw(st.integers(0, 255))
    blob = blob[: data.draw(st.integers(0, len(blob)))]
    try:
        decode_layout(layout, bytes(blob), 0, len(blob))
    except CodecError:
        refused = True
    else:
        refused = False
    want = {field.name: True for field in layout.fields}
    try:
        Columns(bytes(blob), np.array([0]), np.array([len(blob)])).take(layout, want)
    except DefinitionMismatch:
        assert refused
    else:
        assert not refused
