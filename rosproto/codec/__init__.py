"""The codec: definitions become message classes, messages become bytes and back.

Start with `message_class`, `encode` and `decode`. The codec is independent of connections; numpy is imported
with the first array.
"""

from __future__ import annotations

import warnings

from rosproto.codec.classes import define, message_class, service_class
from rosproto.codec.conversion import Conversion, ValuesLost, differences
from rosproto.codec.encode_decode import decode, decoder, encode, encode_parts, encoder, prepare
from rosproto.codec.message import AnyMsg, DynamicMessage, Message, ServiceType
from rosproto.codec.text import strify_message
from rosproto.codec.value_style import ValueStyle

__all__ = [
    "AnyMsg",
    "Conversion",
    "DynamicMessage",
    "Message",
    "ServiceType",
    "ValueStyle",
    "ValuesLost",
    "decode",
    "decoder",
    "define",
    "differences",
    "encode",
    "encode_parts",
    "encoder",
    "message_class",
    "prepare",
    "service_class",
    "strify_message",
]


def __getattr__(name: str) -> object:
    """Resolve `Flavour`, the former name of `ValueStyle`, with a DeprecationWarning."""
    if name != "Flavour":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    warnings.warn("rosproto.codec.Flavour is now ValueStyle", DeprecationWarning, stacklevel=2)
    return ValueStyle
