"""Generates code that packs a long array of messages with one list comprehension.

This is a tenth faster than a loop. Elements consist of numbers, times and at most one string, which must be
the same object in all elements, as in a received Path or if a program sets one frame_id.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

from rosproto.codec.generated_source import Source, merge_codes, strings_inside
from rosproto.codec.layout import FieldLayout, Layout

AT_ONCE_FROM = 32
"""Minimum number of elements for one comprehension."""
BLOCK_OBJECTS = 10
"""Maximum number of values in one element for packing four elements per iteration."""
MOST_OBJECTS = 64
"""Maximum number of messages, strings and times in one element for a comprehension."""


class _Shared(NamedTuple):
    """Names of the locals that all elements of an array share: the string, its bytes, their length."""

    last: str
    text: str
    length: str


class _Part(NamedTuple):
    """Source of a comprehension over elements.

    Attributes:
        codes: struct codes.
        values: Expressions of the values.
        loops: `for name in [value]` for nested messages, which Python compiles to assignments of the
            comprehension's own locals. Variables of the enclosing function are cells, which are slower.
    """

    codes: list[str]
    values: list[str]
    loops: list[str]

    def text(self) -> tuple[str, str]:
        return ", ".join(self.values), " ".join(self.loops)


class ComprehensionWriter:
    """The part of the encode writer that packs whole arrays."""

    src: Source

    if TYPE_CHECKING:

        def encoded(self, value: str) -> str: ...
        def struct_for(self, codes: list[str], lengths: list[str], pack: str) -> None: ...

    def all_at_once(self, element: Layout, items: str, string: bool) -> None:
        """Pack all elements with one list comprehension; struct.error if their string objects differ.

        After struct.error `parts` is unchanged, and the following loop packs the elements.
        """
        src = self.src
        src.indent(f"if len({items}) >= {AT_ONCE_FROM}:")
        src.indent("try:")
        rest = "()"
        if string:
            self._with_string(element, items)
        elif fits_in_fours(element):
            rest = f"{items}[len({items})&-4:]"
            every, (names, pack, values) = src.fresh("t"), self._four(element)
            src.line(f"{every} = iter({items}[:len({items})&-4])")
            fours = ", ".join([every] * 4)
            src.line(f"parts += [{pack}({values}) for {names} in zip({fours})]")
        else:
            var = src.fresh("v")
            part = self._walk(element.fields, var)
            values, loops = part.text()
            pack = src.struct(part.codes, "pack")
            src.line(f"parts += [{pack}({values}) for {var} in {items} {loops}]")
        src.line(f"{items} = {rest}")
        src.dedent()
        src.indent(f"except {src.constant(struct.error)}:")
        src.line("pass")
        src.dedent()
        src.dedent()

    def in_fours(self, element: Layout, items: str) -> None:
        """Pack small elements in fours; the rest remains in `items`."""
        src = self.src
        size, end, (names, pack, values) = src.fresh("n"), src.fresh("n"), self._four(element)
        src.line(f"{size} = len({items})")
        src.line(f"{end} = 4")
        src.indent(f"while {end} <= {size}:")
        src.line(f"{names} = {items}[{end}-4:{end}]")
        src.line(f"parts.append({pack}({values}))")
        src.line(f"{end} += 4")
        src.dedent()
        src.line(f"{items} = {items}[{end}-4:] if {size}&3 else ()")

    def _four(self, element: Layout) -> tuple[str, str, str]:
        """Four names, the struct for four elements and their values."""
        names = [self.src.fresh("v") for _ in range(4)]
        parts = [self._walk(element.fields, name) for name in names]
        pack = self.src.struct([code for part in parts for code in part.codes], "pack")
        return ", ".join(names), pack, ", ".join(value for part in parts for value in part.values)

    def _with_string(self, element: Layout, items: str) -> None:
        src = self.src
        shared = _Shared(src.fresh("r"), src.fresh("s"), src.fresh("n"))
        src.line(f"{shared.last} = {items}[0].{_path_of_string(element)}")
        src.line(f"{shared.text} = {self.encoded(shared.last)}")
        # The length is also the same: pack both as one value.
        src.line(f"{shared.text} = {src.struct(['I'], 'pack')}(len({shared.text})) + {shared.text}")
        src.line(f"{shared.length} = len({shared.text})")
        place = 1 + next(i for i, field in enumerate(element.fields) if _has_string(field))
        var, before, pack = src.fresh("v"), src.fresh("v"), src.fresh("k")
        head = self._walk(element.fields[:place], var, shared)
        # Direct fields of the tail need `ended`: `before` is rebound before they are read.
        own = any(field.layout is None for field in element.fields[place:])
        ended = src.fresh("v") if own else before
        tail = self._walk(element.fields[place:], ended)
        outer = f"for {pack}, {shared.text}, {shared.last} in [({pack}, {shared.text}, {shared.last})]"
        if not _aligned(head.codes, tail.codes):
            every = self._walk(element.fields, var, shared)
            values, loops = every.text()
            self.struct_for(every.codes, [shared.length], pack)
            src.line(f"parts += [{pack}({values}) {outer} for {var} in {items} {loops}]")
            return
        # Pack the end of each element with the beginning of the next: doubles are aligned before a string,
        # but not after it, and aligned ones take a third of the time.
        first = src.fresh("k")
        (head_values, head_loops), (tail_values, tail_loops) = head.text(), tail.text()
        self.struct_for(head.codes, [shared.length], first)
        self.struct_for([*tail.codes, *head.codes], [shared.length], pack)
        begin = outer.replace(pack, first)
        last = src.struct(tail.codes, "pack")
        src.line(f"parts += [{first}({head_values}) {begin} for {var} in {items}[:1] {head_loops}] + [")
        src.line(f"    {pack}({tail_values}, {head_values}) {outer} for {before} in {items}[:1]")
        keep = f"for {ended} in [{before}]" if own else ""
        loops = f"{keep} {tail_loops} {head_loops} for {before} in [{var}]"
        src.line(f"    for {var} in {items}[1:] {loops}] + [")
        src.line(f"    {last}({tail_values}) for {ended} in {items}[-1:] {tail_loops}]")

    def _walk(self, fields: Sequence[FieldLayout], var: str, shared: _Shared | None = None) -> _Part:
        """Collect expressions for the fields of `var`, including nested ones."""
        part = _Part([], [], [])
        for field in fields:
            value = f"{var}.{field.attr}"
            if field.kind == "number":
                part.codes.append("B" if field.code == "?" else field.code)
                part.values.append(value)
            elif field.kind == "time":
                part.codes.extend(field.code)
                part.values.extend((f"{value}.secs", f"{value}.nsecs"))
            elif field.kind == "string":
                assert shared is not None
                part.codes.append("%ds")
                # struct refuses False, the value for another object.
                part.values.append(f"{value} is {shared.last} and {shared.text}")
            else:
                assert field.layout is not None
                inner = self.src.fresh("w")
                below = self._walk(field.layout.fields, inner, shared)
                part.codes.extend(below.codes)
                part.values.extend(below.values)
                part.loops.extend([f"for {inner} in [{value}]", *below.loops])
        return part


def fits_in_fours(element: Layout) -> bool:
    """Whether elements contain only numbers and times and are small enough to be packed in fours."""
    return (
        element.objects <= BLOCK_OBJECTS
        and strings_inside(element) == 0
        and all(field.layout is None for field in element.fields)
    )


def fits_at_once(element: Layout) -> bool:
    """Whether one comprehension can pack elements of this type."""
    return bool(element.min_size) and element.objects <= MOST_OBJECTS and strings_inside(element) in (0, 1)


def _has_string(field: FieldLayout) -> bool:
    return field.kind == "string" or (field.layout is not None and strings_inside(field.layout) == 1)


def _path_of_string(layout: Layout) -> str:
    field = next(field for field in layout.fields if _has_string(field))
    return field.attr if field.layout is None else f"{field.attr}.{_path_of_string(field.layout)}"


def _aligned(head: list[str], tail: list[str]) -> bool:
    """Whether doubles of `tail` are aligned if packed before `head`, which ends with the string."""
    if "d" not in tail or "f" in (*head, *tail) or head[-1] != "%ds":
        return False
    form = merge_codes([*tail, *head[:-1]])
    return struct.calcsize(form[1:]) == struct.calcsize(form)
