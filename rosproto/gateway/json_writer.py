"""Messages as rosbridge's JSON text, by generated code: one function for each type, nested types included.

As in `rosproto.codec`, the source consists only of words from this package and of field names that
`layout.resolve` has checked; values never become source.

As `rosbridge_library.internal.message_conversion` has it: NaN and infinities are null, `uint8[]` and `char[]`
(of any length) are base64, times are `{"secs", "nsecs"}`. Arrays go through Python's own text of a list,
several times faster than an encoder of JSON.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from binascii import b2a_base64
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextvars import ContextVar
from functools import cache, partial
from json.encoder import encode_basestring_ascii
from typing import TYPE_CHECKING, Any, Generic, TypeAlias, TypeVar

from rosproto.codec.generated_source import Source
from rosproto.codec.layout import FieldLayout, Layout
from rosproto.codec.message import Message
from rosproto.time import TVal

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

T = TypeVar("T")
W = TypeVar("W")
Numbers: TypeAlias = "Sequence[object] | NDArray[np.generic]"

MAX_PIECES = 200
"""The most fields in one expression; definitions from the network may have tens of thousands."""
PIECE = 20_000
"""Elements of an array written at once; this blocks other threads for some milliseconds."""
PIECE_OF_SMALL = 1 << 17
"""`PIECE` for int8[], whose text comes from a table."""
PIECE_OF_OCTETS = 3 << 17
"""`PIECE` for bytes; a multiple of three, because base64 writes three bytes as four characters."""
MIN_OF_THREE = -99
"""The least number with three characters."""
FEW = 100
_MARK = "\0"
"""Placeholder of a long array in a text. JSON escapes this character, so it is unique."""


_aside: ContextVar[list[list[str]] | None] = ContextVar("_aside", default=None)
"""Long arrays of the message that this thread writes in parts; None outside `in_parts`."""


def in_parts(write: Callable[[Message], str], message: Message) -> list[str]:
    """Return the text of `write(message)` in parts; long arrays are not joined."""
    arrays: list[list[str]] = []
    token = _aside.set(arrays)
    try:
        texts = write(message).split(_MARK)
    finally:
        _aside.reset(token)
    parts = texts[:1]
    for array, text in zip(arrays, texts[1:], strict=True):
        parts += array
        parts.append(text)
    return parts


def _long(pieces: Iterator[str]) -> str:
    """The text of a long array, or its placeholder inside `in_parts`."""
    arrays = _aside.get()
    if arrays is None:
        return "".join(pieces)
    arrays.append(list(pieces))
    return _MARK


class Writer(ABC, Generic[W]):
    """Generates `write(message)` for a layout and for those inside it.

    Args:
        leaves: The functions that the expressions of `one` and `many` call, by name.
    """

    def __init__(self, leaves: Mapping[str, object]) -> None:
        self._leaves = leaves
        self._made: dict[str, Callable[[Message], W]] = {}

    def function(self, layout: Layout) -> Callable[[Message], W]:
        """The function for a message of this layout."""
        found = self._made.get(layout.spec.name)
        if found is None:
            found = self._made[layout.spec.name] = self._make(layout)
        return found

    def _make(self, layout: Layout) -> Callable[[Message], W]:
        src = Source("def write(m):")
        src.globals.update(self._leaves)
        names = []
        for start in range(0, max(1, len(layout.fields)), MAX_PIECES):
            pieces = []
            for field in layout.fields[start : start + MAX_PIECES]:
                value = src.fresh("x")
                src.line(f"{value} = m.{field.attr}")
                pieces.append((field.name, self._field(src, field, value)))
            name = src.fresh("p")
            src.line(f"{name} = {self.run(pieces, first=start == 0)}")
            names.append(name)
        src.line(f"return {self.join(names)}")
        return src.compile("write", layout.spec.name)

    def _field(self, src: Source, field: FieldLayout, value: str) -> str:
        if field.layout is None:
            return self.many(field, value) if field.is_array else self.one(field, value)
        call = src.constant(self.function(field.layout), "f")
        return self.messages(call, value) if field.is_array else f"{call}({value})"

    # -- defined by each writer

    @abstractmethod
    def run(self, pieces: list[tuple[str, str]], *, first: bool) -> str:
        """The expression for several fields; each piece is (name, expression)."""

    @abstractmethod
    def join(self, names: list[str]) -> str:
        """The expression for a message whose runs of fields are in these variables."""

    @abstractmethod
    def one(self, field: FieldLayout, value: str) -> str:
        """The expression for a number, string or time."""

    @abstractmethod
    def many(self, field: FieldLayout, value: str) -> str:
        """The expression for an array of numbers, strings or times."""

    @abstractmethod
    def messages(self, call: str, value: str) -> str:
        """The expression for an array of messages, each written by `call`."""


class JsonWriter(Writer[str]):
    """Generates functions that return text."""

    def __init__(self) -> None:
        super().__init__(
            {
                "integers": _integers,
                "items": _items,
                "no": "false",
                "null": "null",
                "octets": _octets,
                "real": float.__repr__,
                "reals": _reals,
                "small": _small_integers,
                "text": encode_basestring_ascii,
                "texts": partial(_each, encode_basestring_ascii),
                "time": _time,
                "times": partial(_each, _time),
                "truths": _truths,
                "yes": "true",
            }
        )

    def run(self, pieces: list[tuple[str, str]], *, first: bool) -> str:
        fields = ",".join(f'"{name}":{{{expression}}}' for name, expression in pieces)
        return f"f'{fields}'" if first else f"f',{fields}'"

    def join(self, names: list[str]) -> str:
        return "f'{{" + "".join(f"{{{name}}}" for name in names) + "}}'"

    def one(self, field: FieldLayout, value: str) -> str:
        if field.kind == "time":
            return f"time({value})"
        if field.kind == "string":
            return f"text({value})"
        if field.code == "?":
            return f"yes if {value} else no"
        if field.code in "fd":
            return f"real({value}) if {value} - {value} == 0.0 else null"
        return f"{value}:d"

    def many(self, field: FieldLayout, value: str) -> str:
        if field.kind == "time":
            return f"times({value})"
        if field.kind == "string":
            return f"texts({value})"
        kinds = {"?": "truths", "f": "reals", "d": "reals", "B": "octets", "b": "small"}
        kind = kinds.get(field.code, "integers")
        return f"{kind}({value})"

    def messages(self, call: str, value: str) -> str:
        return f"items({call}, {value})"


def _time(value: TVal) -> str:
    return f'{{"secs":{value.secs:d},"nsecs":{value.nsecs:d}}}'


def _items(call: Callable[[T], str], values: Iterable[T]) -> str:
    """The text of an array of messages, which may contain long arrays."""
    return f"[{','.join(map(call, values))}]"


def _in_pieces(text: Callable[[Any], str], values: Numbers, size: int) -> str:
    """`text(values)`, a list in brackets; a long one is made in pieces."""
    return text(values) if len(values) <= size else _long(_pieces(text, values, size))


def _pieces(text: Callable[[Any], str], values: Numbers, size: int) -> Iterator[str]:
    mark = "["
    for at in range(0, len(values), size):
        yield mark
        yield text(values[at : at + size])[1:-1]
        mark = ","
    yield "]"


def _each(call: Callable[[T], str], values: Sequence[T]) -> str:
    return _in_pieces(partial(_items, call), values, PIECE)


def _octets(values: bytes | NDArray[np.uint8]) -> str:
    if type(values) is not bytes and getattr(values, "dtype", None) != "u1":
        raise TypeError("octets")  # a list, or wider numbers: the codec converts them
    if len(values) <= PIECE_OF_OCTETS:
        return f'"{_base64(values)}"'
    return _long(_octet_pieces(values))


def _octet_pieces(values: bytes | NDArray[np.uint8]) -> Iterator[str]:
    yield '"'
    for at in range(0, len(values), PIECE_OF_OCTETS):
        yield _base64(values[at : at + PIECE_OF_OCTETS])
    yield '"'


def _base64(values: Any) -> str:
    return b2a_base64(values, newline=False).decode("ascii")


def _list(values: Numbers) -> str:
    """Python's text of a list."""
    tolist = getattr(values, "tolist", None)
    return str(list(values) if tolist is None else tolist())


