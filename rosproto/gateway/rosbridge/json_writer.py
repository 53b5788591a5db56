"""Messages as rosbridge's JSON text, by generated code.

As `rosbridge_library.internal.message_conversion` has it: NaN and infinities are null, `uint8[]` and `char[]`
(of any length) are base64, times are `{"secs", "nsecs"}`. Arrays go through Python's own text of a list,
several times faster than an encoder of JSON.
"""

from __future__ import annotations

from binascii import b2a_base64
from collections.abc import Callable
from functools import cache
from json.encoder import encode_basestring_ascii
from typing import Any

from rosproto.codec.layout import FieldLayout
from rosproto.gateway.rosbridge.writer import Writer

__all__ = ["JsonWriter"]

PIECE = 20_000
"""Numbers of an array that are written at once: a millisecond, in which no other thread runs."""
PIECE_OF_SMALL = 1 << 17
LEAST_OF_THREE = -99
"""The least number with three characters."""
FEW = 100


class JsonWriter(Writer):
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
                "time": _time,
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
            return f"items(time, {value})"
        if field.kind == "string":
            return f"items(text, {value})"
        kinds = {"?": "truths", "f": "reals", "d": "reals", "B": "octets", "b": "small"}
        kind = kinds.get(field.code, "integers")
        return f"{kind}({value})"

    def messages(self, call: str, value: str) -> str:
        return f"items({call}, {value})"


def _time(value: Any) -> str:
    return f'{{"secs":{value.secs:d},"nsecs":{value.nsecs:d}}}'


def _items(call: Callable[[Any], str], values: Any) -> str:
    return f"[{','.join(map(call, values))}]"


def _octets(values: Any) -> str:
    if type(values) is not bytes and getattr(values, "dtype", None) != "u1":
        raise TypeError("octets")  # a list, or wider numbers: the codec converts them
    return f'"{b2a_base64(values, newline=False).decode("ascii")}"'


def _list(values: Any) -> list[Any]:
    tolist = getattr(values, "tolist", None)
    return list(values) if tolist is None else tolist()


def _numbers(values: Any) -> str:
    """Python's text of a list; of a long one piece by piece, since nothing else runs while it is made."""
    if len(values) <= PIECE:
        return str(_list(values))
    pieces = [str(_list(values[at : at + PIECE]))[1:-1] for at in range(0, len(values), PIECE)]
    return f"[{', '.join(pieces)}]"


def _integers(values: Any) -> str:
    return _numbers(values)


def _small_integers(values: Any) -> str:
    """Of int8[]: a map has millions, and hardly one needs more than three characters; blanks fill up."""
    if getattr(values, "dtype", None) != "i1" or len(values) < FEW or values.min() < LEAST_OF_THREE:
        return _integers(values)
    table = _table()
    octets = values.view("u1")
    pieces = [
        table[octets[at : at + PIECE_OF_SMALL]].tobytes() for at in range(0, len(octets), PIECE_OF_SMALL)
    ]
    return f"[{b''.join(pieces)[:-1].decode('ascii')}]"


@cache
def _table() -> Any:
    """For each octet the four characters of the int8 that it is, as one number: three digits and a comma."""
    import numpy as np

    numbers = [value if value < 128 else max(value - 256, LEAST_OF_THREE) for value in range(256)]
    return np.frombuffer("".join(f"{number:>3}," for number in numbers).encode(), "u4")


def _reals(values: Any) -> str:
    text = _numbers(values)
    if "n" in text:  # nan and inf; no other number has one
        text = text.replace("-inf", "null").replace("inf", "null").replace("nan", "null")
    return text


def _truths(values: Any) -> str:
    return f"[{','.join('true' if value else 'false' for value in values)}]"
