"""Writes how a message of fixed fields and strings is decoded when it is like the one before it.

Such a message's size gives away how long its strings are together, so one struct reads the whole of it, with
everything from the first string's length to the last string's end as one run of bytes. Mostly that run is
the same as in the message before (frame ids do not change), and then so are its values. Else it is taken
apart. Nothing is guessed that is not compared.
"""

from __future__ import annotations

from rosproto.codec.array_source import MAX_STATEMENTS, ArrayWriter
from rosproto.codec.guesses import sizes, strings_inside
from rosproto.codec.layout import FieldLayout, Layout
from rosproto.codec.source import merge_codes
from rosproto.records import NamedTuple

__all__ = ["TextWriter"]

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
    """The part of the decode writer that does this."""

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
        form = merge_codes([*(piece.code for piece in before), "%ds", *(piece.code for piece in after)])
        memory, learn = sizes(form, sum(piece.size for piece in (*before, *after)), len(run))
        found, unpack, known, now = (src.fresh(prefix) for prefix in "wurx")
        texts = ", ".join(piece.target for piece in run)
        src.line(f"{found} = {src.constant(memory.get, 'g')}({self.total})")
        src.indent(f"if {found} is not None:")
        for line in made:
            src.line(line)
        src.line(f"{unpack}, {known}, {texts}, {top}._connection_header = {found}")
        targets = [*_numbers(before), now, *_numbers(after)]
        src.line(f"{', '.join(targets)}{',' if len(targets) == 1 else ''} = {unpack}(b, {self.start})")
        src.indent(f"if {now} != {known}:")
        self._take_apart(now, run)
        # One tuple, so that no other thread comes between its parts.
        src.line(f"{src.constant(memory, 'y')}[{self.total}] = ({unpack}, {now}, {texts}, None)")
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

    def _take_apart(self, run: str, pieces: list[_Piece]) -> None:
        """Read the values of a run that is another than the last."""
        src = self.src
        n = src.fresh("n")
        src.line("i = 0")
        for piece in pieces:
            if piece.code == "%ds":
                src.line(f"{n}, = {src.struct(['I'], 'unpack_from')}({run}, i)")
                src.line("p = i+4")
                src.line(f"i = p+{n}")
                src.line(f"{piece.target} = {self.text(f'{run}[p:i]')}")
            else:
                src.line(f"{piece.target}, = {src.struct([piece.code], 'unpack_from')}({run}, i)")
                src.line(f"i += {piece.size}")
        src.line(f"if i != len({run}): raise ValueError")

    def _views(self, base: str, position: int, pieces: list[_Piece]) -> None:
        for piece in pieces:
            if piece.array:
                where = f"{base}{position:+}" if position else base
                view = self.number_array(piece.array, str(piece.array.length), where)
                self.src.line(f"{piece.target} = {view}")
            position += piece.size


def _numbers(pieces: list[_Piece]) -> list[str]:
    return [piece.target for piece in pieces if not piece.array]
