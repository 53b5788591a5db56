"""Generates the encode function of one type.

Example for sensor_msgs/LaserScan:

    def encode(m):
        try:
            v1 = m.header; t2 = v1.stamp; y3 = v1.frame_id
            a5 = m.ranges
            if type(a5) is ND and a5.dtype is F4: n6 = a5.size
            else: a5, n6 = PART(a5, 'f', '<f4')            # lists, other dtypes
            ...
            r9, k8, n4, s5 = V                             # the last message's string and its encoding
            if y3 is not r9:
                s5 = ENCODE(y3); n4 = len(s5)
                k8 = J1.get(n4) or MISS(n4)                # a struct for these string lengths
                if n4 <= 512: V = (y3, k8, n4, s5)
            return JOIN((k8(v1.seq, t2.secs, t2.nsecs, n4, s5, m.angle_min, ..., n6), a5, ...))
        except ERRORS as x:
            return fail(m, x)

All fixed-size fields and strings between two arrays are packed by one struct; arrays are passed to
`bytes.join`, which copies each once from the caller's memory.
"""

from __future__ import annotations

from collections import UserString
from collections.abc import Callable, Iterable
from typing import Any

from rosproto.codec import arrays
from rosproto.codec.decode_generator import (
    BLOCK_OBJECTS,
    ERRORS,
    MAX_LOOP_DEPTH,
    MAX_STATEMENTS,
    shared_dtype,
)
from rosproto.codec.generated_source import CACHED_LENGTH, Source, flat_codes
from rosproto.codec.layout import DTYPES, FieldLayout, Layout
from rosproto.codec.value_style import ValueStyle

MAX_STRINGS = 6
"""Maximum number of strings packed by one struct: the lengths of more strings rarely repeat."""
FOURS_FROM = 32
"""Minimum number of elements for packing them in fours."""
SMALL_ARRAY = 1024
"""Maximum bytes of a fixed-length array that is packed with the neighbouring fields."""


def encode_function(
    layout: Layout,
    value_style: ValueStyle,
    *,
    general: bool = False,
    parts: bool = False,
    nested: bool = False,
    fail: Callable[..., object] | None = None,
) -> Callable[..., Any]:
    """Generate `encode(message) -> bytes`.

    Args:
        layout: The type.
        value_style: Python values to handle fastest; others are accepted.
        general: Also accept bytes as strings, lone surrogates, strided arrays, any iterable.
        parts: Return a list of parts that join to the bytes.
        nested: Take (message, parts) and append to the list `parts`, without catching errors.
        fail: Called with (message, exception) on errors.
    """
    writer = _EncodeWriter(layout, value_style, general=general, parts=parts, nested=nested)
    writer.write(fail)
    return writer.src.compile("encode", layout.spec.name)


