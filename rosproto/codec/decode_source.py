"""Writes the decode function of one type.

The shape of what comes out, for geometry_msgs/Vector3Stamped:

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
            return fail(b, o, e, x)                        # finds the field, or decodes the odd cases

Nested messages are flattened into the same function, and a fixed array in a run is skipped with pad
bytes. Nothing is checked per field: a wrong length ends in struct.error, numpy's ValueError, or the
comparison at the end; only counts of Python objects are compared with the bytes left beforehand.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from rosproto.codec import arrays, pause
from rosproto.codec.layout import DTYPES, FieldLayout, Layout
from rosproto.codec.source import Source, merge_codes, quickest

if TYPE_CHECKING:
    from rosproto.codec.flavour import Flavour

__all__ = ["ERRORS", "decode_function"]

ERRORS = (struct.error, ValueError, TypeError, AttributeError, OverflowError)
MAX_LOOP_DEPTH = 3
"""Deeper arrays of messages are decoded by a function of their own (Python allows 20 nested blocks)."""
MAX_STATEMENTS = 3000
PAUSE_FROM = 2000
"""Objects in one array from which switching the collector off pays."""
PROBE_FROM = 3
"""Elements from which guessing that all strings are as long as the first one's pays."""


LEARN_AT_MOST = 4096
"""Messages of unforeseen lengths after which a type is taken for one whose lengths never repeat."""
LEARN_SIZES = 8192
"""Bytes of a message up to which the struct for its size is remembered."""


def decode_function(
    layout: Layout,
    flavour: Flavour,
    maker: Callable[[str], Any],
    *,
    general: bool = False,
    partial: bool = False,
    fail: Callable[..., Any] | None = None,
    other: Callable[..., Any] | None = None,
) -> Callable[..., Any]:
    """Generate `decode(b, o, e) -> message`.

    Args:
        layout: The type.
        flavour: Which values to make.
        maker: Gives a cheap creator of instances for a type name ("time" and "duration" too).
        general: Any buffer and any text, slower; else bytes (or bytearray when no views are made).
        partial: Return (message, next offset), check no end, catch nothing.
        fail: Called with (b, o, e, exception) when anything is wrong.
        other: The general function, for buffers that are not bytes.
    """
    writer = _DecodeWriter(layout, flavour, maker, general=general)
    writer.write(partial=partial, fail=fail, other=other)
    return writer.src.compile("decode", layout.spec.name)


