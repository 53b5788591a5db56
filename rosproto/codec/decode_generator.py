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
from functools import cache
from itertools import repeat, starmap
from typing import TYPE_CHECKING, Any

from rosproto.codec import arrays
from rosproto.codec.collector_pause import pause, resume
from rosproto.codec.generated_source import (
    Source,
    flat_codes,
    length_offsets,
    strings_inside,
)
from rosproto.codec.layout import DTYPES, FieldLayout, Layout
from rosproto.codec.value_style import ValueStyle

if TYPE_CHECKING:
    import numpy as np

ERRORS = (struct.error, ValueError, TypeError, AttributeError, OverflowError)
MAX_LOOP_DEPTH = 3
"""Deeper arrays of messages are decoded by a separate function (Python allows 20 nested blocks)."""
MAX_STATEMENTS = 3000
PAUSE_FROM = 2000
"""Minimum number of objects in one array for pausing the garbage collector."""
STREAM_FROM = 5
"""Minimum number of objects in one element for making them in C with `zip`, a sixth faster."""
BLOCK_OBJECTS = 10
"""Maximum number of objects in one element for handling four elements at once."""
PROBE_FROM = 3
"""Minimum number of elements for assuming that all strings are as long as the first element's."""


def decode_function(
    layout: Layout,
    value_style: ValueStyle,
    maker: Callable[[str], Callable[[], object]],
    *,
    general: bool = False,
    partial: bool = False,
    fail: Callable[..., object] | None = None,
    other: Callable[..., object] | None = None,
) -> Callable[..., Any]:
    """Generate `decode(b, o, e) -> message`.

    Args:
        layout: The type.
        value_style: Python values to make.
        maker: Returns a fast constructor for a type name, also for "time" and "duration".
        general: Accept any buffer and any text, slower; else bytes (or bytearray if no views are made).
        partial: Return (message, next offset) without checking the end or catching errors.
        fail: Called with the arguments and the exception on errors.
        other: Called with the arguments for buffers that are not bytes.
    """
    writer = _DecodeWriter(layout, value_style, maker, general=general)
    writer.write(partial=partial, fail=fail, other=other)
    return writer.src.compile("decode", layout.spec.name)


