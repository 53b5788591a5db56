"""Message and service classes made from definitions, with genpy's values in place of numpy's.

The base of the classes and their values (genpy.Time, tuples, bytes, genpy's errors) are in `modules/genpy`.
This module combines them with the definitions, and adapts classes that genpy generated to a node.
"""

from __future__ import annotations

from functools import cache
from importlib import import_module
from io import BytesIO
from typing import Any

from rosproto.codec import Message, ValueStyle, message_class, service_class
from rosproto.rospy.definitions import library


@cache
def value_style() -> ValueStyle:
    """The value style of these classes: base, values and errors."""
    made: ValueStyle = import_module("genpy.message").FLAVOUR  # our own, in modules/
    return made


def message(name: str) -> Any:
    """The class of "package/Type".

    Raises:
        DefinitionError: There is none, or its definition is wrong.
    """
    return message_class(name, library(), value_style=value_style())


def service(name: str) -> Any:
    """The class of a service, as `message`; it names the file that genpy would have written it to."""
    made = service_class(name, library(), value_style=value_style())
    package, _, base = name.partition("/")
    made.__module__ = f"{package}.srv._{base}"
    return made


def is_ours(cls: Any) -> bool:
    """True for a class made from a definition; False for one that genpy generated."""
    return isinstance(cls, type) and issubclass(cls, Message)


class Encoded:
    """A message that is already encoded; a node accepts it in place of a message."""

    __slots__ = ("_data", "_type")

    def __init__(self, type_name: str, data: bytes) -> None:
        self._type = type_name
        self._data = data

    def _encode(self) -> bytes:
        return self._data


@cache
def node_class(cls: Any) -> Any:
    """Return the class for a node: the message class itself, or a stand-in for one that genpy generated.

    A stand-in has genpy's attributes for the wire, and the three functions that the node calls; these take
    and return instances of the generated class.
    """
    if is_ours(cls):
        return cls

    def encode(message: Any) -> bytes:
        if type(message) is Encoded:
            return message._data
        buffer = BytesIO()
        message.serialize(buffer)
        return buffer.getvalue()

    def decode(data: Any, start: int, end: int) -> Any:
        return cls().deserialize(bytes(data[start:end]))

    return type(
        cls.__name__,
        (),
        {
            "_type": cls._type,
            "_md5sum": cls._md5sum,
            "_full_text": cls._full_text,
            "_has_header": bool(getattr(cls, "_has_header", False)),
            "_has_views": False,  # decoding copies the bytes first
            "_binding": None,
            "_encode": staticmethod(encode),
            "_decode": staticmethod(decode),
            "_whole": staticmethod(lambda data: decode(data, 0, len(data))),
            "__slots__": tuple(cls.__slots__),
        },
    )


@cache
def node_service(cls: Any) -> Any:
    """The same for a service class."""
    if is_ours(cls._request_class) and is_ours(cls._response_class):
        return cls
    return type(
        cls.__name__,
        (),
        {
            "_type": cls._type,
            "_md5sum": cls._md5sum,
            "_request_class": node_class(cls._request_class),
            "_response_class": node_class(cls._response_class),
        },
    )
