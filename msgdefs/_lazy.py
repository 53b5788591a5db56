"""What stands behind `from msgdefs.geometry_msgs.msg import Twist`.

The module of a package's messages has no code of its own: a class is made from its definition when it is
first asked for, and then stays in the module like any other name. Importing it costs nothing but the file.
"""

from __future__ import annotations

import sys
from collections.abc import Callable

__all__ = ["lazy_module"]


def lazy_module(module: str) -> tuple[Callable[[str], object], Callable[[], list[str]]]:
    """Make the `__getattr__` and `__dir__` of such a module (PEP 562).

    Args:
        module: "msgdefs.<package>.msg" or "msgdefs.<package>.srv", the module's `__name__`.
    """
    package, kind = module.split(".")[-2:]
    look_up = _message if kind == "msg" else _service

    def get(name: str) -> object:
        if name == "__all__":  # asked for by `from ... import *`
            return _names(package, kind)
        # Python asks modules for many names of its own; none of them is worth a look into the files.
        if name.startswith("_"):
            raise AttributeError(f"module {module!r} has no attribute {name!r}", name=name)
        from rosproto.errors import DefinitionError

        try:
            found = look_up(package, name)
        except DefinitionError as error:
            if error.file is not None:
                raise  # the definition is there, but wrong: not to be taken for a missing name
            raise AttributeError(f"module {module!r} has no {name!r}: {error}", name=name) from error
        setattr(sys.modules[module], name, found)
        return found

    def listing() -> list[str]:
        return sorted({*vars(sys.modules[module]), *_names(package, kind)})

    return get, listing


def _message(package: str, name: str) -> object:
    from rosproto.codec import message_class

    return message_class(f"{package}/{name}")


def _service(package: str, name: str) -> object:
    from rosproto.codec import service_class
    from rosproto.msg import bundled

    services = bundled().services(package)
    for suffix in ("Request", "Response"):
        base = name.removesuffix(suffix)
        if base != name and f"{package}/{base}" in services:
            return getattr(service_class(f"{package}/{base}"), suffix)
    return service_class(f"{package}/{name}")


def _names(package: str, kind: str) -> list[str]:
    from rosproto.msg import bundled

    library = bundled()
    if kind == "msg":
        return [name.partition("/")[2] for name in library.messages(package)]
    bases = [name.partition("/")[2] for name in library.services(package)]
    return [base + suffix for base in bases for suffix in ("", "Request", "Response")]
