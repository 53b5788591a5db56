"""Where the stand-ins for ROS's modules come from: files in `modules/`, or all of them in one file.

In the source tree and in an editable installation each is a file. A wheel would spend more on the names,
checksums and separate compression of a hundred files than on a good part of their texts; so its build
(`hatch_build.py`) puts them into `modules.bz2`, as it does with the definitions (see `rosproto.msg.packed`),
without comments and docstrings.
"""

from __future__ import annotations

import functools
import importlib.util
import os
from importlib.machinery import ModuleSpec
from types import CodeType, ModuleType
from typing import Any

from rosproto.msg.packed import PackedTree

__all__ = ["MODULES", "FileStock", "PackedStock", "stock"]

MODULES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "modules")
PACK = "modules.bz2"


class FileStock:
    """The modules as files."""

    def names(self) -> frozenset[str]:
        """Names of all top-level modules."""
        return frozenset(
            entry.name if entry.is_dir() else entry.name.removesuffix(".py")
            for entry in os.scandir(MODULES)
            if not entry.name.startswith(("_", ".")) and (entry.is_dir() or entry.name.endswith(".py"))
        )

    def spec(self, name: str, *parts: str) -> ModuleSpec | None:
        """How to load the module or package that lies at these parts of a path; None when there is none."""
        place = os.path.join(MODULES, *parts)
        package = os.path.join(place, "__init__.py")
        if os.path.isfile(package):
            return importlib.util.spec_from_file_location(name, package, submodule_search_locations=[place])
        return (
            importlib.util.spec_from_file_location(name, place + ".py")
            if os.path.isfile(place + ".py")
            else None
        )


class PackedStock:
    """The modules in one text; their paths are what the files' would be."""

    def __init__(self, text: str) -> None:
        self._tree = PackedTree("rosproto.rospy.modules", text)

    def names(self) -> frozenset[str]:
        """Names of all top-level modules."""
        return frozenset(name.removesuffix(".py") for name in self._tree.names() if not name.startswith("_"))

    def spec(self, name: str, *parts: str) -> ModuleSpec | None:
        """How to load the module or package that lies at these parts of a path; None when there is none."""
        package = "__init__.py" in self._tree.names(*parts)
        file = (*parts, "__init__.py") if package else (*parts[:-1], f"{parts[-1]}.py")
        if file[-1] not in self._tree.names(*file[:-1]):
            return None
        loader: Any = PackedLoader(self._tree.read(*file), os.path.join(MODULES, *file))
        inside = [os.path.join(MODULES, *parts)] if package else None
        return importlib.util.spec_from_file_location(
            name, loader.path, loader=loader, submodule_search_locations=inside
        )


class PackedLoader:
    """Loads one module from its text. Tracebacks and `inspect` ask it for the lines."""

    def __init__(self, source: str, path: str) -> None:
        self.path = path
        self._source = source

    def create_module(self, spec: ModuleSpec) -> None:
        """Python's own kind of module will do."""

    def exec_module(self, module: ModuleType) -> None:
        """Run it."""
        exec(self.get_code(module.__name__), vars(module))

    def get_code(self, name: str) -> CodeType:
        """The module, compiled."""
        code: CodeType = compile(self._source, self.path, "exec", dont_inherit=True)
        return code

    def get_source(self, name: str) -> str:
        """The module's text."""
        return self._source

    def is_package(self, name: str) -> bool:
        """Whether it has modules inside."""
        return os.path.basename(self.path) == "__init__.py"


@functools.cache
def stock() -> FileStock | PackedStock:
    """What this installation has: the pack, wherever Python has this module from, or else the files."""
    loader: Any = __spec__.loader
    try:
        packed = loader.get_data(os.path.join(os.path.dirname(MODULES), PACK))
    except OSError:
        return FileStock()
    import bz2

    return PackedStock(bz2.decompress(packed).decode())