class _DecodeWriter:
    def __init__(
        self, layout: Layout, flavour: Flavour, maker: Callable[[str], Any], *, general: bool
    ) -> None:
        self.layout = layout
        self.flavour = flavour
        self.maker = maker
        self.general = general
        self.views = flavour.views and layout.has_numbers
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
        self.string_targets: list[tuple[str, str]] = []
        self.view_targets: list[tuple[str, str]] = []
        self.lengths: list[str] = []

    # -- the frame ---------------------------------------------------------------------------

    def write(
        self, *, partial: bool, fail: Callable[..., Any] | None, other: Callable[..., Any] | None
    ) -> None:
        src = self.src
        if self.views and other is not None:
            src.globals["type"], src.globals["bytes"] = type, bytes
            src.indent("if type(b) is not bytes:")
            src.line(f"return {src.constant(other)}(b, o, e)")
            src.dedent()
        if not partial:
            src.indent("try:")
        if self.views and self.general and not partial:
            src.line(f"b = {src.constant(arrays.read_only)}(b)")
        learn = "" if partial or self.general else self.known_size()
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
        if learn:
            src.line(f"{learn}(e-o, ({', '.join(self.lengths)},))")
        src.line(f"return {top}")
        src.dedent()
        src.indent(f"except {src.constant(ERRORS)} as x:")
        src.line(f"return {src.constant(fail)}(b, o, e, x)")
        src.dedent()

    def known_size(self) -> str:
        """For fixed fields and strings: as if this message were like the last one of its size.

        Then one struct reads everything, strings too, and its size has been compared already. The strings'
        lengths are compared afterwards; where they differ the message is decoded in steps. (With a single
        string the guess is always right, but saves nothing.) Gives the name of the function to tell lengths
        to, "" when there is no such way.
        """
        src = self.src
        strings = _strings_only(self.layout, views=self.flavour.views)
        if strings is None or not 2 <= strings <= 4 or self.layout.objects > MAX_STATEMENTS:
            return ""
        get, learn = _sizes(merge_codes(_flat_codes(self.layout)))
        src.line(f"u = {src.constant(get, 'g')}(e-o)")
        src.indent("if u:")
        lengths: list[str] = []
        texts: list[str] = []
        top, targets = self.flat_targets(self.layout, lengths, texts)
        src.line(f"{top}._connection_header = None")
        src.line(f"{targets} = u(b, o)")
        same = " and ".join(f"{n} == len({text})" for n, text in zip(lengths, texts, strict=True))
        src.indent(f"if {same}:")
        for target, text in self.string_targets:
            src.line(f"{target} = {self.text(text)}")
        for target, expression in self.view_targets:
            src.line(f"{target} = {expression}")
        src.line(f"return {top}")
        src.dedent()
        src.dedent()
        return src.constant(learn, "l")

    def create(self, name: str) -> str:
        return self.src.constant(self.maker(name), "c")

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
        """Read a count that ends the run; the position moves behind it."""
        n = self.src.fresh("n")
        self.lengths.append(n)
        self.add("I", 4, n)
        self.flush()
        return n

    def rebase(self) -> None:
        """Make `i` hold the present position."""
        if self.base != "i" or self.delta:
            self.src.line(f"i = {self.at()}")
        self.base, self.delta = "i", 0

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

    def text(self, expression: str) -> str:
        if not self.general:
            return f"{expression}.decode()"
        self.src.globals["str"] = str
        return f"str({expression}, 'utf-8', {self.src.constant(self.flavour.text_errors)})"

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
        """Leave a nested message to a function of its own."""
        self.flush()
        function = decode_function(layout, self.flavour, self.maker, general=self.general, partial=True)
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
        if field.size:
            # Refuse a count that the bytes left cannot hold before any object is made.
            self.src.line(f"if {n}*{field.size} > e-i: raise ValueError")
        if field.kind == "string":
            self.strings(n, target)
        elif field.kind == "time":
            self.times(field, n, target)
        else:
            self.messages(field, n, target)

    def numbers(self, field: FieldLayout, target: str) -> None:
        n = self.count()
        where = self.at()
        if self.delta:
            self.src.line(f"p = {where}")
            where = "p"
        self.src.line(f"{target} = {self.number_array(field, n, where)}")
        self.src.line(f"i = {where}+{n}*{field.size}" if field.size > 1 else f"i = {where}+{n}")
        self.base, self.delta = "i", 0

    def fixed_numbers(self, field: FieldLayout, target: str) -> None:
        length = field.length or 0
        if length:
            expression = self.number_array(field, str(length), self.at(self.run))
        else:
            # np.frombuffer refuses an empty buffer, which is what a message of this field alone is.
            expression = self.number_array(field, "0", "0").replace("(b,", "(Z,")
            self.src.globals["Z"] = b"\0"
        self.src.line(f"{target} = {expression}")
        self.skip(length * field.size)

    def number_array(self, field: FieldLayout, n: str, where: str) -> str:
        src = self.src
        if self.flavour.views:
            import numpy as np

            if field.code == "?":
                return f"{src.constant(arrays.bool_view)}(b, {n}, {where})"
            dtype = src.constant(_dtype(np, DTYPES[field.base]), "t")
            return f"{src.constant(np.frombuffer, 'f')}(b, {dtype}, {n}, {where})"
        if field.code == "B":
            return f"{src.constant(_plain_bytes)}(b, {n}, {where})"
        code = "B" if field.code == "?" else field.code
        unpacked = f"{src.constant(struct.unpack_from)}('<%d{code}' % {n}, b, {where})"
        return f"{src.constant(arrays.plain_bools)}({unpacked})" if field.code == "?" else unpacked

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

    def times(self, field: FieldLayout, n: str, target: str) -> None:
        src = self.src
        items, var = src.fresh("l"), src.fresh("t")
        src.line(f"{items} = []")
        src.line(f"p = i+{n}*8")
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
        src.line(
            f"g = {n} > {PAUSE_FROM // element.objects} and {src.constant(pause.pause)}()"
            if not self.loops
            else "pass"
        )
        if not self.loops:
            src.indent("try:")
        self.loops += 1
        strings = _strings_only(element)
        if strings is None or strings > 4:
            self.element_loop(element, f"range({n})", add)
        elif strings == 0 and element.min_size:
            self.fixed_loop(element, n, add)
        else:
            if strings:
                src.indent(f"if {n} >= {PROBE_FROM}:" if not n.isdigit() or int(n) >= PROBE_FROM else "if 0:")
                self.probe_loop(element, n, items, add, strings)
                src.dedent()
            self.element_loop(element, f"range({n}-len({items}))", add)
        self.loops -= 1
        if not self.loops:
            src.dedent()
            src.indent("finally:")
            src.line(f"if g: {src.constant(pause.resume)}()")
            src.dedent()

    def element_loop(self, element: Layout, span: str, add: str) -> None:
        """One element after the other; right for everything."""
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

    def flat_targets(self, element: Layout, lengths: list[str], texts: list[str]) -> tuple[str, str]:
        """Create one element's objects; give its variable and the targets of the unpacking.

        Strings are unpacked into locals, named in `lengths` and `texts`; where they belong is left in
        `string_targets`, and what fixed arrays are views of in `view_targets`.
        """
        targets: list[str] = []
        self.string_targets.clear()
        self.view_targets.clear()
        position = 0

        def walk(layout: Layout, var: str) -> None:
            nonlocal position
            for field in layout.fields:
                target = f"{var}.{field.attr}"
                if field.is_array:
                    where = "+".join(["o", *lengths, str(position)])
                    self.view_targets.append((target, self.number_array(field, str(field.length), where)))
                    position += field.min_size
                    continue
                position += field.min_size if field.layout is None else 0
                if field.kind == "number":
                    targets.append(target)
                elif field.kind == "string":
                    lengths.append(self.src.fresh("n"))
                    texts.append(self.src.fresh("s"))
                    targets.extend((lengths[-1], texts[-1]))
                    self.string_targets.append((target, texts[-1]))
                else:
                    inner = self.src.fresh("m")
                    self.src.line(f"{inner} = {target} = {self.create(field.base)}()")
                    if field.kind == "time":
                        targets.extend((f"{inner}.secs", f"{inner}.nsecs"))
                    else:
                        assert field.layout is not None
                        walk(field.layout, inner)

        top = self.src.fresh("m")
        self.src.line(f"{top} = {self.create(element.spec.name)}()")
        walk(element, top)
        comma = "," if len(targets) == 1 else ""
        return top, ", ".join(targets) + comma

    def fixed_loop(self, element: Layout, n: str, add: str) -> None:
        """Elements of numbers and times only: one iter_unpack over the whole run."""
        src = self.src
        src.line(f"p = i+{n}*{element.fixed_size}")
        mark = src.fresh("x")
        src.indent(f"for {mark} in {src.struct(_flat_codes(element), 'iter_unpack')}(b[i:p]):")
        top, targets = self.flat_targets(element, [], [])
        src.line(f"{targets} = {mark}")
        src.line(f"{add}({top})")
        src.dedent()
        src.line("i = p")

    def probe_loop(self, element: Layout, n: str, items: str, add: str, strings: int) -> None:
        """Elements with strings: as if every element's strings were as long as the first one's.

        That is so for every Path and nearly every TFMessage. Where it is not, the loop ends early and
        `element_loop` continues at that element.
        """
        src = self.src
        codes = _flat_codes(element)
        first = [src.fresh("q") for _ in range(strings)]
        before = ""
        for name, offset in zip(first, _length_offsets(codes), strict=True):
            src.line(f"{name}, = {src.struct(['I'], 'unpack_from')}(b, i+{offset}{before})")
            before += f"+{name}"
        size = src.fresh("z")
        src.line(f"{size} = {element.min_size}{before}")
        src.line(f"p = i+{n}*{size}")
        src.indent("if p <= e:")
        cache = src.constant(_iter_cache(merge_codes(codes)), "j")
        key = first[0] if strings == 1 else f"({', '.join(first)})"
        last = [src.fresh("r") for _ in range(strings)]
        done = [src.fresh("v") for _ in range(strings)]
        src.line(f"{' = '.join(last)} = None")
        mark = src.fresh("x")
        src.indent(f"for {mark} in {cache}({key})(b[i:p]):")
        lengths: list[str] = []
        texts: list[str] = []
        top, targets = self.flat_targets(element, lengths, texts)
        src.line(f"{targets} = {mark}")
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