def _integers(values: Numbers) -> str:
    return _in_pieces(_list, values, PIECE)


def _small_integers(values: Any) -> str:
    """The text of int8[], three characters for each padded with blanks: a map has millions of them."""
    if getattr(values, "dtype", None) != "i1" or len(values) < FEW or values.min() < MIN_OF_THREE:
        return _integers(values)
    return _in_pieces(_from_table, values.view("u1"), PIECE_OF_SMALL)


def _from_table(octets: NDArray[np.uint8]) -> str:
    return f"[{_table()[octets].tobytes()[:-1].decode('ascii')}]"


@cache
def _table() -> NDArray[np.uint32]:
    """For each octet the four characters of its int8 value (three digits and a comma), as one integer."""
    import numpy as np

    numbers = [value if value < 128 else max(value - 256, MIN_OF_THREE) for value in range(256)]
    return np.frombuffer("".join(f"{number:>3}," for number in numbers).encode(), "u4")


def _reals(values: Numbers) -> str:
    return _in_pieces(_list_of_reals, values, PIECE)


def _list_of_reals(values: Numbers) -> str:
    text = _list(values)
    if "n" in text:  # nan and inf; no other number has one
        text = text.replace("-inf", "null").replace("inf", "null").replace("nan", "null")
    return text


def _truths(values: Numbers) -> str:
    return _in_pieces(_list_of_truths, values, PIECE)


def _list_of_truths(values: Iterable[object]) -> str:
    return f"[{','.join('true' if value else 'false' for value in values)}]"
