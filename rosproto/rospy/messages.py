"""Message and service classes made from definitions, with genpy's values in place of numpy's.

The base of the classes and their values (genpy.Time, tuples, bytes, genpy's errors) are in `modules/genpy`.
This module combines them with the definitions, makes the modules of message packages, and adapts classes that
genpy generated to a node.
"""

from __future__ import annotations

import os
import sys
from functools import cache
from importlib import import_module
from importlib.machinery import ModuleSpec
from io import BytesIO
from types import ModuleType
from typing import Any

from rosproto.codec import Message, ServiceType, ValueStyle, message_class, service_class
from rosproto.errors import DefinitionError
from rosproto.protocol.framing import BytesLike
from rosproto.rospy.finder import library


@cache
def value_style() -> ValueStyle:
    """The value style of these classes: base, values and errors."""
    made: ValueStyle = import_module("genpy.message").FLAVOUR  # our own, in modules/
    return made


def message(name: str) -> type[Message]:
    """The class of "package/Type".

    Raises:
        DefinitionError: There is none, or its definition is wrong.
    """
    return message_class(name, library(), value_style=value_style())


def service(name: str) -> type[ServiceType]:
    """The class of a service, as `message`; it names the file that genpy would have written it to."""
    made = service_class(name, library(), value_style=value_style())
    package, _, base = name.partition("/")
    made.__module__ = f"{package}.srv._{base}"
    return made


class MessageModuleLoader:
    """Fills the modules `woosh_msgs`, `woosh_msgs.msg`, `woosh_msgs.msg._Battery`, according to their names.

    Their `__file__` is where genpy's code would be, beside the definitions; there is no such file. A class is
    made when it is first asked for and then stays in the module. `_Battery` is the module genpy would have
    written it to; pickles and `repr` of classes name it.
    """

    def create_module(self, spec: ModuleSpec) -> None:
        """Return None for an ordinary module."""

    def exec_module(self, module: ModuleType) -> None:
        """Give it `__getattr__`, `__dir__` and, for a single class, that class.

        Raises:
            ImportError: There is no such type.
        """
        parts = module.__name__.split(".")
        module.__file__ = _file(parts)
        if len(parts) == 1:
            return
        if len(parts) == 2:
            _open(module, *parts)
            return
        base = parts[2][1:]
        if not parts[2].startswith("_") or base not in _bases(parts[0], parts[1]):
            raise ModuleNotFoundError(f"No module named {module.__name__!r}", name=module.__name__)
        names = [base] if parts[1] == "msg" else [base, base + "Request", base + "Response"]
        for name in names:
            setattr(module, name, _made(parts[0], parts[1], name))


def _file(parts: list[str]) -> str:
    folder = library().folder(parts[0])
    if folder is None:  # definitions without a folder: where the bundled ones would be
        folder = os.path.join(os.path.dirname(__file__), "..", "..", "msgdefs", parts[0])
    inside = [*parts[1:2], parts[2] + ".py"] if len(parts) > 2 else [*parts[1:], "__init__.py"]
    return os.path.abspath(os.path.join(folder, *inside))


def _open(module: ModuleType, package: str, kind: str) -> None:
    def get(name: str) -> object:
        if name == "__all__":  # asked for by `from ... import *`
            return _listed(package, kind)
        if name.startswith("_") and name[1:] in _bases(package, kind):
            return import_module(f"{module.__name__}.{name}")
        missing = AttributeError(f"module {module.__name__!r} has no attribute {name!r}", name=name)
        if name.startswith("__"):
            raise missing
        try:
            found = _made(package, kind, name)
        except DefinitionError as error:
            if error.file is not None:
                raise  # an invalid definition is not a missing name
            raise missing from None
        setattr(module, name, found)
        return found

    def listing() -> list[str]:
        return sorted({*vars(sys.modules[module.__name__]), *_listed(package, kind)})

    vars(module).update(__getattr__=get, __dir__=listing)


def _bases(package: str, kind: str) -> list[str]:
    """Names of a package's definitions of one kind."""
    known = library()
    names = known.messages(package) if kind == "msg" else known.services(package)
    return [name.partition("/")[2] for name in names]


def _listed(package: str, kind: str) -> list[str]:
    """Return the names of the module's classes."""
    suffixes = ("",) if kind == "msg" else ("", "Request", "Response")
    return [base + suffix for base in _bases(package, kind) for suffix in suffixes]


def _made(package: str, kind: str, name: str) -> type:
    """The class of that name.

    Raises:
        DefinitionError: There is none.
    """
    if kind == "msg":
        return message(f"{package}/{name}")
    known = _bases(package, kind)
    for suffix in ("Request", "Response"):
        base = name.removesuffix(suffix)
        if base != name and base in known:
            made = service(f"{package}/{base}")
            return made.Request if suffix == "Request" else made.Response
    return service(f"{package}/{name}")


# -- classes that genpy generated ----------------------------------------------------------------------------


def is_ours(cls: object) -> bool:
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

    def decode(data: BytesLike, start: int, end: int) -> object:
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