class _DecodeWriter:
    """Writes the function. Fixed-size fields up to the next field of variable size are read with one struct.

    The current position is the value of the local `base` plus `delta` bytes.
    """

    def __init__(
        self,
        layout: Layout,
        value_style: ValueStyle,
        maker: Callable[[str], Callable[[], object]],
        *,
        general: bool,
    ) -> None:
        self.layout = layout
        self.value_style = value_style
        self.maker = maker
        self.general = general
        self.views = value_style.views and layout.has_numbers
        self.src = Source("def decode(b, o, e):")
        self.src.globals["ValueError"] = ValueError
        self.src.globals["range"] = range
        self.src.globals["len"] = len
        self.base = "o"
        self.delta = 0
        self.codes: list[str] = []
        self.targets: list[str] = []
        self.run = 0
        self.loops = 0
        self.statements = 0
        self.makers: dict[str, str] = {}
        self.string_targets: list[tuple[str, str]] = []

    def create(self, name: str) -> str:
        known = self.makers.get(name)
        if known is None:
            known = self.makers[name] = self.src.constant(self.maker(name), "c")
        return known

    def stream(self, name: str) -> str:
        """An endless iterator of empty instances; it has no state, so all threads share it."""
        return self.src.constant(starmap(self.maker(name), repeat(())), "e")

    def at(self, extra: int = 0) -> str:
        total = self.delta + extra
        return f"{self.base}+{total}" if total else self.base

    # -- runs of fixed-size fields -----------------------------------------------------------

    def add(self, code: str, size: int, target: str) -> None:
        self.codes.append(code)
        self.targets.append(target)
        self.run += size

    def skip(self, size: int) -> None:
        if size:
            self.codes.append(f"{size}x")
            self.run += size

    def flush(self) -> None:
        """Read the collected run with one struct."""
        if self.targets:
            while self.codes[-1].endswith("x"):
                self.codes.pop()
            comma = "," if len(self.targets) == 1 else ""
            unpack = self.src.struct(self.codes, "unpack_from")
            self.src.line(f"{', '.join(self.targets)}{comma} = {unpack}(b, {self.at()})")
        self.delta += self.run
        self.codes, self.targets, self.run = [], [], 0

    def count(self) -> str:
        """Read a count, which ends the run; return its local."""
        n = self.src.fresh("n")
        self.add("I", 4, n)
        self.flush()
        return n

    def rebase(self) -> None:
        """Set `i` to the current position."""
        if self.base != "i" or self.delta:
            self.src.line(f"i = {self.at()}")
        self.base, self.delta = "i", 0

    def text(self, expression: str) -> str:
        if not self.general:
            return f"{expression}.decode()"
        self.src.globals["str"] = str
        return f"str({expression}, 'utf-8', {self.src.constant(self.value_style.text_errors)})"

    def number_array(self, field: FieldLayout, n: str, where: str) -> str:
        src = self.src
        if self.value_style.views:
            import numpy as np

            if field.code == "?":
                return f"{src.constant(arrays.bool_view)}(b, {n}, {where})"
            dtype = src.constant(shared_dtype(DTYPES[field.base]), "t")
            return f"{src.constant(np.frombuffer, 'f')}(b, {dtype}, {n}, {where})"
        if field.code == "B":
            return f"{src.constant(plain_bytes)}(b, {n}, {where})"
        code = "B" if field.code == "?" else field.code
        unpacked = f"{src.constant(struct.unpack_from)}('<%d{code}' % {n}, b, {where})"
        return f"{src.constant(arrays.plain_bools)}({unpacked})" if field.code == "?" else unpacked

    def flat_targets(
        self,
        element: Layout,
        lengths: list[str],
        texts: list[str],
        streams: list[tuple[str, str]] | None = None,
    ) -> tuple[str, str]:
        """Create one element's objects; return its variable and the targets of the unpacking.

        Strings are unpacked into locals, whose names are added to `lengths` and `texts`; `string_targets`
        maps them to fields. With a list `streams`, objects are not created: their variables and streams are
        added to it.
        """
        targets: list[str] = []
        self.string_targets.clear()

        def create(prefix: str, name: str, target: str = "") -> str:
            var = self.src.fresh(prefix)
            if streams is None:
                made = f"{self.create(name)}()"
                self.src.line(f"{var} = {target} = {made}" if target else f"{var} = {made}")
            else:
                streams.append((var, self.stream(name)))
                if target:
                    self.src.line(f"{target} = {var}")
            return var

        def walk(layout: Layout, var: str) -> None:
            for field in layout.fields:
                target = f"{var}.{field.attr}"
                if field.kind == "number":
                    targets.append(target)
                elif field.kind == "string":
                    lengths.append(self.src.fresh("n"))
                    texts.append(self.src.fresh("s"))
                    targets.extend((lengths[-1], texts[-1]))
                    self.string_targets.append((target, texts[-1]))
                else:
                    inner = create("m", field.base, target)
                    if field.kind == "time":
                        targets.extend((f"{inner}.secs", f"{inner}.nsecs"))
                    else:
                        assert field.layout is not None
                        walk(field.layout, inner)

        top = create("m", element.spec.name)
        walk(element, top)
        comma = "," if len(targets) == 1 else ""
        return top, ", ".join(targets) + comma

    # -- the function ------------------------------------------------------------------------

    def write(
        self, *, partial: bool, fail: Callable[..., object] | None, other: Callable[..., object] | None
    ) -> None:
        src = self.src
        if other is not None and self.views:
            src.globals["type"], src.globals["bytes"] = type, bytes
            src.indent("if type(b) is not bytes:")
            src.line(f"return {src.constant(other)}(b, o, e)")
            src.dedent()
        if not partial:
            src.indent("try:")
        if self.views and self.general and not partial:
            src.line(f"b = {src.constant(arrays.read_only)}(b)")
        top = src.fresh("m")
        src.line(f"{top} = {self.create(self.layout.spec.name)}()")
        if not partial:
            src.line(f"{top}._connection_header = None")
        self.fields(self.layout, top)
        self.flush()
        if partial:
            src.line(f"return {top}, {self.at()}")
            return
        src.line(f"if {self.at()} != e: raise ValueError")
        src.line(f"return {top}")
        src.dedent()
        src.indent(f"except {src.constant(ERRORS)} as x:")
        src.line(f"return {src.constant(fail)}(b, o, e, x)")
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

    # -- arrays ------------------------------------------------------------------------------

    def array(self, field: FieldLayout, target: str) -> None:
        if field.kind == "number":
            if field.length is None:
                self.numbers(field, target)
            else:
                self.fixed_numbers(field, target)
            return
        if field.length is None:
            n = self.count()
        else:
            self.flush()
            n = str(field.length)
        self.rebase()
        # Before making objects, refuse a count larger than the remaining bytes can hold. (The reference codec
        # decodes elements of no bytes: `Layout.sparse`.)
        self.src.line(f"p = i+{n}*{field.size}")
        self.src.line("if p > e: raise ValueError")
        if field.kind == "string":
            self.strings(n, target)
        elif field.kind == "time":
            self.times(field, target)
        else:
            self.messages(field, n, target)

    def numbers(self, field: FieldLayout, target: str) -> None:
        n = self.count()
        self.src.line(f"p = {self.at()}")
        self.src.line(f"{target} = {self.number_array(field, n, 'p')}")
        self.src.line(f"i = p+{n}*{field.size}" if field.size > 1 else f"i = p+{n}")
        self.base, self.delta = "i", 0

    def fixed_numbers(self, field: FieldLayout, target: str) -> None:
        length = field.length or 0
        if length:
            expression = self.number_array(field, str(length), self.at(self.run))
        else:
            # np.frombuffer refuses an empty buffer; a message with only this field is one.
            expression = self.number_array(field, "0", "0").replace("(b,", "(Z,")
            self.src.globals["Z"] = b"\0"
        self.src.line(f"{target} = {expression}")
        self.skip(length * field.size)

    def strings(self, n: str, target: str) -> None:
        src = self.src
        items, q = src.fresh("l"), src.fresh("n")
        src.line(f"{items} = []")
        src.indent(f"for _ in range({n}):")
        src.line(f"{q}, = {src.struct(['I'], 'unpack_from')}(b, i)")
        src.line("p = i+4")
        src.line(f"i = p+{q}")
        src.line(f"{items}.append({self.text('b[p:i]')})")
        src.dedent()
        src.line(f"{target} = {items}")

    def times(self, field: FieldLayout, target: str) -> None:
        src = self.src
        items, var = src.fresh("l"), src.fresh("t")
        src.line(f"{items} = []")
        src.indent(f"for x in {src.struct([field.code], 'iter_unpack')}(b[i:p]):")
        src.line(f"{var} = {self.create(field.base)}()")
        src.line(f"{var}.secs, {var}.nsecs = x")
        src.line(f"{items}.append({var})")
        src.dedent()
        src.line("i = p")
        src.line(f"{target} = {items}")

    # -- arrays of messages ------------------------------------------------------------------

    def messages(self, field: FieldLayout, n: str, target: str) -> None:
        assert field.layout is not None
        src, element = self.src, field.layout
        items = src.fresh("l")
        src.line(f"{items} = []")
        src.line(f"{target} = {items}")
        add = f"{items}.append"  # written out: Python 3.11 has an instruction for list.append
        if not self.loops:
            src.line("g = 0")
            src.line(f"if {n} > {PAUSE_FROM // element.objects}: g = {src.constant(pause)}()")
            src.indent("try:")
        self.loops += 1
        strings = strings_inside(element)
        if strings is None or strings > 4:
            self.element_loop(element, f"range({n})", add)
        elif strings == 0:
            self.fixed_loop(element, items, add)
        else:
            src.indent(f"if {n} >= {PROBE_FROM}:")
            self.probe_loop(element, n, items, add, strings)
            src.dedent()
            self.element_loop(element, f"range({n}-len({items}))", add)
        self.loops -= 1
        if not self.loops:
            src.dedent()
            src.indent("finally:")
            src.line(f"if g: {src.constant(resume)}()")
            src.dedent()

    def element_loop(self, element: Layout, span: str, add: str) -> None:
        """Decode elements one by one; works for all types."""
        src = self.src
        src.indent(f"for _ in {span}:")
        var = src.fresh("m")
        if self.loops > MAX_LOOP_DEPTH or self.statements > MAX_STATEMENTS:
            self.call(element, var)
        else:
            src.line(f"{var} = {self.create(element.spec.name)}()")
            self.fields(element, var)
            self.flush()
        self.rebase()
        src.line(f"{add}({var})")
        src.dedent()

    def fixed_loop(self, element: Layout, items: str, add: str) -> None:
        """Decode elements of numbers and times, up to position p, with one iter_unpack."""
        src = self.src
        if element.objects <= BLOCK_OBJECTS:
            self.blocks(element, items, add)
            return
        top = self.unpacking(element, f"{src.struct(flat_codes(element), 'iter_unpack')}(b[i:p])", [], [])
        src.line(f"{add}({top})")
        src.dedent()
        src.line("i = p")

    def blocks(self, element: Layout, items: str, add: str) -> None:
        """Decode small elements in fours and the rest one by one: loop overhead is a fifth of their cost."""
        src = self.src
        size = element.fixed_size or 0
        codes = flat_codes(element)
        src.line(f"q = p-{4 * size}")
        for condition, count in (("i <= q", 4), ("i != p", 1)):
            src.indent(f"while {condition}:")
            tops, targets = zip(*(self.flat_targets(element, [], []) for _ in range(count)), strict=True)
            names = ", ".join(text.rstrip(",") for text in targets)
            names += "," if "," not in names else ""
            src.line(f"{names} = {src.struct(count * codes, 'unpack_from')}(b, i)")
            src.line(f"{items} += {', '.join(tops)}" if count > 1 else f"{add}({tops[0]})")
            src.line(f"i += {count * size}")
            src.dedent()

    def unpacking(self, element: Layout, tuples: str, lengths: list[str], texts: list[str]) -> str:
        """Open the loop over `tuples`, one per element; return the element's variable."""
        src = self.src
        mark, head = src.fresh("x"), src.indent_later()
        streams: list[tuple[str, str]] | None = [] if element.objects >= STREAM_FROM else None
        top, targets = self.flat_targets(element, lengths, texts, streams)
        src.line(f"{targets} = {mark}")
        if streams:
            src.globals["zip"] = zip
            names, sources = zip(*streams, strict=True)
            head(f"for {mark}, {', '.join(names)} in zip({tuples}, {', '.join(sources)}):")
        else:
            head(f"for {mark} in {tuples}:")
        return top

    def probe_loop(self, element: Layout, n: str, items: str, add: str, strings: int) -> None:
        """Decode elements with strings, assuming that all strings are as long as the first element's.

        This holds for every Path and nearly every TFMessage. At the first element with other lengths the loop
        ends, and `element_loop` continues there.
        """
        src = self.src
        codes = flat_codes(element)
        first = [src.fresh("q") for _ in range(strings)]
        before = ""
        for name, offset in zip(first, length_offsets(codes), strict=True):
            src.line(f"{name}, = {src.struct(['I'], 'unpack_from')}(b, i+{offset}{before})")
            before += f"+{name}"
        size = src.fresh("z")
        src.line(f"{size} = {element.min_size}{before}")
        src.line(f"p = i+{n}*{size}")
        src.indent("if p <= e:")
        unpack = src.struct_for(codes, first, "iter_unpack")
        last = [src.fresh("r") for _ in range(strings)]
        done = [src.fresh("v") for _ in range(strings)]
        src.line(f"{' = '.join(last)} = None")
        lengths: list[str] = []
        texts: list[str] = []
        top = self.unpacking(element, f"({unpack})(b[i:p])", lengths, texts)
        differs = " or ".join(f"{a} != {q}" for a, q in zip(lengths, first, strict=True))
        src.line(f"if {differs}: break")
        for (target, text), old, value in zip(self.string_targets, last, done, strict=True):
            # Nearly always the same text in all elements: decoded once.
            src.indent(f"if {text} != {old}:")
            src.line(f"{old} = {text}")
            src.line(f"{value} = {self.text(text)}")
            src.dedent()
            src.line(f"{target} = {value}")
        src.line(f"{add}({top})")
        src.dedent()
        src.line(f"i += {size}*len({items})")
        src.dedent()


def plain_bytes(buffer: memoryview, count: int, offset: int) -> bytes:
    return bytes(buffer[offset : offset + count])


@cache
def shared_dtype(name: str) -> np.dtype[np.generic]:
    """One dtype object per name: the encoder compares by identity."""
    import numpy as np

    return np.dtype(name)