def _flat_codes(layout: Layout) -> list[str]:
    codes: list[str] = []
    for field in layout.fields:
        if field.is_array:
            codes.append(f"{field.min_size}x")
        elif field.kind == "string":
            codes.extend(("I", "%ds"))
        elif field.layout is not None:
            codes.extend(_flat_codes(field.layout))
        else:
            codes.extend(field.code)
    return codes


def _length_offsets(codes: list[str]) -> list[int]:
    """Where each string's length stands, not counting the strings before it."""
    offsets, position = [], 0
    for code, following in zip(codes, [*codes[1:], ""], strict=True):
        if following == "%ds":
            offsets.append(position)
        if code != "%ds":
            position += struct.calcsize("<" + code)
    return offsets


def _strings_only(layout: Layout, *, views: bool = False) -> int | None:
    """How many strings a message of numbers, times and strings has; None when it holds an array.

    With `views`, arrays of numbers of fixed length are no hindrance.
    """
    total = 0
    for field in layout.fields:
        if field.is_array and views and field.kind == "number" and field.length:
            continue
        if field.is_array:
            return None
        if field.kind == "string":
            total += 1
        elif field.layout is not None:
            inner = _strings_only(field.layout, views=views)
            if inner is None:
                return None
            total += inner
    return total


def _iter_cache(form: str) -> Callable[[Any], Any]:
    """`iter_unpack` for given string lengths; remembers a few."""
    known: dict[Any, Any] = {}

    def iterator(lengths: Any) -> Any:
        found = known.get(lengths)
        if found is None:
            if len(known) >= 64:
                known.clear()
            found = known[lengths] = struct.Struct(quickest(form % lengths, packs=False)).iter_unpack
        return found

    return iterator


def _sizes(form: str) -> tuple[Callable[[int], Any], Callable[[int, tuple[int, ...]], None]]:
    """Remembers for sizes of messages the struct that read the last one of that size.

    Gives `get(size)` and `learn(size, lengths)`. Where lengths never repeat it gives up.
    """
    known: dict[int, Any] = {}
    learned = 0

    def learn(size: int, lengths: tuple[int, ...]) -> None:
        nonlocal learned
        learned += 1
        if learned > LEARN_AT_MOST:
            known.clear()
        elif size <= LEARN_SIZES and len(known) < 512:
            known[size] = struct.Struct(quickest(form % lengths, packs=False)).unpack_from

    return known.get, learn


def _plain_bytes(buffer: Any, count: int, offset: int) -> bytes:
    return bytes(buffer[offset : offset + count])


_dtypes: dict[str, Any] = {}


def _dtype(np: Any, name: str) -> Any:
    """One dtype object per name: the encoder compares by identity."""
    found = _dtypes.get(name)
    if found is None:
        found = _dtypes[name] = np.dtype(name)
    return found
