"""Generates the decode function of one type.

Example for geometry_msgs/Vector3Stamped:

    def decode(b, o, e):
        try:
            m1 = C1(); m2 = C2(); m1.header = m2; ...
            m2.seq, m3.secs, m3.nsecs, n4 = U5(b, o)       # a run of fixed-size fields, one struct
            p = o+16; i = p+n4
            m2.frame_id = b[p:i].decode()
            m6.x, m6.y, m6.z = U7(b, i)
            if i+24 != e: raise ValueError
            return m1
        except ERRORS as x:
            return fail(b, o, e, x)                        # names the field, or decodes unusual input

Nested messages are flattened into the same function, and a fixed array in a run is skipped with pad
bytes. Fields are not checked one by one: a wrong length raises struct.error or numpy's ValueError, or fails
the comparison at the end. Only counts of Python objects are compared with the remaining bytes first.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import Any

from rosproto.codec import arrays
from rosproto.codec.array_generator import MAX_STATEMENTS, ArrayWriter
from rosproto.codec.layout import FieldLayout, Layout
from rosproto.codec.value_style import ValueStyle

ERRORS = (struct.error, ValueError, TypeError, AttributeError, OverflowError)


def decode_function(
    layout: Layout,
    value_style: ValueStyle,
    maker: Callable[[str], Any],
    *,
    general: bool = False,
    partial: bool = False,
    whole: bool = False,
    fail: Callable[..., Any] | None = None,
    other: Callable[..., Any] | None = None,
) -> Callable[..., Any]:
    """Generate `decode(b, o, e) -> message`.

    Args:
        layout: The type.
        value_style: Python values to make.
        maker: Returns a fast constructor for a type name, also for "time" and "duration".
        general: Accept any buffer and any text, slower; else bytes (or bytearray if no views are made).
        partial: Return (message, next offset) without checking the end or catching errors.
        whole: Generate `decode(b) -> message` instead: the buffer is exactly one message.
        fail: Called with the arguments and the exception on errors.
        other: Called with the arguments for buffers that are not bytes.
    """
    writer = _DecodeWriter(layout, value_style, maker, general=general, whole=whole)
    writer.write(partial=partial, fail=fail, other=other)
    return writer.src.compile("decode", layout.spec.name)


class _DecodeWriter(ArrayWriter):
    # -- the function ------------------------------------------------------------------------

    def write(
        self, *, partial: bool, fail: Callable[..., Any] | None, other: Callable[..., Any] | None
    ) -> None:
        src = self.src
        arguments = "b" if self.whole else "b, o, e"
        if other is not None and (self.views or (self.whole and not self.exact)):
            src.globals["type"], src.globals["bytes"] = type, bytes
            src.indent("if type(b) is not bytes:")
            src.line(f"return {src.constant(other)}({arguments})")
            src.dedent()
        if not partial:
            src.indent("try:")
        if self.views and self.general and not partial:
            src.line(f"b = {src.constant(arrays.read_only)}(b)")
        if self.whole and not self.exact:
            src.line("e = len(b)")
        top = src.fresh("m")
        src.line(f"{top} = {self.create(self.layout.spec.name)}()")
        if not partial:
            src.line(f"{top}._connection_header = None")
        self.fields(self.layout, top)
        self.flush()
        if partial:
            src.line(f"return {top}, {self.at()}")
            return
        if not self.exact:
            src.line(f"if {self.at()} != e: raise ValueError")
        src.line(f"return {top}")
        src.dedent()
        src.indent(f"except {src.constant(ERRORS)} as x:")
        src.line(f"return {src.constant(fail)}({arguments}, x)")
        src.dedent()

    # -- fields ------------------------------------------------------------------------------

    def fields(self, layout: Layout, var: str) -> None:
        for field in layout.fields:
            self.statements += 1
            target = f"{var}.{field.attr}"
            if field.is_array:
                self.array(field, target)
            elif field.kind == "number":
                self.add(field.code, field.size, target)
            elif field.kind == "string":
                self.string(target)
            elif field.kind == "time":
                self.time(field, target)
            else:
                self.message(field, target)

    def string(self, target: str) -> None:
        n = self.count()
        self.src.line(f"p = {self.at()}")
        self.src.line(f"i = p+{n}")
        self.base, self.delta = "i", 0
        self.src.line(f"{target} = {self.text('b[p:i]')}")

    def time(self, field: FieldLayout, target: str) -> None:
        var = self.src.fresh("t")
        self.src.line(f"{var} = {target} = {self.create(field.base)}()")
        self.add(field.code[0], 4, f"{var}.secs")
        self.add(field.code[1], 4, f"{var}.nsecs")

    def message(self, field: FieldLayout, target: str) -> None:
        assert field.layout is not None
        if self.statements > MAX_STATEMENTS:
            self.call(field.layout, target)
            return
        var = self.src.fresh("m")
        self.src.line(f"{var} = {target} = {self.create(field.base)}()")
        self.fields(field.layout, var)

    def call(self, layout: Layout, target: str) -> None:
        """Call a separate function for a nested message."""
        self.flush()
        function = decode_function(layout, self.value_style, self.maker, general=self.general, partial=True)
        self.src.line(f"{target}, i = {self.src.constant(function, 'd')}(b, {self.at()}, e)")
        self.base, self.delta = "i", 0
