"""Generates code that decodes arrays: numbers as views, other elements as lists, one by one or in blocks."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosproto.codec.collector_pause import pause, resume
from rosproto.codec.fixed_fields_generator import FixedFieldsWriter
from rosproto.codec.generated_source import flat_codes, length_offsets, merge_codes, strings_inside, structs
from rosproto.codec.layout import FieldLayout, Layout

MAX_LOOP_DEPTH = 3
"""Deeper arrays of messages are decoded by a separate function (Python allows 20 nested blocks)."""
MAX_STATEMENTS = 3000
PAUSE_FROM = 2000
"""Minimum number of objects in one array for pausing the garbage collector."""
STREAM_FROM = 5
"""Minimum number of objects in one element for making them in C with `zip`, a sixth faster."""
BLOCK_OBJECTS = 10
"""Maximum number of objects in one element for decoding four elements per iteration."""
PROBE_FROM = 3
"""Minimum number of elements for assuming that all strings are as long as the first element's."""


class ArrayWriter(FixedFieldsWriter):
    """Adds arrays; the subclass adds single fields and nested messages."""

    if TYPE_CHECKING:

        def fields(self, layout: Layout, var: str) -> None: ...
        def call(self, layout: Layout, target: str) -> None: ...

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
        cache = src.constant(structs(merge_codes(codes), "iter_unpack"), "j")
        key = first[0] if strings == 1 else f"({', '.join(first)})"
        last = [src.fresh("r") for _ in range(strings)]
        done = [src.fresh("v") for _ in range(strings)]
        src.line(f"{' = '.join(last)} = None")
        lengths: list[str] = []
        texts: list[str] = []
        top = self.unpacking(element, f"{cache}({key})(b[i:p])", lengths, texts)
        differs = " or ".join(f"{a} != {q}" for a, q in zip(lengths, first, strict=True))
        src.line(f"if {differs}: break")
        for (target, text), old, value in zip(self.string_targets, last, done, strict=True):
            src.indent(f"if {text} != {old}:")
            src.line(f"{old} = {text}")
            src.line(f"{value} = {self.text(text)}")
            src.dedent()
            src.line(f"{target} = {value}")
        src.line(f"{add}({top})")
        src.dedent()
        src.line(f"i += {size}*len({items})")
        src.dedent()
