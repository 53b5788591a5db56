"""The codec: definitions become message classes, messages become bytes and back.

Start with `message_class`, `encode` and `decode`. The codec is independent of connections; numpy is imported
with the first array.
"""

from __future__ import annotations

from rosproto.codec.classes import define, message_class, service_class
from rosproto.codec.conversion import Conversion, ValuesLost, differences
from rosproto.codec.dicts import from_dict
from rosproto.codec.encode_decode import decode, decoder, encode, encode_parts, encoder, prepare
from rosproto.codec.message import AnyMsg, DynamicMessage, Message, ServiceType
from rosproto.codec.text import strify_message
from rosproto.codec.value_style import ValueStyle
from rosproto.deprecation import former_names

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
    "from_dict",
    "message_class",
    "prepare",
    "service_class",
    "strify_message",
]

__getattr__ = former_names(__name__, {"Flavour": "ValueStyle"})
