"""Value styles: the Python values of a family of message classes.

The default decodes arrays of numbers to numpy views. Unchanged rospy programs rely on genpy's values (tuples,
bytes, genpy's Time, genpy's errors); the compatibility layer passes its own `ValueStyle` to `message_class`.
Functions are generated for one value style, without checks per message.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from rosproto.errors import CodecError
from rosproto.time import Duration, Time, TVal


def _same(error: CodecError) -> Exception:
    return error


class ValueStyle(NamedTuple):
    """Values and errors of one family of classes.

    Attributes:
        name: Part of the class cache's key and of pickles; unique.
        views: Arrays of numbers decode to read-only numpy views; False: tuples, and bytes for uint8[] and
            char[], with lists and bytes as defaults.
        base: Base class of the messages; None means `rosproto.codec.Message`.
        time, duration: Classes of the two builtin types; subclasses of `TVal` with slots secs, nsecs.
        encode_error, decode_error: Convert a CodecError to the raised exception.
        module: Format of `__module__`, from package and "msg" or "srv".
        text_errors: Error handler for non-UTF-8 bytes. Text of "surrogateescape" can be encoded again.
    """

    name: str
    views: bool
    base: type | None = None
    time: type[TVal] = Time
    duration: type[TVal] = Duration
    encode_error: Callable[[CodecError], Exception] = _same
    decode_error: Callable[[CodecError], Exception] = _same
    module: str = "msgdefs.{package}.{kind}"
    text_errors: str = "surrogateescape"

    def __repr__(self) -> str:
        return f"ValueStyle({self.name!r})"


NUMPY = ValueStyle("numpy", views=True)
"""The default: numpy views."""
ROSPY = ValueStyle("rospy", views=False, module="{package}.{kind}")
"""genpy's values with rosproto's errors; the rospy layer adds genpy's errors and time classes."""

_NAMED = {"numpy": NUMPY, "rospy": ROSPY}


def value_style_named(value_style: str | ValueStyle) -> ValueStyle:
    """Return a value style unchanged, or find it by name.

    Raises:
        ValueError: The name is unknown.
    """
    if isinstance(value_style, ValueStyle):
        # Unpickling uses the latest value style of a name.
        _NAMED[value_style.name] = value_style
        return value_style
    found = _NAMED.get(value_style)
    if found is None:
        raise ValueError(
            f"value style {value_style!r} is unknown: give a value style, or one of {sorted(_NAMED)}"
        )
    return found
