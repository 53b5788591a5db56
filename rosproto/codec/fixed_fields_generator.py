"""Generates common parts of decode functions: runs of fixed-size fields, positions, strings, views."""

from __future__ import annotations

import struct
from collections.abc import Callable
from itertools import repeat, starmap
from typing import Any

from rosproto.codec import arrays
from rosproto.codec.generated_source import Source
from rosproto.codec.layout import DTYPES, FieldLayout, Layout
from rosproto.codec.value_style import ValueStyle


class FixedFieldsWriter:
    """Collects fixed-size fields up to the next field of variable size, and reads them with one struct.

    The current position is the value of the local `base` plus `delta` bytes.
    """

    def __init__(
        self,
        layout: Layout,
        value_style: ValueStyle,
        maker: Callable[[str], Any],
        *,
        general: bool,
        whole: bool = False,
    ) -> None:
        self.layout = layout
        self.value_style = value_style
        self.maker = maker
        self.general = general
        self.views = value_style.views and layout.has_numbers
        self.whole = whole
        self.exact = whole and bool(layout.fixed_size) and not _has_arrays(layout)
        """One struct reads the whole message and checks the size of the buffer."""
        self.src = Source("def decode(b):" if whole else "def decode(b, o, e):")
        self.src.globals["ValueError"] = ValueError
        self.src.globals["range"] = range
        self.src.globals["len"] = len
        self.base = self.start = "0" if whole else "o"
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
            unpack = self.src.struct(self.codes, "unpack" if self.exact else "unpack_from")
            arguments = "b" if self.exact else f"b, {self.at()}"
            self.src.line(f"{', '.join(self.targets)}{comma} = {unpack}({arguments})")
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
            dtype = src.constant(shared_dtype(np, DTYPES[field.base]), "t")
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


def _has_arrays(layout: Layout) -> bool:
    return any(field.is_array or (field.layout and _has_arrays(field.layout)) for field in layout.fields)


def plain_bytes(buffer: Any, count: int, offset: int) -> bytes:
    return bytes(buffer[offset : offset + count])


_dtypes: dict[str, Any] = {}


def shared_dtype(np: Any, name: str) -> Any:
    """One dtype object per name: the encoder compares by identity."""
    found = _dtypes.get(name)
    if found is None:
        found = _dtypes[name] = np.dtype(name)
    return found
