"""The modules of message packages: `woosh_msgs`, `woosh_msgs.msg`, `woosh_msgs.msg._Battery`, and for srv.

Their `__file__` is where genpy's code would be, beside the definitions; there is no such file. A class is
made when it is first asked for and then stays in the module. `_Battery` is the module genpy would have
written it to; pickles and `repr` of classes name it.
"""

from __future__ import annotations

import os
import sys
from importlib import import_module
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Any

from rosproto.errors import DefinitionError
from rosproto.rospy import messages
from rosproto.rospy.definitions import library


class MessageModuleLoader:
    """Fills a module according to its name."""

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
        if not parts[2].startswith("_") or base not in bases(parts[0], parts[1]):
            raise ModuleNotFoundError(f"No module named {module.__name__!r}", name=module.__name__)
        names = [base] if parts[1] == "msg" else [base, base + "Request", base + "Response"]
        for name in names:
            setattr(module, name, made(parts[0], parts[1], name))


def _file(parts: list[str]) -> str:
    folder = library().folder(parts[0])
    if folder is None:  # definitions without a folder: where the bundled ones would be
        folder = os.path.join(
            os.path.dirname(os.path.dirname(os.path.dirname(__file__))), "msgdefs", parts[0]
        )
    inside = [*parts[1:2], parts[2] + ".py"] if len(parts) > 2 else [*parts[1:], "__init__.py"]
    return os.path.abspath(os.path.join(folder, *inside))


def _open(module: ModuleType, package: str, kind: str) -> None:
    def get(name: str) -> Any:
        if name == "__all__":  # asked for by `from ... import *`
            return listed(package, kind)
        if name.startswith("_") and name[1:] in bases(package, kind):
            return import_module(f"{module.__name__}.{name}")
        if name.startswith("__"):
            raise AttributeError(f"module {module.__name__!r} has no attribute {name!r}", name=name)
        try:
            found = made(package, kind, name)
        except DefinitionError as error:
            if error.file is not None:
                raise  # an invalid definition is not a missing name
            raise AttributeError(f"module {module.__name__!r} has no attribute {name!r}", name=name) from None
        setattr(module, name, found)
        return found

    def listing() -> list[str]:
        return sorted({*vars(sys.modules[module.__name__]), *listed(package, kind)})

    vars(module).update(__getattr__=get, __dir__=listing)


def bases(package: str, kind: str) -> list[str]:
    """Names of a package's definitions of one kind."""
    known = library()
    names = known.messages(package) if kind == "msg" else known.services(package)
    return [name.partition("/")[2] for name in names]


def listed(package: str, kind: str) -> list[str]:
    """Return the names of the module's classes."""
    suffixes = ("",) if kind == "msg" else ("", "Request", "Response")
    return [base + suffix for base in bases(package, kind) for suffix in suffixes]


def made(package: str, kind: str, name: str) -> Any:
    """The class of that name.

    Raises:
        DefinitionError: There is none.
    """
    if kind == "msg":
        return messages.message(f"{package}/{name}")
    known = bases(package, kind)
    for suffix in ("Request", "Response"):
        base = name.removesuffix(suffix)
        if base != name and base in known:
            return getattr(messages.service(f"{package}/{base}"), suffix)
    return messages.service(f"{package}/{name}")