class _EncodeWriter:
    def __init__(
        self, layout: Layout, value_style: ValueStyle, *, general: bool, parts: bool, nested: bool
    ) -> None:
        self.layout = layout
        self.value_style = value_style
        self.general = general
        self.parts = parts
        self.nested = nested
        self.src = Source("def encode(m, parts):" if nested else "def encode(m):")
        for item in (len, type, list, iter, zip, TypeError, ValueError):
            self.src.globals[item.__name__] = item
        self.codes: list[str] = []
        self.values: list[str] = []
        self.lengths: list[str] = []
        self.same: list[tuple[str, str]] = []
        self.joined: list[str] = []
        self.pack = ""
        self.single_pack = False
        self.loops = 0
        self.statements = 0
        self.listed = nested or _has_lists(layout)

    # -- the function ------------------------------------------------------------------------

    def write(self, fail: Callable[..., object] | None) -> None:
        src = self.src
        if not self.nested:
            src.indent("try:")
            if self.listed:
                src.line("parts = []")
        self.fields(self.layout, "m")
        self.flush()
        if self.nested:
            src.line("return None")
            return
        if self.parts:
            src.line("return parts" if self.listed else f"return [{', '.join(self.joined)}]")
        else:
            src.line(f"return {self.result()}")
        src.dedent()
        src.indent(f"except {src.constant(ERRORS)} as x:")
        src.line(f"return {src.constant(fail)}(m, x)")
        src.dedent()

    def result(self) -> str:
        if self.listed:
            return f"{self.src.constant(b''.join, 'j')}(parts)"
        if len(self.joined) == 1 and self.single_pack:
            return self.joined[0]
        return f"{self.src.constant(b''.join, 'j')}(({', '.join(self.joined)},))" if self.joined else "b''"

    def put(self, part: str) -> None:
        """Add a part of the message."""
        if self.listed:
            self.src.line(f"parts.append({part})")
        else:
            self.joined.append(part)

    # -- runs of fixed-size fields and strings -----------------------------------------------

    def flush(self) -> None:
        """Pack the collected run with one struct."""
        if not self.codes:
            return
        pack = self.pack if self.lengths else self.src.struct(self.codes, "pack")
        if self.same:
            self.last_strings()
        elif self.lengths:
            if self.loops:
                self.src.indent(f"if {pack} is None:")
            self.src.line(f"{pack} = {self.src.struct_for(self.codes, self.lengths, 'pack')}")
            if self.loops:
                self.src.dedent()
        self.single_pack = not self.joined
        self.put(f"{pack}({', '.join(self.values)})")
        self.codes, self.values, self.lengths, self.same = [], [], [], []

    def last_strings(self) -> None:
        """Encode this run's strings, unless the last message had the same objects.

        Programs often set a constant as frame_id or forward a received one.
        """
        src = self.src
        texts, encoded = zip(*self.same, strict=True)
        old = [src.fresh("r") for _ in texts]
        # One tuple, so that threads read and write it atomically.
        # Its members: the texts, the struct's method, and for each text its length and bytes.
        last = src.variable((None,) * (3 * len(old) + 1))
        pairs = ", ".join(f"{n}, {s}" for n, s in zip(self.lengths, encoded, strict=True))
        src.line(f"{', '.join(old)}, {self.pack}, {pairs} = {last}")
        src.indent(f"if {' or '.join(f'{now} is not {r}' for now, r in zip(texts, old, strict=True))}:")
        for now, s, n in zip(texts, encoded, self.lengths, strict=True):
            src.line(f"{s} = {self.encoded(now)}")
            src.line(f"{n} = len({s})")
        src.line(f"{self.pack} = {src.struct_for(self.codes, self.lengths, 'pack')}")
        src.line(f"if {'+'.join(self.lengths)} <= {CACHED_LENGTH}:")
        src.line(f"    {last} = ({', '.join(texts)}, {self.pack}, {pairs})")
        src.dedent()

    # -- fields ------------------------------------------------------------------------------

    def fields(self, layout: Layout, var: str) -> None:
        for field in layout.fields:
            self.statements += 1
            value = f"{var}.{field.attr}"
            if field.is_array:
                self.array(field, value)
            elif field.kind == "number":
                self.codes.append("B" if field.code == "?" else field.code)
                self.values.append(value)
            elif field.kind == "string":
                self.string(value)
            elif field.kind == "time":
                stamp = self.src.fresh("t")
                self.src.line(f"{stamp} = {value}")
                self.codes.extend(field.code)
                self.values.extend((f"{stamp}.secs", f"{stamp}.nsecs"))
            else:
                self.message(field, value)

    def message(self, field: FieldLayout, value: str) -> None:
        assert field.layout is not None
        if self.statements > MAX_STATEMENTS and self.listed:
            self.call(field.layout, value)
            return
        inner = self.src.fresh("v")
        self.src.line(f"{inner} = {value}")
        self.fields(field.layout, inner)

    def call(self, layout: Layout, value: str) -> None:
        """Call a separate function for a nested message."""
        self.flush()
        function = encode_function(layout, self.value_style, general=self.general, nested=True)
        self.src.line(f"{self.src.constant(function, 'e')}({value}, parts)")

    def string(self, value: str) -> None:
        if len(self.lengths) == MAX_STRINGS:
            self.flush()
        if not self.lengths:
            self.pack = self.src.fresh("k")
            if self.loops:
                self.src.first(f"{self.pack} = None")
        text, n = self.src.fresh("s"), self.src.fresh("n")
        if self.loops:
            self.repeated_string(value, text, n)
        elif self.general:
            self.src.line(f"{text} = {self.encoded(value)}")
            self.src.line(f"{n} = len({text})")
        else:
            self.same.append((self.src.fresh("y"), text))
            self.src.line(f"{self.same[-1][0]} = {value}")
        self.codes.append("I")
        self.values.append(n)
        self.codes.append("%ds")
        self.values.append(text)
        self.lengths.append(n)

    def repeated_string(self, value: str, text: str, n: str) -> None:
        """Encode an array element's string only if it is another object than the previous one."""
        src = self.src
        now, last = src.fresh("y"), src.fresh("r")
        src.first(f"{last} = {text} = {n} = None")
        src.line(f"{now} = {value}")
        src.indent(f"if {now} is not {last}:")
        src.line(f"{last} = {now}")
        src.line(f"{text} = {self.encoded(now)}")
        src.indent(f"if len({text}) != {n}:")
        src.line(f"{n} = len({text})")
        src.line(f"{self.pack} = None")
        src.dedent()
        src.dedent()

    def encoded(self, value: str) -> str:
        if self.general:
            return f"{self.src.constant(text_bytes)}({value})"
        # Not value.encode(): only an immutable str may be compared by identity.
        return f"{self.src.constant(str.encode)}({value})"

    # -- arrays ------------------------------------------------------------------------------

    def array(self, field: FieldLayout, value: str) -> None:
        if field.kind == "number":
            self.numbers(field, value)
            return
        src = self.src
        items = src.fresh("l")
        src.line(f"{items} = {value}")
        checker = src.constant(_any_items if self.general else _items)
        src.line(f"if type({items}) is not list: {items} = {checker}({items})")
        if field.length is None:
            self.codes.append("I")
            self.values.append(f"len({items})")
        else:
            src.line(f"if len({items}) != {field.length}: raise ValueError")
        self.flush()
        if field.kind == "string":
            self.strings(items)
        elif field.kind == "time":
            var = src.fresh("t")
            src.indent(f"for {var} in {items}:")
            src.line(f"parts.append({src.struct([field.code], 'pack')}({var}.secs, {var}.nsecs))")
            src.dedent()
        else:
            self.messages(field, items)

    def strings(self, items: str) -> None:
        src = self.src
        text = src.fresh("s")
        src.indent(f"for {text} in {items}:")
        src.line(f"{text} = {self.encoded(text)}")
        src.line(f"parts.append({src.struct(['I'], 'pack')}(len({text})))")
        src.line(f"parts.append({text})")
        src.dedent()

    def numbers(self, field: FieldLayout, value: str) -> None:
        src = self.src
        array, n = src.fresh("a"), src.fresh("n")
        name = DTYPES[field.base]
        src.line(f"{array} = {value}")
        condition, count = self.expected(field, array, name)
        if field.length is None:
            part = src.constant(arrays.number_part)
            src.line(f"if {condition}: {n} = {count}")
            src.line(f"else: {array}, {n} = {part}({array}, '{field.code}', '{name}')")
            self.codes.append("I")
            self.values.append(n)
        elif field.length * field.size <= SMALL_ARRAY:
            self.small_array(field, array, condition)
            return
        else:
            part = src.constant(arrays.fixed_part)
            src.indent(f"if not ({condition} and {count} == {field.length}):")
            src.line(f"{array} = {part}({array}, '{field.code}', '{name}', {field.length})")
            src.dedent()
        self.flush()
        self.put(array)

    def small_array(self, field: FieldLayout, array: str, condition: str) -> None:
        """Pack a small array, such as a covariance, in the run's struct: faster than a separate part."""
        src = self.src
        assert field.length is not None
        size = field.length * field.size
        part = src.constant(arrays.fixed_bytes)
        otherwise = f"{part}({array}, '{field.code}', '{DTYPES[field.base]}', {field.length})"
        if condition == "0":
            src.line(f"{array} = {otherwise}")
        elif self.value_style.views:
            src.line(f"{array} = {array}.tobytes() if {condition} else {otherwise}")
        else:
            src.line(f"if not {condition}: {array} = {otherwise}")
        src.line(f"if len({array}) != {size}: raise ValueError")
        self.codes.append(f"{size}s")
        self.values.append(array)

    def expected(self, field: FieldLayout, array: str, name: str) -> tuple[str, str]:
        """Expressions: whether the value can be joined unchanged, and its number of elements."""
        src = self.src
        if self.general:
            return "0", "0"
        if not self.value_style.views:
            src.globals["bytes"] = bytes
            return (f"type({array}) is bytes", f"len({array})") if field.code == "B" else ("0", "0")
        import numpy as np

        dtype = src.constant(shared_dtype(name), "t")
        return (
            f"type({array}) is {src.constant(np.ndarray, 'n')} and {array}.dtype is {dtype}",
            f"{array}.size",
        )

    # -- arrays of messages ------------------------------------------------------------------

    def messages(self, field: FieldLayout, items: str) -> None:
        assert field.layout is not None
        element = field.layout
        if _fits_in_fours(element) and not self.general:
            self.in_fours(element, items)
        self.element_loop(element, items)

    def in_fours(self, element: Layout, items: str) -> None:
        """Pack four elements of a long array with one struct, in two thirds of the time; the rest remains."""
        src = self.src
        every, names = src.fresh("t"), [src.fresh("v") for _ in range(4)]
        codes = ["B" if code == "?" else code for code in flat_codes(element)]
        values = [value for name in names for value in _flat_values(element, name)]
        src.indent(f"if len({items}) >= {FOURS_FROM}:")
        src.line(f"{every} = iter({items}[:len({items})&-4])")  # &-4: down to a multiple of four
        src.indent(f"for {', '.join(names)} in zip({', '.join([every] * 4)}):")
        src.line(f"parts.append({src.struct(4 * codes, 'pack')}({', '.join(values)}))")
        src.dedent()
        src.line(f"{items} = {items}[len({items})&-4:]")
        src.dedent()

    def element_loop(self, element: Layout, items: str) -> None:
        """Pack elements one by one."""
        src = self.src
        var = src.fresh("v")
        self.loops += 1
        src.indent(f"for {var} in {items}:")
        if self.loops > MAX_LOOP_DEPTH or self.statements > MAX_STATEMENTS:
            self.call(element, var)
        else:
            self.fields(element, var)
            self.flush()
        src.line("pass")  # an element without fields leaves the loop without a statement
        src.dedent()
        self.loops -= 1


