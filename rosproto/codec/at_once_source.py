"""Writes how a long array of messages is packed by one list comprehension.

That is a tenth faster than a loop. It takes elements of numbers, times and at most one string, which must
be the same object in all of them: so it is in every received Path, and where a program sets one frame_id.
"""

from __future__ import annotations

from rosproto.codec.guesses import strings_inside
from rosproto.codec.layout import Layout
from rosproto.codec.source import Source
from rosproto.records import NamedTuple

__all__ = ["AtOnceWriter", "fits_at_once"]

AT_ONCE_FROM = 32
"""Elements from which packing all in one comprehension pays."""
MOST_OBJECTS = 64
"""Messages, strings and times in an element for which it is written."""


class AtOnceWriter:
    """The part of the encode writer that does this."""

    src: Source
    pack: str
    lengths: list[str]
    codes: list[str]

    def encoded(self, value: str) -> str:
        raise NotImplementedError

    def chosen_struct(self, *, always: bool = False) -> str:
        raise NotImplementedError

    def all_at_once(self, element: Layout, items: str, string: bool) -> None:
        """One list comprehension if the string is the same object in all elements; else `_other` raises.

        In that case nothing was added to `parts`, and the loop that follows does the work.
        """
        src = self.src
        shared = _Shared(src.fresh("r"), src.fresh("s"), src.fresh("n"), src.fresh("k"))
        parts = _Parts([], [], [f"for {(var := src.fresh('v'))} in {items}"])
        where = self.walk(element, var, shared, parts)
        codes = parts.codes
        src.indent(f"if len({items}) >= {AT_ONCE_FROM}:")
        src.indent("try:")
        if string:
            first = f"{items}[0].{where}"
            src.line(f"{shared.last} = {first}")
            src.line(f"{shared.text} = {self.encoded(shared.last)}")
            # Its length is the same too: both go in as one value.
            src.line(f"{shared.text} = {src.struct(['I'], 'pack')}(len({shared.text})) + {shared.text}")
            src.line(f"{shared.length} = len({shared.text})")
            self.pack, self.lengths, self.codes = shared.pack, [shared.length], codes
            self.chosen_struct(always=True)
            self.lengths, self.codes = [], []
            names = f"{shared.pack}, {shared.text}, {shared.last}"
            parts.loops.insert(0, f"for {names} in [({names})]")
            pack = shared.pack
        else:
            pack = src.struct(codes, "pack")
        src.line(f"parts += [{pack}({', '.join(parts.values)}) {' '.join(parts.loops)}]")
        src.line(f"{items} = ()")
        src.dedent()
        src.indent(f"except {src.constant(_OtherStringError)}:")
        src.line("pass")
        src.dedent()
        src.dedent()

    def walk(self, layout: Layout, var: str, shared: _Shared, parts: _Parts) -> str:
        """Collect an element's values as expressions; gives the path of the string.

        Nested messages, and what all elements share, are named by `for name in [value]`, which Python
        compiles to an assignment: the only kind of local that a comprehension has for itself. Others are
        cells that it shares with the function around it, and every use takes a step more.
        """
        path = ""
        for field in layout.fields:
            value = f"{var}.{field.attr}"
            if field.kind == "number":
                parts.codes.append("B" if field.code == "?" else field.code)
                parts.values.append(value)
            elif field.kind == "string":
                parts.codes.append("%ds")
                same = f"{shared.text} if {value} is {shared.last} else {self.src.constant(_other)}()"
                parts.values.append(same)
                path = field.attr
            else:
                inner = self.src.fresh("w")
                parts.loops.append(f"for {inner} in [{value}]")
                if field.layout is None:
                    parts.codes.extend(field.code)
                    parts.values.extend((f"{inner}.secs", f"{inner}.nsecs"))
                else:
                    below = self.walk(field.layout, inner, shared, parts)
                    path = f"{field.attr}.{below}" if below else path
        return path


def fits_at_once(element: Layout) -> bool:
    """Whether elements of this type can be packed so."""
    return bool(element.min_size) and element.objects <= MOST_OBJECTS and strings_inside(element) in (0, 1)


class _Shared(NamedTuple):
    """Names of the locals for the string that all elements of an array share."""

    last: str
    text: str
    length: str
    pack: str


class _Parts(NamedTuple):
    """What the comprehension is written from."""

    codes: list[str]
    values: list[str]
    loops: list[str]


class _OtherStringError(Exception):
    """Elements have different strings."""


def _other() -> bytes:
    raise _OtherStringError
