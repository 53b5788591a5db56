"""Make a `DefinitionLibrary` of a full text from a connection header or bag.

The text is untrusted: its size is limited, and it is measured before classes and code are generated from it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from rosproto.errors import DefinitionError
from rosproto.msg.full_text import split_full_text
from rosproto.msg.library import DefinitionLibrary
from rosproto.msg.parser import parse_message
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
        nesting: Depth of nested messages; 10 in moveit. The codec takes no more than the default: Python
            allows about 1000 calls inside one another, and copying a message takes several for each level.
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
    nesting: int = 64
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
    limit = 2 * limits.fields
    if text.count("\n") >= limit:
        lines = sum(line not in ("", "#") for line in (line.strip()[:1] for line in text.split("\n")))
        if lines > limit:
            _bound(name, "fields", lines, limits)


def check_limits(names: list[str], find: Callable[[str], MessageSpec], limits: DefinitionLimits) -> None:
    """Measure types and all types they use.

    Args:
        names: Types to measure.
        find: Returns a type's spec; raises DefinitionError for an unknown one.
        limits: The limits.

    Raises:
        DefinitionError: A limit is exceeded (it is named), a type is missing, or a type contains itself.
    """
    sizes: dict[str, _Size] = {}
    for name in names:
        _measure(name, find, limits, sizes, ())


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


def library_from_full_text(
    name: str,
    text: str,
    *,
    base: DefinitionLibrary | None = None,
    limits: DefinitionLimits | None = None,
) -> DefinitionLibrary:
    """Definitions from a full text, as in a connection header or bag.

    The text is untrusted: its size is limited, names must be legal identifiers, and no type may contain
    itself. Code may be generated from the result.

    Args:
        name: "package/Type" of the first definition.
        text: Its definition and that of each type it uses, separated by "=" * 80 and "MSG: package/Type".
        base: Library of types that the text does not define; none by default.
        limits: Maximum sizes.

    Raises:
        DefinitionError: The text is not legal, not complete or exceeds a limit.
    """
    limits = limits or DefinitionLimits()
    if len(text) > limits.text_bytes:
        raise DefinitionError(
            f"{name[:300]}: the full text has {len(text)} characters, at most {limits.text_bytes} allowed; "
            f"the sender is broken or hostile, or raise DefinitionLimits.text_bytes"
        )
    parts = split_full_text(text, name)
    if len(parts) > limits.types:
        raise DefinitionError(
            f"{name}: the full text defines {len(parts)} types, at most {limits.types} allowed; "
            f"the sender is broken or hostile, or raise DefinitionLimits.types"
        )
    library = DefinitionLibrary(base=base)
    for part, body in parts.items():
        check_length(part, body, limits)
        library.add(parse_message(body, part, lenient=True))
    if "roslib/Header" in parts and "std_msgs/Header" not in parts:
        # Texts from before REP 100 (in old bags) use this name; `Header` now means std_msgs/Header.
        library.add(parse_message(parts["roslib/Header"], "std_msgs/Header", lenient=True))
    check_limits(list(parts), library.message, limits)
    return library
