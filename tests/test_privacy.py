"""A name that begins with an underscore belongs to the file that defines it, and to classes that inherit it.

The modules of the rospy layer (`rosproto/rospy/modules`) keep to it, too: among themselves they use public names.
What rospy, tf2 and others call `_name`, and programs reach for, is a second name of a public one, given in the
module where programs look for it (`_TopicImpl` in rospy.topics).
"""

from __future__ import annotations

import ast
import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

import pytest

from rosproto.codec import Message

pytestmark = [pytest.mark.structure, pytest.mark.slow]  # the first one reads all sources

ROOT = Path(__file__).resolve().parent.parent

PUBLIC_IN_SPITE = frozenset(
    [
        # Of a message class: all names without an underscore are for its fields. What it documents is public.
        *re.findall(r"^ {8}(_\w+):", Message.__doc__ or "", re.MULTILINE),
        # Given to each message class when it is made: its decoder.
        "_decode",
        # Of genpy: AnyMsg, messages, and services.
        *("_buff", "_check_types", "_get_types", "_request_class", "_response_class"),
        # Of the standard library, which documents them.
        *("_replace", "_asdict", "_fields", "_make", "_getframe", "_current_frames", "_exit"),
        "_testMethodName",  # of a unittest.TestCase, by which rosunit reports a test
    ]
)
"""Public names that begin with an underscore."""

ACCESSORS = {"getattr", "setattr", "delattr", "hasattr"}


@dataclass
class Source:
    """One file: what it defines, by which names it imports others, and which classes stand on which."""

    module: str
    tree: ast.Module
    package: str
    imports: dict[str, str] = field(default_factory=dict)
    bases: set[str] = field(default_factory=set)
    own: set[str] = field(default_factory=set)


def private(name: str) -> bool:
    """`_name`; not `__name__`, nor the `_name_` of enum and ctypes, which they document."""
    return name.startswith("_") and not name.endswith("_")


def module_name(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def read(text: str, module: str, *, is_package: bool = False) -> Source:
    """What one file says about itself."""
    tree = ast.parse(text)
    source = Source(module, tree, module if is_package else module.rpartition(".")[0])
    for node in ast.walk(tree):
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)):
            source.own.add(node.name)
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            source.own.add(node.id)
        elif isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store) and own_object(node.value):
            source.own.add(node.attr)
        if isinstance(node, ast.ClassDef):
            source.bases.update(ast.unparse(base).partition("[")[0] for base in node.bases)
            source.own.update(slots(node))
        elif isinstance(node, ast.ImportFrom):
            origin = origin_of(node, source.package)
            source.imports.update(
                {alias.asname or alias.name: f"{origin}.{alias.name}" for alias in node.names}
            )
        elif isinstance(node, ast.Import):
            source.imports.update({alias.asname or alias.name: alias.name for alias in node.names})
    return source


def slots(node: ast.ClassDef) -> Iterator[str]:
    """Names in the `__slots__` of a class."""
    for statement in node.body:
        if isinstance(statement, ast.Assign) and ast.unparse(statement.targets[0]) == "__slots__":
            for part in ast.walk(statement.value):
                if isinstance(part, ast.Constant) and isinstance(part.value, str):
                    yield part.value


def origin_of(node: ast.ImportFrom, package: str) -> str:
    """The module that a `from ... import` names, relative ones resolved."""
    if not node.level:
        return node.module or ""
    parts = package.split(".")
    return ".".join([*parts[: len(parts) - node.level + 1], *([node.module] if node.module else [])])


def own_object(node: ast.expr) -> bool:
    """Whether an expression is the object (or its class) that a method belongs to."""
    text = ast.unparse(node)
    return text in {"self", "cls", "type(self)"} or text.startswith("super(")


FILES = {
    module_name(path): path
    for package in ("msgdefs", "rosproto", "woosh_pure")
    for path in sorted((ROOT / package).rglob("*.py"))
}


@cache
def project() -> dict[str, Source]:
    return {
        module: read(path.read_text("utf-8"), module, is_package=path.name == "__init__.py")
        for module, path in FILES.items()
    }


def inherited(source: Source, seen: frozenset[str] = frozenset()) -> set[str]:
    """What a file defines itself, and what the files define that its classes have their bases from."""
    names = set(source.own)
    for base in source.bases:
        origin = source.imports.get(base) or source.imports.get(base.partition(".")[0], "")
        while origin and origin not in project():
            origin = origin.rpartition(".")[0]
        if origin and origin not in seen | {source.module}:
            names |= inherited(project()[origin], seen | {source.module})
            names |= reexported(project()[origin], base, seen | {source.module})
    return names


def reexported(source: Source, name: str, seen: frozenset[str]) -> set[str]:
    """Follow a base class through the package that only hands it on."""
    origin = source.imports.get(name.rpartition(".")[2], "").rpartition(".")[0]
    if origin in project() and origin not in seen:
        return inherited(project()[origin], seen | {source.module})
    return set()


def reaches(source: Source) -> Iterator[str]:
    """Each use of a private name that the file neither defines nor inherits."""
    known = inherited(source) | PUBLIC_IN_SPITE
    for node in ast.walk(source.tree):
        if isinstance(node, ast.Attribute) and private(node.attr) and not own_object(node.value):
            if node.attr not in known:
                yield f"{source.module}:{node.lineno} {ast.unparse(node)}"
        elif isinstance(node, ast.ImportFrom):
            origin = origin_of(node, source.package)
            for alias in node.names:
                if private(alias.name) and not part_of_the_same_package(f"{origin}.{alias.name}", source):
                    yield f"{source.module}:{node.lineno} from {origin} import {alias.name}"
            if private(origin.rpartition(".")[2]) and not part_of_the_same_package(origin, source):
                yield f"{source.module}:{node.lineno} from {origin} import ..."
        elif isinstance(node, ast.Import):
            for alias in node.names:
                if private(alias.name.rpartition(".")[2]):
                    yield f"{source.module}:{node.lineno} import {alias.name}"
        elif isinstance(node, ast.Call) and ast.unparse(node.func) in ACCESSORS:
            owner, name = node.args[0], ast.unparse(node.args[1]).strip("'")
            if private(name) and not own_object(owner) and name not in known:
                yield f"{source.module}:{node.lineno} {ast.unparse(node)}"


