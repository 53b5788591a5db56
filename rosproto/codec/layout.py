"""The wire layout of a definition: kinds, sizes, bounds. Resolved once, before code is generated.

Definitions may come from a peer (connection header, bag), so they are untrusted: names for generated source
are checked again, recursion is refused, and the size of one message is limited.
"""

from __future__ import annotations

import keyword
import re
from collections.abc import Container
from struct import calcsize

from rosproto.errors import DefinitionError
from rosproto.msg import DefinitionLibrary, DefinitionLimits
from rosproto.msg.parser import INTEGER_RANGES
from rosproto.msg.spec import Field, MessageSpec

_NUMBERS = {
    "bool": ("?", "?"),
    "int8": ("b", "i1"),
    "byte": ("b", "i1"),
    "uint8": ("B", "u1"),
    "char": ("B", "u1"),
    "int16": ("h", "<i2"),
    "uint16": ("H", "<u2"),
    "int32": ("i", "<i4"),
    "uint32": ("I", "<u4"),
    "int64": ("q", "<i8"),
    "uint64": ("Q", "<u8"),
    "float32": ("f", "<f4"),
    "float64": ("d", "<f8"),
}
FORMATS = {name: code for name, (code, _) in _NUMBERS.items()}
"""struct codes; byte is a signed and char an unsigned octet (genmsg)."""
DTYPES = {name: dtype for name, (_, dtype) in _NUMBERS.items()}
"""Types of numpy."""

RANGES_BY_CODE = {"?": (0, 255), **{FORMATS[kind]: bounds for kind, bounds in INTEGER_RANGES.items()}}
"""Least and greatest integer; a bool may be any octet, as in genpy."""

MAX_DEPTH = DefinitionLimits().nesting
MAX_OBJECTS = 1 << 16
"""Maximum number of values in one message with empty variable-length arrays."""
MAX_FIXED_BYTES = 1 << 26
"""Maximum bytes of one message with empty variable parts: 64 MiB."""

MAX_WEIGHT = 100
"""Maximum memory per byte of the smallest element; `std_msgs/Bool` has 64, a point of three floats 14."""
_OBJECT, _SLOT, _LIST, _ARRAY, _NUMBER = 56, 8, 56, 112, 28  # CPython and numpy, 64 bits

_IDENTIFIER = re.compile(r"[A-Za-z][A-Za-z0-9_]*", re.ASCII)


def attribute_name(name: str, others: Container[str]) -> str:
    """The attribute name of a field in generated code.

    A Python keyword (`woosh_msgs/NavMode` has a field `in`) cannot follow a dot. The class has a second name
    for the same slot: `in_`, as in genpy, or `_kw_in` if a field is named `in_`. A field `self` is treated in
    the same way, as in genpy.
    """
    if not keyword.iskeyword(name) and name != "self":
        return name
    return f"{name}_" if f"{name}_" not in others else f"_kw_{name}"


class FieldLayout:
    """One field, resolved.

    Attributes:
        name: As in the definition.
        attr: As written in generated code.
        base: Builtin type, or full name of a message.
        kind: "number", "string", "time" (time and duration) or "message".
        code: struct codes of one element ("II" for a time); "" for string and message.
        size: Bytes of one element; the minimum for strings and messages.
        is_array, length: `T[]` is (True, None), `T[N]` is (True, N).
        layout: The nested message's layout; None for builtins.
    """

    __slots__ = ("attr", "base", "code", "is_array", "kind", "layout", "length", "name", "size", "type_text")

    def __init__(self, field: Field, layout: Layout | None, names: Container[str]) -> None:
        self.name = field.name
        self.attr = attribute_name(field.name, names)
        self.base = field.type.base
        self.type_text = str(field.type)
        self.is_array = field.type.is_array
        self.length = field.type.array_length
        self.layout = layout
        if layout is not None:
            self.kind, self.code, self.size = "message", "", layout.min_size
        elif self.base == "string":
            self.kind, self.code, self.size = "string", "", 4
        elif self.base in ("time", "duration"):
            self.kind, self.code, self.size = "time", "II" if self.base == "time" else "ii", 8
        else:
            self.kind, self.code = "number", FORMATS[self.base]
            self.size = calcsize("<" + self.code)

    @property
    def count(self) -> int:
        """Minimum number of elements: 1, N of `T[N]`, 0 of `T[]`."""
        return (self.length or 0) if self.is_array else 1

    @property
    def min_size(self) -> int:
        """Minimum size in bytes."""
        return 4 if self.is_array and self.length is None else self.count * self.size

    @property
    def objects(self) -> int:
        """Python values made for this field when every variable array is empty."""
        if self.kind == "number" and self.is_array:
            return 1
        return 1 + self.count * (self.layout.objects if self.layout else 1)

    @property
    def weight(self) -> int:
        """Memory in bytes that it adds to a message with empty variable arrays and strings."""
        if self.is_array:
            if self.kind == "number":
                return _SLOT + _ARRAY
            return _SLOT + _LIST + self.count * (_SLOT + self._one)
        return _SLOT + self._one

    @property
    def _one(self) -> int:
        if self.layout is not None:
            return self.layout.weight
        if self.kind == "time":
            return _OBJECT + 2 * _NUMBER
        return _NUMBER if self.kind == "number" and self.size > 1 else 0  # small ints and "" are shared


