"""Read definition files: from folders in ROS layout, and from the package data that ships with rosproto.

Folders are listed before a file is read: file names on Windows and macOS ignore case, but `std_msgs/string`
    is not a type.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from functools import cached_property
from importlib import import_module
from typing import Protocol

from rosproto.errors import DefinitionError
from rosproto.files import read_file
from rosproto.names import is_legal_base_name
from rosproto.sentence import both, say

KINDS = ("msg", "srv", "action")
SEARCH_DEPTH = 6
"""Maximum depth of packages below a search path: workspace/src/repository/stack/package is four."""


class Tree(Protocol):
    """A tree of files, named by the parts of their path."""

    def names(self, *parts: str) -> frozenset[str]:
        """Names of the files and folders in a folder; empty when there is no such folder."""

    def read(self, *parts: str) -> str:
        """Text of a file, line ends as line feeds, bytes that are not UTF-8 kept as surrogates."""

    def describe(self, *parts: str) -> str:
        """The file's name for error messages."""


class FileTree:
    """Files below a folder."""

    def __init__(self, root: str) -> None:
        self.root = root

    def names(self, *parts: str) -> frozenset[str]:
        try:
            return frozenset(os.listdir(os.path.join(self.root, *parts)))
        except OSError:
            return frozenset()

    def read(self, *parts: str) -> str:
        path = self.describe(*parts)
        try:
            return _text(read_file(path))
        except OSError as error:
            raise DefinitionError(say("cannot be read: {why}", why=error.strerror), file=path) from error
        except ValueError as error:
            raise DefinitionError(str(error), file=path) from error

    def describe(self, *parts: str) -> str:
        return os.path.join(self.root, *parts)


class ResourceTree:
    """Data files of an importable package that is not a plain folder: in a zip, or in a frozen program."""

    def __init__(self, package: str) -> None:
        from importlib.resources import files  # takes 5 to 15 ms to import

        self.package = package
        self._files = files(package)

    def names(self, *parts: str) -> frozenset[str]:
        try:
            return frozenset(entry.name for entry in self._files.joinpath("/".join(parts)).iterdir())
        except (OSError, ValueError, KeyError):  # loaders differ in the error for a missing folder
            return frozenset()

    def read(self, *parts: str) -> str:
        try:
            return _text(self._files.joinpath("/".join(parts)).read_bytes())
        except OSError as error:
            raise DefinitionError(f"cannot be read: {error}", file=self.describe(*parts)) from error

    def describe(self, *parts: str) -> str:
        return "/".join((self.package, *parts))


def _text(data: bytes) -> str:
    text = data.decode("utf-8", "surrogateescape")
    return text.replace("\r\n", "\n").replace("\r", "\n") if "\r" in text else text


class Folder:
    """One package's folder: `msg/*.msg`, `srv/*.srv`, `action/*.action`.

    It may also contain `aliases.txt` (lines `other = Name`: a second name for the same definition, and
    `Name.other = field`: a second name for a field) and `revisions/` (see rosproto.msg.package_revisions).
    """

    def __init__(self, tree: Tree, *parts: str) -> None:
        self.tree = tree
        self.parts = parts
        self._names: dict[str, frozenset[str]] = {}

    @property
    def path(self) -> str | None:
        """Path in the file system; None in a zip or frozen program."""
        root = getattr(self.tree, "root", None)
        found = None if root is None else os.path.join(root, *self.parts)
        return found if found is not None and os.path.isdir(found) else None

    def names(self, kind: str) -> frozenset[str]:
        """Base names of all definitions of a kind, including aliases."""
        found = self._names.get(kind)
        if found is None:
            bases = (
                base
                for base, dot, end in (n.rpartition(".") for n in self.tree.names(*self.parts, kind))
                if end == kind
            )
            direct = frozenset(base for base in bases if is_legal_base_name(base))
            found = direct | {other for other, name in self.aliases().items() if name in direct}
            self._names[kind] = found
        return found

    def read(self, kind: str, base: str) -> tuple[str, str] | None:
        """Text and origin of one definition; None if missing."""
        if base not in self.names(kind):
            return None
        parts = (*self.parts, kind, f"{self.aliases().get(base, base)}.{kind}")
        return self.tree.read(*parts), self.tree.describe(*parts)

    def aliases(self) -> dict[str, str]:
        """Aliases of types: alias -> name of the definition."""
        return {other: name for other, name in self._alias_lines if "." not in other}

    def field_aliases(self, base: str) -> list[tuple[str, str]]:
        """Pairs of names of the same field of a message."""
        return [
            (other.partition(".")[2], name)
            for other, name in self._alias_lines
            if other.partition(".")[0] == base and "." in other
        ]

    @cached_property
    def _alias_lines(self) -> list[tuple[str, str]]:
        if "aliases.txt" not in self.tree.names(*self.parts):
            return []
        lines = self.tree.read(*self.parts, "aliases.txt").split("\n")
        pairs = [line.partition("#")[0].partition("=") for line in lines]
        return [(other.strip(), name.strip()) for other, equals, name in pairs if equals]


