"""Message and service classes as genpy makes them, from definitions: the third family beside numpy's.

The classes' base and their values (genpy.Time, tuples, bytes, genpy's errors) are in `modules/genpy`; here is
where definitions come from, and how classes that other code generated travel through a node.
"""

from __future__ import annotations

from functools import cache
from importlib import import_module
from io import BytesIO
from typing import Any

from rosproto.codec import Flavour, Message, message_class, service_class
from rosproto.rospy.definitions import library

__all__ = ["Encoded", "carried", "carried_service", "is_known", "message", "service"]


@cache
def flavour() -> Flavour:
    """What the classes are made of."""
    made: Flavour = import_module("genpy.message").FLAVOUR  # our own, in modules/
    return made


def message(name: str) -> Any:
    """The class of "package/Type".

    Raises:
        DefinitionError: There is none, or its definition is wrong.
    """
    return message_class(name, library(), flavour=flavour())


def service(name: str) -> Any:
    """The class of a service, as `message`; it names the file that genpy would have written it to."""
    made = service_class(name, library(), flavour=flavour())
    package, _, base = name.partition("/")
    made.__module__ = f"{package}.srv._{base}"
    return made


def is_known(cls: Any) -> bool:
    """True for a class made from a definition; False for one that genpy generated."""
    return isinstance(cls, type) and issubclass(cls, Message)


class Encoded:
    """A message that is bytes already; the node takes it in a message's place."""

    __slots__ = ("_data", "_type")

    def __init__(self, type_name: str, data: bytes) -> None:
        self._type = type_name
        self._data = data

    def _encode(self) -> bytes:
        return self._data


@cache
def carried(cls: Any) -> Any:
    """What a node is given in place of a message class: itself, or for one made by genpy a stand-in.

    A stand-in has genpy's names for the wire, and the three functions that the node calls; what they return
    and take are instances of the foreign class.
    """
    if is_known(cls):
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
            "_has_views": False,  # what it decodes is copied first
            "_binding": None,
            "_encode": staticmethod(encode),
            "_decode": staticmethod(decode),
            "_whole": staticmethod(lambda data: decode(data, 0, len(data))),
            "__slots__": tuple(cls.__slots__),
        },
    )


@cache
def carried_service(cls: Any) -> Any:
    """The same for a service class."""
    if is_known(cls._request_class) and is_known(cls._response_class):
        return cls
    return type(
        cls.__name__,
        (),
        {
            "_type": cls._type,
            "_md5sum": cls._md5sum,
            "_request_class": carried(cls._request_class),
            "_response_class": carried(cls._response_class),
        },
    )
