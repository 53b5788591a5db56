"""Limits on the size of definitions from the network.

A peer's full text is measured before classes and code are generated from it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

from rosproto.errors import DefinitionError
from rosproto.msg.spec import FieldType, MessageSpec

BUILTIN_SIZES = {
    **dict.fromkeys(("bool", "int8", "uint8", "char", "byte"), 1),
    **dict.fromkeys(("int16", "uint16"), 2),
    **dict.fromkeys(("int32", "uint32", "float32", "string"), 4),
    **dict.fromkeys(("int64", "uint64", "float64", "time", "duration"), 8),
}
"""Bytes on the wire; for a string, those of its length."""

BOXED = frozenset({"string", "time", "duration"})
"""Builtin types with one Python object per value, also in arrays."""


class DefinitionLimits(NamedTuple):
    """Limits for an untrusted definition, ten times the largest real ones.

    Attributes:
        text_bytes: Length of the full text, in characters.
        types: Types defined in it.
        fields: Fields, and constants, of one type.
        name_length: Characters of a type, field or constant name.
        nesting: Depth of nested messages; 10 in moveit. Generated loops nest as deep, and Python allows 20.
        flattened_fields: Builtin fields, including those of nested messages; an array counts once.
        array_length: N of one `T[N]`.
        default_objects: Python objects in a message with default values: nested messages, strings and times,
            also in fixed arrays.
        default_bytes: Size on the wire of a message whose strings and variable arrays are empty.
    """

    text_bytes: int = 1 << 20
    types: int = 1000
    fields: int = 4096
    name_length: int = 255
    nesting: int = 16
    flattened_fields: int = 16384
    array_length: int = 1 << 26
    default_objects: int = 1 << 16
    default_bytes: int = 1 << 26


class _Size(NamedTuple):
    nesting: int
    fields: int
    objects: int
    octets: int


def check_length(name: str, text: str, limits: DefinitionLimits) -> None:
    """Limit the non-empty lines of one type, which is far quicker than parsing them.

    Raises:
        DefinitionError: There are more lines than fields and constants allowed in total.
    """
    most = 2 * limits.fields
    if text.count("\n") >= most:
        lines = sum(line not in ("", "#") for line in (line.strip()[:1] for line in text.split("\n")))
        if lines > most:
            _bound(name, "fields", lines, limits)


def check_limits(
    names: list[str], find: Callable[[str], MessageSpec], limits: DefinitionLimits
) -> Mapping[str, tuple[int, int, int, int]]:
    """Measure types and all types they use.

    Args:
        names: Types to measure.
        find: Returns a type's spec; raises DefinitionError for an unknown one.
        limits: The limits.

    Returns:
        For each type its nesting, flattened fields, default objects and default bytes.

    Raises:
        DefinitionError: A limit is exceeded (it is named), a type is missing, or a type contains itself.
    """
    sizes: dict[str, _Size] = {}
    for name in names:
        _measure(name, find, limits, sizes, ())
    return sizes


def _measure(
    name: str,
    find: Callable[[str], MessageSpec],
    limits: DefinitionLimits,
    sizes: dict[str, _Size],
    trail: tuple[str, ...],
) -> _Size:
    if name in sizes:
        return sizes[name]
    if name in trail:
        raise DefinitionError(f"{name} contains itself: {' -> '.join([*trail[trail.index(name) :], name])}")
    if len(trail) > limits.nesting:  # before Python's recursion limit
        _bound(name, "nesting", len(trail), limits)
    spec = find(name)
    _check_own(spec, limits)
    nesting, fields, objects, octets = 0, 0, 1, 0
    for field in spec.fields:
        inner = _field_size(field.type, lambda base: _measure(base, find, limits, sizes, (*trail, name)))
        nesting = max(nesting, inner.nesting)
        fields += inner.fields
        objects += inner.objects
        octets += inner.octets
    size = sizes[name] = _Size(nesting, fields, objects, octets)
    _bound(name, "nesting", nesting, limits)
    _bound(name, "flattened_fields", fields, limits)
    _bound(name, "default_objects", objects, limits)
    _bound(name, "default_bytes", octets, limits)
    return size


def _field_size(kind: FieldType, measure: Callable[[str], _Size]) -> _Size:
    """The size that one field adds; the fields of `T[]` count too, because code is generated for them."""
    if kind.is_builtin:
        inner = _Size(0, 1, int(kind.base in BOXED), BUILTIN_SIZES[kind.base])
    else:
        below = measure(kind.base)
        inner = below._replace(nesting=below.nesting + 1)
    if not kind.is_array:
        return inner
    if kind.array_length is None:
        return inner._replace(objects=1, octets=4)
    times = kind.array_length
    return inner._replace(objects=1 + inner.objects * times, octets=inner.octets * times)


def _check_own(spec: MessageSpec, limits: DefinitionLimits) -> None:
    _bound(spec.name, "fields", max(len(spec.fields), len(spec.constants)), limits)
    names = [spec.name, *(f.name for f in spec.fields), *(c.name for c in spec.constants)]
    _bound(spec.name[:80], "name_length", max(map(len, names)), limits)
    _bound(spec.name, "array_length", max((f.type.array_length or 0 for f in spec.fields), default=0), limits)


def _bound(name: str, what: str, size: int, limits: DefinitionLimits) -> None:
    limit = getattr(limits, what)
    if size > limit:
        raise DefinitionError(
            f"{name}: {what} is {size if size < 1 << 64 else 'more than 2**64'}, at most {limit} allowed; "
            f"the sender is broken or hostile, or raise DefinitionLimits.{what}"
        )