class DefinitionSource:
    """Folders by package; the first folder with a definition takes precedence."""

    def __init__(self, where: str, folders: dict[str, list[Folder]]) -> None:
        self.where = where
        self.folders = folders

    def read(self, package: str, kind: str, base: str) -> tuple[str, str] | None:
        for folder in self.folders.get(package, ()):
            found = folder.read(kind, base)
            if found is not None:
                return found
        return None

    def names(self, package: str, kind: str) -> set[str]:
        return {name for folder in self.folders.get(package, ()) for name in folder.names(kind)}


def bundled_source() -> DefinitionSource:
    """The definitions that ship as package data in `msgdefs`."""
    # Imported by name: the package's modules import the codec, a layer above; only its texts are used.
    root = import_module("msgdefs").__path__[0]
    tree: Tree = FileTree(root) if os.path.isdir(root) else ResourceTree("msgdefs")
    return DefinitionSource(
        "msgdefs", {name: [Folder(tree, name)] for name in tree.names() if is_legal_base_name(name)}
    )


def folder_source(path: str | os.PathLike[str]) -> DefinitionSource:
    """Definitions in a folder: a package, a folder of packages (`share`), or a workspace with packages below.

    Raises:
        DefinitionError: The folder does not exist or contains no definition.
    """
    root = os.fspath(path)
    if not os.path.isdir(root):
        raise DefinitionError(
            "is not a folder; expected a package, a folder of packages or a workspace", file=root
        )
    folders: dict[str, list[Folder]] = {}
    for found in _package_folders(root):
        folders.setdefault(_package_name(found), []).append(Folder(FileTree(found)))
    if not folders:
        none = say("no definitions found up to {depth} folders below", depth=SEARCH_DEPTH)
        expected = "expected <package>/msg/*.msg, <package>/srv/*.srv or <package>/action/*.action"
        raise DefinitionError(both(none, expected), file=root)
    return DefinitionSource(root, folders)


def _package_folders(root: str) -> Iterator[str]:
    depth = root.rstrip(os.sep).count(os.sep)
    for folder, below, files in os.walk(root):
        if "CATKIN_IGNORE" in files:
            below[:] = []
            continue
        if any(kind in below and _has_definitions(os.path.join(folder, kind), kind) for kind in KINDS):
            yield folder
            below[:] = []
        elif folder.count(os.sep) - depth >= SEARCH_DEPTH:
            below[:] = []
        below[:] = sorted(name for name in below if not name.startswith("."))


def _has_definitions(folder: str, kind: str) -> bool:
    return any(name.endswith("." + kind) for name in os.listdir(folder))


def _package_name(folder: str) -> str:
    """The name in package.xml if it exists (a check-out may have any name), else the folder's name."""
    try:
        with open(os.path.join(folder, "package.xml"), encoding="utf-8", errors="replace") as file:
            name = file.read().partition("<name>")[2].partition("</name>")[0].strip()
    except OSError:
        name = ""
    return name or os.path.basename(os.path.abspath(folder))