def text_bytes(value: object) -> bytes:
    """Encode a string field: str (surrogates stand for non-UTF-8 bytes) or bytes."""
    if isinstance(value, str):
        return value.encode("utf-8", "surrogateescape")
    if isinstance(value, (bytes, bytearray)):
        return bytes(value)
    if isinstance(value, UserString):
        return text_bytes(value.data)
    raise TypeError(f"str expected, not {type(value).__name__}")


def _items(value: object) -> tuple[object, ...]:
    if type(value) is tuple:
        return value
    raise TypeError(f"a list is expected, not {type(value).__name__}")


def _any_items(value: Iterable[object]) -> list[object]:
    if isinstance(value, (str, bytes, bytearray, dict)):
        raise TypeError(f"a list is expected, not {type(value).__name__}")
    return list(value)


def _fits_in_fours(element: Layout) -> bool:
    """Whether elements are small and contain only numbers and times."""
    return (
        element.min_size > 0
        and element.objects <= BLOCK_OBJECTS
        and all(field.kind in ("number", "time") and not field.is_array for field in element.fields)
    )


def _flat_values(element: Layout, var: str) -> list[str]:
    """Expressions of the numbers in an element."""
    values: list[str] = []
    for field in element.fields:
        value = f"{var}.{field.attr}"
        values += [value] if field.kind == "number" else [f"{value}.secs", f"{value}.nsecs"]
    return values


def _has_lists(layout: Layout) -> bool:
    """Whether it contains arrays of messages, strings or times: parts are then collected in a list."""
    return any(
        (f.is_array and f.kind != "number") or (f.layout is not None and _has_lists(f.layout))
        for f in layout.fields
    )