class Layout:
    """A message definition, resolved with all nested ones.

    Attributes:
        spec: The definition.
        fields: In wire order.
        min_size: Minimum size in bytes; received counts are checked against it.
        fixed_size: Its size in bytes if constant, else None.
        objects: Python values in the smallest message.
        has_numbers: It contains an array of numbers (decoded as a view of the buffer).
        weight: Approximate memory of the smallest message, in bytes.
        sparse: An array's elements take far more memory than bytes (`std_msgs/Empty[]`): the reference codec
            decodes them with a memory limit.
    """

    __slots__ = ("fields", "fixed_size", "has_numbers", "min_size", "objects", "sparse", "spec", "weight")

    def __init__(self, spec: MessageSpec, fields: list[FieldLayout]) -> None:
        self.spec = spec
        self.fields = fields
        self.min_size = sum(f.min_size for f in fields)
        self.weight = _OBJECT + sum(f.weight for f in fields)
        self.objects = 1 + sum(f.objects for f in fields)
        fixed = all(
            not (f.is_array and f.length is None)
            and f.kind != "string"
            and (f.layout is None or f.layout.fixed_size is not None)
            for f in fields
        )
        self.fixed_size: int | None = self.min_size if fixed else None
        self.has_numbers: bool = any(
            (f.kind == "number" and f.is_array) or (f.layout is not None and f.layout.has_numbers)
            for f in fields
        )
        self.sparse: bool = any(
            f.layout is not None and (f.layout.sparse or (f.is_array and f.layout.is_light)) for f in fields
        )

    @property
    def is_light(self) -> bool:
        """Whether the smallest message takes far more memory than bytes (see `MAX_WEIGHT`)."""
        return self.weight > MAX_WEIGHT * self.min_size


def resolve(spec: MessageSpec, library: DefinitionLibrary) -> Layout:
    """Resolve `spec` and all used types.

    Raises:
        DefinitionError: A nested definition is missing, recursive or too large; a name is not an identifier.
    """
    return _resolve(spec, library, (), {})


def _resolve(
    spec: MessageSpec, library: DefinitionLibrary, outer: tuple[str, ...], done: dict[str, Layout]
) -> Layout:
    known = done.get(spec.name)
    if known is not None:
        return known
    path = (*outer, spec.name)
    if spec.name in outer:
        raise DefinitionError(
            f"{' contains '.join(path)}: a message cannot contain itself; use an array index or id"
        )
    if len(outer) > MAX_DEPTH:
        raise DefinitionError(f"{path[0]}: more than {MAX_DEPTH} messages inside one another")
    fields: list[FieldLayout] = []
    seen: set[str] = set()
    names = {field.name for field in spec.fields}
    for field in spec.fields:
        check_field_name(field.name, spec.name)
        if field.name in seen:
            raise DefinitionError(f"{spec.name}: field {field.name} is defined twice")
        seen.add(field.name)
        nested = None
        if not field.type.is_builtin:
            nested = _resolve(library.message(field.type.base), library, path, done)
        fields.append(FieldLayout(field, nested, names))
    layout = Layout(spec, fields)
    _check_size(layout)
    done[spec.name] = layout
    return layout


def check_field_name(name: str, message: str) -> None:
    """Refuse a field name that is not an identifier; it becomes part of generated source.

    Raises:
        DefinitionError: The name is not an identifier.
    """
    if not _IDENTIFIER.fullmatch(name) or len(name) > 1024:
        raise DefinitionError(
            f"{message}: field name {name[:80]!r} is not a letter followed by letters, digits, _"
        )


def _check_size(layout: Layout) -> None:
    name = layout.spec.name
    if layout.objects > MAX_OBJECTS:
        raise DefinitionError(
            f"{name}: one message would hold {layout.objects} values, at most {MAX_OBJECTS} allowed"
        )
    if layout.min_size > MAX_FIXED_BYTES:
        raise DefinitionError(
            f"{name}: fixed parts take {layout.min_size} bytes, at most {MAX_FIXED_BYTES} allowed; "
            "use an array of variable length"
        )
