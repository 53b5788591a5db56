"""A value style says which Python values a family of message classes is made of.

Ours decodes arrays of numbers to numpy views. Unchanged rospy programs rely on genpy's values (tuples,
bytes, genpy's Time, genpy's errors); the compatibility layer makes a second family by handing its own
`ValueStyle` to `message_class`. The generated code asks a value style nothing per message: it is baked in.
"""

from __future__ import annotations

from collections.abc import Callable

from rosproto.errors import CodecError
from rosproto.time import Duration, Time, TVal


def _same(error: CodecError) -> Exception:
    return error


class ValueStyle:
    """Values and errors of one family of classes.

    Attributes:
        name: Part of the class cache's key and of pickles; unique.
        views: Arrays of numbers decode to read-only numpy views; False: tuples, and bytes for uint8[] and
            char[], with lists and bytes as defaults.
        base: Base class of the messages; None means `rosproto.codec.Message`.
        time, duration: Classes of the two builtin types; subclasses of `TVal` with slots secs, nsecs.
        encode_error, decode_error: Turn our CodecError into what is raised.
        module: Format of `__module__`, from package and "msg" or "srv".
        text_errors: How bytes that are not UTF-8 are decoded. "surrogateescape" can be encoded again.
    """

    __slots__ = (
        "base",
        "decode_error",
        "duration",
        "encode_error",
        "module",
        "name",
        "text_errors",
        "time",
        "views",
    )

    def __init__(
        self,
        name: str,
        *,
        views: bool,
        base: type | None = None,
        time: type[TVal] = Time,
        duration: type[TVal] = Duration,
        encode_error: Callable[[CodecError], Exception] = _same,
        decode_error: Callable[[CodecError], Exception] = _same,
        module: str = "msgdefs.{package}.{kind}",
        text_errors: str = "surrogateescape",
    ) -> None:
        self.name = name
        self.views = views
        self.base = base
        self.time = time
        self.duration = duration
        self.encode_error = encode_error
        self.decode_error = decode_error
        self.module = module
        self.text_errors = text_errors

    def __repr__(self) -> str:
        return f"ValueStyle({self.name!r})"


NUMPY = ValueStyle("numpy", views=True)
"""Ours: numpy views."""
ROSPY = ValueStyle("rospy", views=False, module="{package}.{kind}")
"""genpy's values with our own errors; the rospy layer adds genpy's errors and time classes."""

_NAMED = {"numpy": NUMPY, "rospy": ROSPY}


def value_style_named(value_style: str | ValueStyle) -> ValueStyle:
    """The value style itself, or the one with that name.

    Raises:
        ValueError: There is none with that name.
    """
    if isinstance(value_style, ValueStyle):
        # The latest one with a name is what pickles of that name come back as.
        _NAMED[value_style.name] = value_style
        return value_style
    found = _NAMED.get(value_style)
    if found is None:
        raise ValueError(
            f"value style {value_style!r} is unknown: give a value style, or one of {sorted(_NAMED)}"
        )
    return found
