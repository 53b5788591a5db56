"""Messages as plain values for the reference codec, and back. Slow; for errors and odd definitions."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rosproto.codec.layout import DTYPES, FieldLayout, Layout

if TYPE_CHECKING:
    from rosproto.codec.binding import Binding


def to_plain(layout: Layout, message: Any) -> Any:
    """A message as the reference codec takes it; fields without a value are left out.

    What cannot be a message of that type is handed on as it is: the reference codec names it.
    """
    if isinstance(message, dict) or (
        layout.fields and not any(hasattr(message, f.name) for f in layout.fields)
    ):
        return message if not isinstance(message, dict) else _dict_given
    return {
        field.name: _plain_field(field, getattr(message, field.name))
        for field in layout.fields
        if hasattr(message, field.name)
    }


_dict_given = type(
    "dict", (), {"__doc__": "A dict where a message is meant: refused, as the fast code does."}
)()


def _plain_field(field: FieldLayout, value: Any) -> Any:
    if not field.is_array:
        return _plain_one(field, value)
    if isinstance(value, (str, bytes, bytearray, dict)) or value is None:
        return value
    if isinstance(value, memoryview):
        return bytes(value)
    if hasattr(value, "tolist") and hasattr(value, "dtype"):
        if value.ndim == 0:
            return value.item()
        if field.code == "B" and value.dtype.str == "|u1":
            return value.tobytes()
        items = value.reshape(-1).tolist()
        # As the fast code: whole numbers by their truth; 0.5 and "false" are no booleans.
        return [bool(item) for item in items] if field.code == "?" and value.dtype.kind in "biu" else items
    try:
        items = list(value)
    except TypeError:
        return value
    return [_plain_one(field, item) for item in items]


def _plain_one(field: FieldLayout, value: Any) -> Any:
    if field.layout is not None:
        return to_plain(field.layout, value)
    if field.kind == "time" and hasattr(value, "secs") and hasattr(value, "nsecs"):
        return (value.secs, value.nsecs)
    if field.code == "?" and hasattr(value, "dtype"):
        return bool(value)  # numpy.bool_ has no __index__
    return value


def from_plain(binding: Binding, plain: dict[str, Any]) -> Any:
    """A message of `binding`'s class from the reference codec's values."""
    message = _build(binding, binding.layout, plain)
    message._connection_header = None
    return message


def _build(binding: Binding, layout: Layout, plain: dict[str, Any]) -> Any:
    message = binding.maker(layout.spec.name)()
    for field in layout.fields:
        value = plain[field.name]
        if not field.is_array:
            value = _build_one(binding, field, value)
        elif field.kind == "number":
            value = _numbers(binding, field, value)
        else:
            value = [_build_one(binding, field, item) for item in value]
        setattr(message, field.name, value)
    return message


def _build_one(binding: Binding, field: FieldLayout, value: Any) -> Any:
    if field.layout is not None:
        return _build(binding, field.layout, value)
    if field.kind == "time":
        flavour = binding.flavour
        return (flavour.time if field.base == "time" else flavour.duration).from_wire(*value)
    return value


def _numbers(binding: Binding, field: FieldLayout, value: Any) -> Any:
    if not binding.flavour.views:
        return value if isinstance(value, bytes) else value if field.code == "?" else tuple(value)
    import numpy as np

    array = (
        np.frombuffer(value, "u1")
        if isinstance(value, bytes) and value
        else np.array(list(value), DTYPES[field.base])
    )
    array.flags.writeable = False
    return array