def part_of_the_same_package(module: str, source: Source) -> bool:
    """Whether `module` is a private file, and `source` stands in the folder that it is a part of."""
    folder = module.rpartition(".")[0]
    return module in project() and f"{source.package}.".startswith(f"{folder}.")


def test_a_file_uses_no_private_name_of_another() -> None:
    """A part is handed what it needs, or what it needs has a public name and a docstring."""
    assert len(project()) > 300
    assert [reach for source in project().values() for reach in reaches(source)] == []


@pytest.mark.parametrize(
    "text",
    [
        "def f(x): x._hidden()",
        "from rosproto.node.node import _hidden",
        "import os\nos._hidden",
        "class A:\n    def f(self): self.other._hidden = 1",
        "def f(x): setattr(x, '_hidden', 1)",
        "def f(x): getattr(x, '_hidden', None)",
        "from rosproto.rospy.modules.genpy._values import check_type",
        "from _md5 import md5",
        "import _socket",
    ],
)
def test_the_watch_sees_a_reach(text: str) -> None:
    """A check that cannot fail checks nothing."""
    assert len(list(reaches(read(text, "rosproto.wrong")))) == 1


@pytest.mark.parametrize(
    "text",
    [
        "class A:\n    def __init__(self): self._x = 1\n    def __eq__(self, other): return self._x == other._x",
        "class A:\n    __slots__ = ('_x',)\n\ndef f(a): return a._x",
        "class A:\n    def f(self): return self._of_a_base",
        "_table = {}\n\ndef f(): return _table",
        "def f(message): return message._type, message.__class__",
    ],
)
def test_the_watch_lets_a_file_use_what_is_its_own(text: str) -> None:
    """Two objects of one class, and a function beside its class, may know each other."""
    assert list(reaches(read(text, "rosproto.right"))) == []


OF_LIBRARIES = {
    "rosproto.cli.parser": {"_actions"},
}
"""Private parts of libraries (argparse) that are still used. This list only shrinks."""


LIBRARIES = re.compile(r"\b(paho|websockets|pyarrow|fastapi|starlette|uvicorn|mcap)\b")


def of_libraries(source: Source) -> set[str]:
    """Private names of a class that no file of ours defines; and those that a constant spells for `getattr`, in a
    file that uses a library."""
    found, spelled = set(), set()
    for node in ast.walk(source.tree):
        if isinstance(node, ast.Attribute) and private(node.attr) and own_object(node.value):
            found.add(node.attr)
        elif isinstance(node, ast.Assign) and isinstance(node.value, ast.Constant):
            spelled.add(str(node.value.value))
    spelled = {text for text in spelled if re.fullmatch(r"_[a-z]\w*[a-z]", text)}
    if spelled and LIBRARIES.search(ast.unparse(source.tree)):
        found |= spelled
    return found - inherited(source) - PUBLIC_IN_SPITE


def test_a_file_uses_no_private_part_of_a_library() -> None:
    """A library is used by its public face. What a file no longer uses is taken off the list."""
    found = {module: of_libraries(source) for module, source in project().items()}
    assert {module: parts for module, parts in found.items() if parts} == OF_LIBRARIES


@pytest.mark.parametrize(
    "text",
    [
        "import paho\nclass A(paho.Client):\n    def f(self): return self._in_packet",
        "import argparse\nclass A(argparse.ArgumentParser):\n    def f(self): self._actions.clear()",
        "import mcap\nTABLE = '_chunks_by_id'\ndef f(): return getattr(mcap.writer, TABLE)",
    ],
)
def test_the_watch_sees_a_reach_into_a_library(text: str) -> None:
    assert len(of_libraries(read(text, "rosproto.wrong"))) == 1


REACHES_OF_TESTS = 33
"""How often unit tests reach into private parts of what they test. A test shows what a room offers: this only shrinks."""


def reaches_of_tests() -> list[str]:
    """Each use of a private name that the test file does not define."""
    found = []
    for path in sorted((ROOT / "tests" / "unit").rglob("*.py")):
        source = read(path.read_text("utf-8"), path.stem)
        for node in (each for each in ast.walk(source.tree) if isinstance(each, ast.Attribute)):
            reaches = private(node.attr) and not own_object(node.value)
            if reaches and node.attr not in source.own | PUBLIC_IN_SPITE:
                found.append(f"{path.relative_to(ROOT)}:{node.lineno} {ast.unparse(node)}")
    return found


def test_unit_tests_reach_into_private_parts_no_more_often_than_before() -> None:
    """Write down the new number when there are fewer."""
    found = reaches_of_tests()
    assert len(found) <= REACHES_OF_TESTS, "\n".join(found)


if __name__ == "__main__":  # python -m tests.test_privacy: every reach, and how many each folder has
    lines = [line for source in project().values() for line in reaches(source)]
    print(*lines, sep="\n")
    for folder, count in sorted(
        Counter(".".join(line.split(":")[0].split(".")[:2]) for line in lines).items()
    ):
        print(f"{count:4} {folder}")
