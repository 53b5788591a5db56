"""Writes how a long array of messages is packed by one list comprehension.

That is a tenth faster than a loop. It takes elements of numbers, times and at most one string, which must
be the same object in all of them: so it is in every received Path, and where a program sets one frame_id.
"""

from __future__ import annotations

from typing import NamedTuple

from rosproto.codec.layout import Layout
from rosproto.codec.source import Source

__all__ = ["AtOnceWriter", "has_values"]

AT_ONCE_FROM = 32
"""Elements from which packing all in one comprehension pays."""


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
        var, shared = src.fresh("v"), _Shared(src.fresh("r"), src.fresh("s"), src.fresh("n"), src.fresh("k"))
        codes: list[str] = []
        values: list[str] = []
        where = self.walk(element, var, var, shared, codes, values)
        src.indent(f"if len({items}) >= {AT_ONCE_FROM}:")
        src.indent("try:")
        if string:
            first = f"{items}[0].{where}"
            src.line(f"{shared.last} = {first}")
            src.line(f"{shared.text} = {self.encoded(shared.last)}")
            src.line(f"{shared.length} = len({shared.text})")
            self.pack, self.lengths, self.codes = shared.pack, [shared.length], codes
            pack = self.chosen_struct(always=True)
            self.lengths, self.codes = [], []
        else:
            pack = src.struct(codes, "pack")
        src.line(f"parts += [{pack}({', '.join(values)}) for {var} in {items}]")
        src.line(f"{items} = ()")
        src.dedent()
        src.indent(f"except {src.constant(_OtherStringError)}:")
        src.line("pass")
        src.dedent()
        src.dedent()

    def walk(
        self, layout: Layout, source: str, name: str, shared: _Shared, codes: list[str], values: list[str]
    ) -> str:
        """Collect an element's values as expressions; nested messages are named where they are first used.

        Gives the path of the string.
        """
        path = ""
        for field in layout.fields:
            value, source = f"{source}.{field.attr}", name
            if field.kind == "number":
                codes.append("B" if field.code == "?" else field.code)
                values.append(value)
            elif field.kind == "string":
                codes.extend(("I", "%ds"))
                same = f"{shared.text} if {value} is {shared.last} else {self.src.constant(_other)}()"
                values.extend((shared.length, same))
                path = field.attr
            else:
                inner = self.src.fresh("w")
                value = f"({inner}:={value})"
                if field.layout is None:
                    codes.extend(field.code)
                    values.extend((f"{value}.secs", f"{inner}.nsecs"))
                else:
                    below = self.walk(field.layout, value, inner, shared, codes, values)
                    path = f"{field.attr}.{below}" if below else path
        return path


def has_values(layout: Layout) -> bool:
    """Whether every message inside has a value, at which `walk` can give the message its name."""
    return bool(layout.min_size) and all(f.layout is None or has_values(f.layout) for f in layout.fields)


class _Shared(NamedTuple):
    """Names of the locals for the string that all elements of an array share."""

    last: str
    text: str
    length: str
    pack: str


class _OtherStringError(Exception):
    """Elements have different strings."""


def _other() -> bytes:
    raise _OtherStringError
