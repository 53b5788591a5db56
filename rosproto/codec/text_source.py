"""Writes how a message of fixed fields and strings is decoded when it is like the one before it.

Such a message's size gives away how long its strings are together, so one struct reads the whole of it, with
everything from the first string's length to the last string's end as one run of bytes. Mostly that run is
the same as in the message before (frame ids do not change), and then so are its values. Else it is taken
apart. Nothing is guessed that is not compared.
"""

from __future__ import annotations

from typing import NamedTuple

from rosproto.codec.array_source import MAX_STATEMENTS, ArrayWriter
from rosproto.codec.guesses import sizes, strings_inside, structs
from rosproto.codec.layout import FieldLayout, Layout
from rosproto.codec.source import merge_codes

__all__ = ["TextWriter", "key_of"]

MOST_STRINGS = 8


class _Piece(NamedTuple):
    """One number, string or array of numbers of a message, nested ones included, in wire order.

    Attributes:
        code: struct code; "%ds" for a string without its length, pad bytes for an array.
        size: Bytes; of a string those of its length.
        target: Where the value belongs.
        array: The field, if it is an array.
    """

    code: str
    size: int
    target: str
    array: FieldLayout | None = None


class TextWriter(ArrayWriter):
    """The part of the decode writer for messages like the one before."""

    def like_the_last(self) -> str:
        """Decode a message of a known size; where the size is new, the code that follows does.

        Gives the name of the function to tell that size to afterwards; "" when the type has no strings, or
        more than strings and fields of fixed size.
        """
        strings = strings_inside(self.layout, views=self.flavour.views)
        if not strings or strings > MOST_STRINGS or self.layout.objects > MAX_STATEMENTS:
            return ""
        pieces: list[_Piece] = []
        made: list[str] = []
        top = self._collect(self.layout, pieces, made)
        texts = [index for index, piece in enumerate(pieces) if piece.code == "%ds"]
        before, run, after = pieces[: texts[0]], pieces[texts[0] : texts[-1] + 1], pieces[texts[-1] + 1 :]
        if any(piece.array for piece in run) or not (before or after):
            return ""
        return self._write(top, made, before, run, after)

    def _write(
        self, top: str, made: list[str], before: list[_Piece], run: list[_Piece], after: list[_Piece]
    ) -> str:
        src = self.src
        codes = [code for piece in run for code in (("I", "%ds") if piece.code == "%ds" else (piece.code,))]
        split = structs(merge_codes(codes), "unpack")
        form = merge_codes([*(piece.code for piece in before), "%ds", *(piece.code for piece in after)])
        memory, learn = sizes(form, sum(piece.size for piece in (*before, *after)), len(run), split)
        found, unpack, known, now, parts = (src.fresh(prefix) for prefix in "wurxv")
        texts = ", ".join(piece.target for piece in run)
        src.line(f"{found} = {src.constant(memory.get, 'g')}({self.total})")
        src.indent(f"if {found} is not None:")
        for line in made:
            src.line(line)
        src.line(f"{unpack}, {known}, {texts}, {top}._connection_header, {parts} = {found}")
        targets = [*_numbers(before), now, *_numbers(after)]
        src.line(f"{', '.join(targets)}{',' if len(targets) == 1 else ''} = {unpack}(b, {self.start})")
        src.indent(f"if {now} != {known}:")
        self._take_apart(now, parts, run, src.constant(split, "x"))
        # One tuple, so that no other thread comes between its parts.
        value = f"({unpack}, {now}, {texts}, None, {parts})"
        src.line(f"{src.constant(memory, 'y')}[{self.total}] = {value}")
        src.dedent()
        self._views(self.start, 0, before)
        self._views("e", -sum(piece.size for piece in after), after)
        src.line(f"return {top}")
        src.dedent()
        return src.constant(learn, "l")

    def _collect(self, layout: Layout, pieces: list[_Piece], made: list[str]) -> str:
        """List the pieces of a message, and the lines that make its objects; gives its variable."""
        var = self.src.fresh("m")
        made.append(f"{var} = {self.create(layout.spec.name)}()")
        for field in layout.fields:
            target = f"{var}.{field.attr}"
            if field.is_array:
                pieces.append(_Piece(f"{field.min_size}x", field.min_size, target, field))
            elif field.kind == "number":
                pieces.append(_Piece(field.code, field.size, target))
            elif field.kind == "string":
                pieces.append(_Piece("%ds", 4, target))
            elif field.layout is not None:
                made.append(f"{target} = {self._collect(field.layout, pieces, made)}")
            else:
                stamp = self.src.fresh("t")
                made.append(f"{stamp} = {target} = {self.create(field.base)}()")
                pieces.append(_Piece(field.code[0], 4, f"{stamp}.secs"))
                pieces.append(_Piece(field.code[1], 4, f"{stamp}.nsecs"))
        return var

    def _take_apart(self, run: str, parts: str, pieces: list[_Piece], split: str) -> None:
        """Read the values of a run that is another than the last, by the struct for the last lengths."""
        src = self.src
        lengths: list[str] = []
        targets: list[str] = []
        texts: list[str] = []
        for piece in pieces:
            if piece.code == "%ds":
                lengths.append(src.fresh("n"))
                texts.append(src.fresh("s"))
                targets.extend((lengths[-1], texts[-1]))
            else:
                targets.append(piece.target)
        line = f"{', '.join(targets)} = {parts}({run})"
        differ = " or ".join(f"{n} != len({text})" for n, text in zip(lengths, texts, strict=True))
        src.line(line)
        src.indent(f"if {differ}:")
        self._find_lengths(run, lengths, pieces)
        src.line(f"{parts} = {split}({key_of(lengths)})")
        src.line(line)
        src.dedent()
        strings = [piece.target for piece in pieces if piece.code == "%ds"]
        for target, text in zip(strings, texts, strict=True):
            src.line(f"{target} = {self.text(text)}")

    def _find_lengths(self, run: str, lengths: list[str], pieces: list[_Piece]) -> None:
        src = self.src
        names = iter(lengths)
        src.line("i = 0")
        for piece in pieces:
            if piece.code == "%ds":
                n = next(names)
                src.line(f"{n}, = {src.struct(['I'], 'unpack_from')}({run}, i)")
                src.line(f"i += 4+{n}")
            else:
                src.line(f"i += {piece.size}")
        src.line(f"if i != len({run}): raise ValueError")

    def _views(self, base: str, position: int, pieces: list[_Piece]) -> None:
        for piece in pieces:
            if piece.array:
                where = f"{base}{position:+}" if position else base
                view = self.number_array(piece.array, str(piece.array.length), where)
                self.src.line(f"{piece.target} = {view}")
            position += piece.size


def key_of(lengths: list[str]) -> str:
    """How `structs` and `sizes` take the lengths of strings: as one integer, or a tuple."""
    return lengths[0] if len(lengths) == 1 else f"({', '.join(lengths)})"


def _numbers(pieces: list[_Piece]) -> list[str]:
    return [piece.target for piece in pieces if not piece.array]
