"""Python source under construction, with the objects it refers to.

The source contains only fixed text of this package and field names that `layout.resolve` has checked to be
identifiers. Everything else (classes, structs, sizes) is an object or an integer. Values never become text.

In a Path, and in nearly every TFMessage, the strings of all elements are as long as those of the first. The
decoder assumes this, reads all elements with one struct and compares the lengths; elements after the first
difference are decoded one by one. Otherwise a Path of 200 poses takes 2.2 times as long, one of 1000 poses
and a TFMessage of 10 transforms 1.5 times (processor time, CPython 3.11).
"""

from __future__ import annotations

import struct
import sys
from collections.abc import Callable
from struct import Struct
from typing import Any

from rosproto.codec.layout import Layout


class Source:
    """Lines of one function and the globals it runs with."""

    def __init__(self, head: str) -> None:
        self._head = [head]
        self._lines: list[str] = []
        self._indent = 1
        self._names: dict[int, str] = {}
        self._counter = 0
        # Generated code uses no builtins, but C code that warns (numpy, when its bool is packed) imports the
        # warnings module with the running function's __import__.
        self.globals: dict[str, Any] = {"__builtins__": {"__import__": __import__}}

    def line(self, text: str) -> None:
        """Add one line at the current indentation."""
        self._lines.append("    " * self._indent + text)

    def first(self, text: str) -> None:
        """Add a line before all others."""
        self._head.append("    " + text)

    def indent(self, text: str) -> None:
        """Add a line that opens a block."""
        self.line(text)
        self._indent += 1

    def indent_later(self) -> Callable[[str], None]:
        """Like `indent`, for a line that depends on the block: call the returned function with its text."""
        place, pad = len(self._lines), "    " * self._indent
        self.indent("")

        def fill(text: str) -> None:
            self._lines[place] = pad + text

        return fill

    def dedent(self) -> None:
        """Close the innermost block."""
        self._indent -= 1

    def fresh(self, prefix: str) -> str:
        """A new local name: the prefix and a number."""
        self._counter += 1
        return f"{prefix}{self._counter}"

    def constant(self, value: object, prefix: str = "k") -> str:
        """The name of a global with this value."""
        name = self._names.get(id(value))
        if name is None:
            name = f"{prefix.upper()}{len(self.globals)}"
            self._names[id(value)] = name
            self.globals[name] = value
        return name

    def variable(self, value: object) -> str:
        """The name of a global that the function rebinds; its initial value is `value`."""
        name = f"V{len(self.globals)}"
        self.globals[name] = value
        self.first(f"global {name}")
        return name

    def struct(self, codes: list[str], method: str) -> str:
        """The global name of a method of a precompiled little-endian struct."""
        return self.constant(_shared_method(merge_codes(codes), method), method[0])

    def struct_for(self, codes: list[str], lengths: list[str], method: str) -> str:
        """The expression for a method of the struct whose strings have the lengths in these locals."""
        known, make = _struct_maker(codes, method)
        key = lengths[0] if len(lengths) == 1 else f"({', '.join(lengths)})"
        return f"{self.constant(known, 'g')}({key}) or {self.constant(make, 'x')}({key})"

    @property
    def text(self) -> str:
        return "\n".join([*self._head, *self._lines]) + "\n"

    def compile(self, name: str, type_name: str) -> Callable[..., Any]:
        """Compile the source and return the function."""
        exec(compile(self.text, f"<rosproto {name} {type_name}>", "exec"), self.globals)
        function: Callable[..., Any] = self.globals.pop(name)
        function.__doc__ = f"Generated {name} function of {type_name}."
        return function


def merge_codes(codes: list[str]) -> str:
    """Join struct codes with repeat counts: ["d", "d", "288x"] -> "<2d288x"."""
    merged: list[str] = []
    last, count = "", 0
    for code in [*codes, ""]:
        if code == last and len(code) == 1:
            count += 1
            continue
        if last:
            merged.append(f"{count}{last}" if count > 1 else last)
        last, count = code, 1
    return "<" + "".join(merged)


def quickest(form: str, *, packs: bool) -> str:
    """The same layout without "<" if it has no padding: native doubles pack a third faster.

    Formats that pack floats keep "<": native packing silently turns too large doubles into infinity.
    """
    native = form[1:]
    if packs and "f" in native:
        return form
    # Not `calcsize`, which caches the last hundred formats of any length.
    if sys.byteorder == "little" and Struct(native).size == Struct(form).size:
        return native
    return form


StructMethod = Callable[..., object]
Lengths = int | tuple[int, ...]
"""The length of a run's string, or those of several strings."""
STRUCTS_KEPT = 4096
MAX_SHARED_CHARACTERS = 256  # of a format; a Struct takes 32 bytes for each; long ones are rarely shared
shared_methods: dict[tuple[str, str], StructMethod] = {}
"""Methods of structs by format and name, shared by all types; at most `STRUCTS_KEPT`."""


def _shared_method(form: str, method: str) -> StructMethod:
    """One method per format for all types; the cache is bounded, because definitions are untrusted."""
    found = shared_methods.get((form, method))
    if found is None:
        found = getattr(Struct(quickest(form, packs=method == "pack")), method)
        if len(form) <= MAX_SHARED_CHARACTERS:
            if len(shared_methods) >= STRUCTS_KEPT:
                shared_methods.clear()
            shared_methods[form, method] = found
    return found


def flat_codes(layout: Layout) -> list[str]:
    """struct codes of a message without arrays; a string's are "I" and "%ds"."""
    codes: list[str] = []
    for field in layout.fields:
        if field.kind == "string":
            codes.extend(("I", "%ds"))
        elif field.layout is not None:
            codes.extend(flat_codes(field.layout))
        else:
            codes.extend(field.code)
    return codes


def length_offsets(codes: list[str]) -> list[int]:
    """Offset of each string's length, without the bytes of preceding strings."""
    offsets, position = [], 0
    for code, following in zip(codes, [*codes[1:], ""], strict=True):
        if following == "%ds":
            offsets.append(position)
        if code != "%ds":
            position += struct.calcsize("<" + code)
    return offsets


def strings_inside(layout: Layout) -> int | None:
    """Number of strings in a message; None if it contains an array."""
    total = 0
    for field in layout.fields:
        if field.is_array:
            return None
        if field.kind == "string":
            total += 1
        elif field.layout is not None:
            inner = strings_inside(field.layout)
            if inner is None:
                return None
            total += inner
    return total


CACHED_STRUCTS = 256
CACHED_LENGTH = 512


def _struct_maker(
    codes: list[str], method: str
) -> tuple[Callable[[Lengths], StructMethod | None], Callable[[Lengths], StructMethod]]:
    """Two functions of the lengths of a run's strings: the method of its struct if known, and a new one.

    Lengths are one number, or a tuple for several strings. The cache is bounded.
    """
    form = merge_codes(codes)
    known: dict[Lengths, StructMethod] = {}

    def make(lengths: Lengths) -> StructMethod:
        found: StructMethod = getattr(Struct(quickest(form % lengths, packs=method == "pack")), method)
        longest = lengths if isinstance(lengths, int) else max(lengths)
        if longest <= CACHED_LENGTH:
            if len(known) >= CACHED_STRUCTS:
                known.clear()
            known[lengths] = found
        return found

    return known.get, make
