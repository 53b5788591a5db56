"""Generates the function that fills a new message with default values.

Numbers are 0, strings empty, times zero, nested messages and elements of `T[N]` have their own defaults.
Arrays of messages, strings and times are lists. Arrays of numbers are writable numpy arrays, empty or of
zeros, so that `msg.pose.covariance[0] = 0.1` works and `msg.ranges` is an array before sending and after
receiving; lists may be assigned. (In the rospy value style they are lists, and bytes for uint8[] and char[],
as in genpy.)
"""

from __future__ import annotations

from collections.abc import Callable

from rosproto.codec.decode_generator import MAX_STATEMENTS
from rosproto.codec.generated_source import Source
from rosproto.codec.layout import DTYPES, FieldLayout, Layout
from rosproto.codec.value_style import ValueStyle


def fill_function(
    layout: Layout, value_style: ValueStyle, maker: Callable[[str], Callable[[], object]]
) -> Callable[[object], None]:
    """Generate `fill(message)`."""
    writer = _FillWriter(value_style, maker)
    writer.fields(layout, "m")
    writer.src.line("m._connection_header = None")
    function: Callable[[object], None] = writer.src.compile("fill", layout.spec.name)
    return function


class _FillWriter:
    def __init__(self, value_style: ValueStyle, maker: Callable[[str], Callable[[], object]]) -> None:
        self.value_style = value_style
        self.maker = maker
        self.src = Source("def fill(m):")
        self.src.globals["range"] = range
        self.statements = 0

    def create(self, name: str) -> str:
        return self.src.constant(self.maker(name), "c")

    def fields(self, layout: Layout, var: str) -> None:
        for field in layout.fields:
            self.statements += 1
            self.field(field, f"{var}.{field.attr}")

    def field(self, field: FieldLayout, target: str) -> None:
        if field.is_array and field.kind == "number":
            self.src.line(f"{target} = {self.numbers(field)}")
        elif field.is_array:
            self.items(field, target)
        else:
            self.one(field, target)

    def one(self, field: FieldLayout, target: str) -> None:
        if field.kind == "number":
            default = {"?": "False", "f": "0.0", "d": "0.0"}.get(field.code, "0")
            self.src.line(f"{target} = {default}")
        elif field.kind == "string":
            self.src.line(f"{target} = ''")
        else:
            var = self.src.fresh("m")
            self.src.line(f"{var} = {target} = {self.create(field.base)}()")
            self.inner(field, var)

    def inner(self, field: FieldLayout, var: str) -> None:
        if field.layout is None:
            self.src.line(f"{var}.secs = {var}.nsecs = 0")
        elif self.statements > MAX_STATEMENTS:
            function = fill_function(field.layout, self.value_style, self.maker)
            self.src.line(f"{self.src.constant(function, 'f')}({var})")
        else:
            self.fields(field.layout, var)

    def items(self, field: FieldLayout, target: str) -> None:
        if not field.length:
            self.src.line(f"{target} = []")
        elif field.kind == "string":
            self.src.line(f"{target} = [''] * {field.length}")
        else:
            items = self.src.fresh("l")
            self.src.line(f"{items} = {target} = []")
            if field.layout is None:
                make: Callable[[], object] = (
                    self.value_style.time if field.base == "time" else self.value_style.duration
                )
            else:
                make = _factory(
                    self.maker(field.base), fill_function(field.layout, self.value_style, self.maker)
                )
            self.src.line(f"for _ in range({field.length}): {items}.append({self.src.constant(make, 'd')}())")

    def numbers(self, field: FieldLayout) -> str:
        src = self.src
        if self.value_style.views:
            import numpy as np

            return f"{src.constant(np.zeros, 'z')}({field.length or 0}, '{DTYPES[field.base]}')"
        if field.code == "B":
            return src.constant(bytes(field.length or 0), "b")
        zero = {"?": "False", "f": "0.0", "d": "0.0"}.get(field.code, "0")
        return f"[{zero}] * {field.length}" if field.length else "[]"


def _factory(maker: Callable[[], object], fill: Callable[[object], None]) -> Callable[[], object]:
    def make() -> object:
        message = maker()
        fill(message)
        return message

    return make
