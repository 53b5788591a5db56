"""Definitions in the form of rosapi/TypeDef: one dict for a type and one for each type it uses.

Pure. Fields are described as by rosapi's objectutils.py, which reads genpy's classes: builtin types by their
name, examples as Python prints the default value, and constants sorted by name. Where the original fails (a
field of type `char`), the description follows the definition.
"""

from __future__ import annotations

from collections.abc import Callable

from rosproto.msg import Constant, FieldType, MessageSpec

__all__ = ["MOST_TYPES", "type_details"]

MOST_TYPES = 300  # in one answer, and the greatest depth: definitions learned from robots cannot be trusted
_TIMES = ("time", "duration")
_EXAMPLES = {"bool": "False", "string": "", "float32": "0.0", "float64": "0.0"}

Typedef = dict[str, object]


def type_details(spec: MessageSpec, find: Callable[[str], MessageSpec]) -> list[Typedef]:
    """The typedefs of a message and of all it uses, in the order in which fields name them first.

    Args:
        spec: The message, or one half of a service.
        find: Returns the definition of a type by its full name; its exceptions are passed on.
    """
    seen = {spec.name}
    found: list[Typedef] = []

    def visit(spec: MessageSpec) -> None:
        found.append(_typedef(spec))
        for field in spec.fields:
            base = field.type.base
            if base in seen or len(seen) >= MOST_TYPES:
                continue
            seen.add(base)
            if base in _TIMES:
                found.append(_time_typedef(base))
            elif not field.type.is_builtin:
                visit(find(base))

    visit(spec)
    return found


def _typedef(spec: MessageSpec) -> Typedef:
    constants = sorted(spec.constants, key=lambda constant: constant.name)
    return {
        "type": spec.name,
        "fieldnames": [field.name for field in spec.fields],
        "fieldtypes": [field.type.base for field in spec.fields],
        "fieldarraylen": [_array_length(field.type) for field in spec.fields],
        "examples": [_example(field.type) for field in spec.fields],
        "constnames": [constant.name for constant in constants],
        "constvalues": [_value(constant) for constant in constants],
    }


def _time_typedef(name: str) -> Typedef:
    return {
        "type": name,
        "fieldnames": ["secs", "nsecs"],
        "fieldtypes": ["int32", "int32"],
        "fieldarraylen": [-1, -1],
        "examples": ["0", "0"],
        "constnames": [],
        "constvalues": [],
    }


def _array_length(type_: FieldType) -> int:
    if not type_.is_array:
        return -1
    return type_.array_length or 0


def _example(type_: FieldType) -> str:
    if type_.is_array:
        return "[]"
    if type_.base in _TIMES or not type_.is_builtin:
        return "{}"
    return _EXAMPLES.get(type_.base, "0")


def _value(constant: Constant) -> str:
    return str(constant.value)
