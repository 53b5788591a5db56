"""rosbridge's values, for any definition and any value: JSON and CBOR agree with the plain way, and JSON comes back."""

from __future__ import annotations

import base64
import json
import math
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rosproto.codec import decode, encode, message_class
from rosproto.codec.binding import from_plain
from rosproto.codec.layout import FieldLayout, Layout
from rosproto.codec.reference import decode_layout
from rosproto.errors import CodecError
from rosproto.gateway import GatewayLimits
from rosproto.gateway.rosbridge.operations import OPERATIONS, Reply
from rosproto.gateway.rosbridge.protocol import Protocol
from rosproto.gateway.values import from_values, to_json
from tests.property.codec_strategies import cases
from tests.support.rosbridge_values import to_values

COMMON = settings(deadline=None, max_examples=100, suppress_health_check=[HealthCheck.too_slow])
Case = tuple[Any, Any, dict[str, Any]]


def plain_json(layout: Layout, plain: dict[str, Any]) -> dict[str, Any]:
    """The obvious way, from the reference codec's values."""
    return {field.name: plain_field(field, plain[field.name]) for field in layout.fields}


def plain_field(field: FieldLayout, value: Any) -> Any:
    if not field.is_array:
        return plain_one(field, value)
    if field.code == "B":
        return base64.b64encode(bytes(value)).decode()
    return [plain_one(field, item) for item in value]


def plain_one(field: FieldLayout, value: Any) -> Any:
    if field.layout is not None:
        return plain_json(field.layout, value)
    if field.kind == "time":
        return {"secs": value[0], "nsecs": value[1]}
    if field.code in ("f", "d"):
        return value if math.isfinite(value) else None
    return bool(value) if field.code == "?" else value


def message_of(case: Case) -> Any:
    library, spec, plain = case
    cls = message_class(spec, library)
    assert cls._binding is not None
    return decode(cls, encode(from_plain(cls._binding, plain)))


def as_decoded(message: Any) -> dict[str, Any]:
    """The values of the reference codec after the wire: float32 rounded, bytes as text."""
    data = encode(message)
    plain: dict[str, Any] = decode_layout(message._binding.layout, data, 0, len(data))
    return plain


@pytest.mark.slow
@pytest.mark.whole
@COMMON
@given(cases())
def test_json_is_the_plain_way(case: Case) -> None:
    """Every kind of field at any depth, in a text that is ASCII."""
    message = message_of(case)
    text = to_json(message)
    assert text.isascii()
    assert json.loads(text) == plain_json(message._binding.layout, as_decoded(message))


def is_whole(value: Any) -> bool:
    """Without null, and without a text that UTF-8 has no bytes for (surrogateescape: the robot's bytes were none)."""
    if isinstance(value, (dict, list)):
        return all(map(is_whole, value.values() if isinstance(value, dict) else value))
    if isinstance(value, str):
        return value.encode("utf-8", "replace").decode() == value
    return value is not None


@COMMON
@given(cases())
def test_json_comes_back(case: Case) -> None:
    """What was sent out and is sent in is the same message; null, and half a character, are refused."""
    message = message_of(case)
    values = to_values(message)
    if not is_whole(values):
        with pytest.raises(CodecError, match=r"null given; expected a number|half a character"):
            from_values(type(message), values)
        return
    again = from_values(type(message), values)
    assert to_values(decode(type(message), encode(again))) == values


json_values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=20),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=8), inner, max_size=4),
    max_leaves=20,
)
FIELDS = sorted(
    {field.name for row in OPERATIONS.values() for field in row.fields} | {"id", "num", "total", "data"}
)


@pytest.mark.slow
@pytest.mark.whole
@pytest.mark.promise("nothing it sends raises an exception outside the protocol code")
@settings(COMMON, max_examples=300)
@given(st.data())
def test_any_message_is_done_or_refused(data: st.DataObject) -> None:
    """Fields of any kind in any operation: effects whose fields have their types, or one refusal."""
    op = data.draw(st.sampled_from([*OPERATIONS, "fragment", "png", "other"]))
    message = {"op": op, **data.draw(st.dictionaries(st.sampled_from(FIELDS), json_values, max_size=8))}
    protocol = Protocol(GatewayLimits(message_bytes=1 << 16))
    for effect in protocol.receive(json.dumps(message)):
        if isinstance(effect, Reply):
            for payload in effect.payloads:
                answer = json.loads(payload)
                assert answer["op"] == "status" or answer["result"] is False
        else:
            assert hasattr(effect, "id")
            for name in ("topic", "service", "action"):
                assert isinstance(getattr(effect, name, ""), str)


@pytest.mark.promise("nothing it sends raises an exception outside the protocol code")
@COMMON
@given(cases(), json_values)
def test_any_values_fit_or_are_refused(case: Case, value: Any) -> None:
    """A message that was made has bytes."""
    cls = type(message_of(case))
    fields = cls._binding.layout.fields
    for given_value in (value, dict.fromkeys([field.name for field in fields[:1]], value)):
        try:
            message = from_values(cls, given_value)
        except CodecError:
            continue
        assert encode(message) is not None
