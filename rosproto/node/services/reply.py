"""From what a service handler returns or raises to the bytes of the answer: no I/O.

Source: wiki.ros.org/ROS/TCPROS (services: one byte "ok", then a length-prefixed response, or error text).
"""

from __future__ import annotations

import struct
from collections.abc import Mapping
from typing import Any

from rosproto.codec import encode
from rosproto.errors import ServiceError

LONGEST_ERROR = 64 << 10  # bytes of error text; rospy reads 256 at a time, nobody reads a book


def response_from(returned: Any, response_class: type) -> Any:
    """The response message a handler meant.

    Args:
        returned: An instance of the response; a dict of its fields; None, for a response without fields; the
            bare value, for a response of one field; a tuple or list of all fields in order, for several.
        response_class: Class of the response.

    Raises:
        TypeError: It is none of these. None for a response that has fields is most often a forgotten
            `return`, so it is an error here as it is in rospy, not a response full of zeros.
    """
    if isinstance(returned, response_class) or getattr(returned, "_type", None) == response_class._type:  # type: ignore[attr-defined]
        return returned
    fields: list[str] = list(response_class.__slots__)  # type: ignore[attr-defined]
    if isinstance(returned, Mapping):
        return response_class(**returned)
    if returned is None and not fields:
        return response_class()
    if returned is not None and len(fields) == 1 and not hasattr(returned, "_type"):
        return response_class(**{fields[0]: returned})
    if isinstance(returned, (tuple, list)) and len(returned) == len(fields):
        return response_class(**dict(zip(fields, returned, strict=True)))
    raise TypeError(
        f"the handler returned {_shown(returned)}; expected {response_class._type} with"  # type: ignore[attr-defined]
        f" {', '.join(fields) or 'no fields'}, or a dict of these"
    )


def _shown(returned: Any) -> str:
    if returned is None:
        return "None"
    if isinstance(returned, (tuple, list)):
        return f"a {type(returned).__name__} of {len(returned)} values"
    return str(getattr(returned, "_type", type(returned).__name__))


def encode_reply(response: Any) -> bytes:
    """The answer of a call that went well: ok byte 1, length, response."""
    body = encode(response)
    return struct.pack("<BI", 1, len(body)) + body


def error_text(error: BaseException) -> str:
    """What the caller is told about an exception: a ServiceError's own text, else class and message."""
    if isinstance(error, ServiceError):
        return error.text
    text = str(error)
    return f"{type(error).__name__}: {text}" if text else type(error).__name__


def encode_error(text: str) -> bytes:
    """The answer of a call that failed: ok byte 0, length, text in UTF-8 (cut when it is enormous)."""
    body = text.encode("utf-8", "surrogateescape" if _has_escaped_bytes(text) else "backslashreplace")
    body = body[:LONGEST_ERROR]
    return struct.pack("<BI", 0, len(body)) + body


def _has_escaped_bytes(text: str) -> bool:
    """True when `text` holds bytes of another program that were not UTF-8 and go back as they came."""
    surrogates = [letter for letter in text if "\ud800" <= letter <= "\udfff"]
    return bool(surrogates) and all("\udc80" <= letter <= "\udcff" for letter in surrogates)
