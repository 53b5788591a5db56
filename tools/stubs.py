"""Type stubs for the modules of msgdefs, so that an IDE completes `msg.pose.pose.position.x`.

`python -m tools.stubs` writes `msgdefs/<package>/msg/__init__.pyi` and `.../srv/__init__.pyi` anew;
`--check` writes nothing and exits with 1 when one of them is not current.
"""

from __future__ import annotations

import keyword
import os
import sys
from collections.abc import Iterator
from importlib import import_module

from rosproto.msg.library import DefinitionLibrary, bundled
from rosproto.msg.parser import ACTION_BANNER
from rosproto.msg.spec import Constant, Field, FieldType, MessageSpec, ServiceSpec

__all__ = ["main", "message_stub", "service_stub", "stub_files"]

BANNER = "# Written by `python -m tools.stubs`; change the definitions instead.\n"

SCALARS = {
    **dict.fromkeys(("int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64"), "int"),
    **dict.fromkeys(("char", "byte"), "int"),
    **dict.fromkeys(("float32", "float64"), "float"),
    "bool": "bool",
    "string": "str",
    "time": "_Time",
    "duration": "_Duration",
}
ARRAYS = {
    "bool": ("BooleanArray", "Booleans"),
    "float32": ("Float32Array", "Floats"),
    "float64": ("Float64Array", "Floats"),
    "byte": ("Int8Array", "Integers"),
    "int8": ("Int8Array", "Integers"),
    "int16": ("Int16Array", "Integers"),
    "int32": ("Int32Array", "Integers"),
    "int64": ("Int64Array", "Integers"),
    "char": ("UInt8Array", "Octets"),
    "uint8": ("UInt8Array", "Octets"),
    "uint16": ("UInt16Array", "Integers"),
    "uint32": ("UInt32Array", "Integers"),
    "uint64": ("UInt64Array", "Integers"),
}
"""Numbers: the type of the field, and of what may be given for it (msgdefs/_fields.pyi)."""
ENVELOPES = (
    {"action_goal", "action_result", "action_feedback"},
    {"header", "goal_id", "goal"},
    {"header", "status", "result"},
    {"header", "status", "feedback"},
)


class _Module:
    """One stub file: its classes and their imports."""

    def __init__(self, package: str, kind: str) -> None:
        self.package = package
        self.kind = kind
        self.fields: set[str] = set()
        self.modules: set[str] = set()
        self.times: set[str] = set()
        self.aliases: set[str] = set()
        self.needs: set[str] = set()
        self.builtins = False
        self.classes: list[str] = []

    def text(self) -> str:
        """The whole file."""
        what = "Messages" if self.kind == "msg" else "Services"
        parts = [BANNER, f'"""{what} of {self.package} as classes."""\n\n', *self._imports()]
        parts += [f"\n{text}" for text in self.classes]
        parts += [f"\n_{name} = {name}\n" for name in sorted(self.aliases)]
        return "".join(parts)

    def _imports(self) -> Iterator[str]:
        standard = [
            "import builtins as _builtins\n" if self.builtins else "",
            "from collections.abc import Sequence as _Sequence\n" if "Sequence" in self.needs else "",
        ]
        typing = [f"{name} as _{name}" for name in ("ClassVar", "TypeAlias") if name in self.needs]
        standard.append(f"from typing import {', '.join(typing)}\n" if typing else "")
        if any(standard):
            yield "".join(standard) + "\n"
        for name in sorted(self.modules):
            yield f"import msgdefs.{name}.msg as _{name}\n"
        for name in sorted(self.fields):
            yield f"from msgdefs._fields import {name} as _{name}\n"
        yield "from rosproto.codec import Message as _Message\n"
        if self.kind == "srv":
            yield "from rosproto.codec import ServiceType as _ServiceType\n"
        for name in sorted(self.times):
            yield f"from rosproto.time import {name} as _{name}\n"

    # Types

    def one(self, base: str, taken: frozenset[str]) -> str:
        """The type of a single value; `taken` are names with another meaning inside the class."""
        known = SCALARS.get(base)
        if known is not None:
            if known.startswith("_"):
                self.times.add(known[1:])
            elif known in taken:
                self.builtins = True
                return f"_builtins.{known}"
            return known
        package, _, name = base.partition("/")
        if package != self.package or self.kind == "srv":
            self.modules.add(package)
            return f"_{package}.{name}"
        if name in taken:
            self.aliases.add(name)
            return f"_{name}"
        return name

    def attribute(self, kind: FieldType, taken: frozenset[str]) -> str:
        """The type of a field."""
        if not kind.is_array:
            return self.one(kind.base, taken)
        if kind.base in ARRAYS:
            self.fields.add(ARRAYS[kind.base][0])
            return f"_{ARRAYS[kind.base][0]}"
        if "list" in taken:
            self.builtins = True
        return f"{'_builtins.' if 'list' in taken else ''}list[{self.one(kind.base, taken)}]"

    def argument(self, kind: FieldType, taken: frozenset[str]) -> str:
        """The type of the constructor's argument for a field."""
        if not kind.is_array:
            return self.one(kind.base, taken)
        if kind.base in ARRAYS:
            self.fields.add(ARRAYS[kind.base][1])
            return f"_{ARRAYS[kind.base][1]}"
        self.needs.add("Sequence")
        return f"_Sequence[{self.one(kind.base, taken)}]"

    # Classes

    def message(self, spec: MessageSpec) -> None:
        """Add the class of a message."""
        taken = frozenset(field.name for field in spec.fields) | {c.name for c in spec.constants}
        text = "" if _is_envelope(spec) else spec.text
        lines = [f"class {spec.name.partition('/')[2]}(_Message):", *_docstring(spec.name, text)]
        lines += [
            self._constant(constant, taken) for constant in spec.constants if constant.name.isidentifier()
        ]
        for field in spec.fields:
            declared = f"{field.name}: {self.attribute(field.type, taken)}"
            if keyword.iskeyword(field.name):
                declared = f'# {declared}  # a Python keyword: getattr(message, "{field.name}")'
            lines.append("    " + declared)
        lines += self._constructor(spec.fields, taken)
        self.classes.append("\n".join(lines) + "\n")

    def _constant(self, constant: Constant, taken: frozenset[str]) -> str:
        self.needs.add("ClassVar")
        if keyword.iskeyword(constant.name):
            return f"    # {constant.name} = {constant.text}  # a Python keyword: use getattr"
        value = repr(constant.value)
        value = "..." if value.strip("-") in ("inf", "nan") or not value.isascii() else value
        return f"    {constant.name}: _ClassVar[{self.one(constant.type, taken)}] = {value}"

    def _constructor(self, fields: tuple[Field, ...], taken: frozenset[str]) -> Iterator[str]:
        me = "_self" if "self" in taken else "self"
        if not fields:
            yield f"    def __init__({me}) -> None: ..."
            return
        yield "    def __init__("
        yield f"        {me},"
        hidden = False
        for field in fields:
            if keyword.iskeyword(field.name):
                hidden = True
                continue
            # By position all fields are given, so what stands behind a hidden one goes by keyword only.
            yield f"        {field.name}: {self.argument(field.type, taken)} = ...,"
        if hidden:
            yield "        **others: object,"
        yield "    ) -> None: ..."

    def service(self, spec: ServiceSpec) -> None:
        """Add the classes of a service: request, response, and the one that holds both."""
        self.message(spec.request)
        self.message(spec.response)
        self.needs.add("TypeAlias")
        base = spec.name.partition("/")[2]
        lines = [f"class {base}(_ServiceType):", *_docstring(spec.name, "")]  # its parts say it all
        lines += [f"    {part}: _TypeAlias = {base}{part}" for part in ("Request", "Response")]
        self.classes.append("\n".join(lines) + "\n")


def _is_envelope(spec: MessageSpec) -> bool:
    """Whether it is one of the four that are made around the parts of an action, all alike."""
    return spec.text.startswith(ACTION_BANNER) and {field.name for field in spec.fields} in ENVELOPES


def _docstring(name: str, text: str) -> Iterator[str]:
    """The definition, as an IDE shows it; nothing of it where that is empty."""
    yield f'    """{name}'
    text = text.replace(ACTION_BANNER, "")
    body = text.replace("\\", "\\\\").replace('"""', '\\"\\"\\"').strip("\n")
    if body.strip():
        yield ""
    for line in body.split("\n") if body.strip() else ():
        yield ("    " + line).rstrip()
    yield '    """'
    yield ""


def message_stub(package: str, library: DefinitionLibrary) -> str:
    """The stub of a package's messages; empty when it has none."""
    module = _Module(package, "msg")
    for name in library.messages(package):
        module.message(library.message(name))
    return module.text() if module.classes else ""


def service_stub(package: str, library: DefinitionLibrary) -> str:
    """The stub of a package's services; empty when it has none."""
    module = _Module(package, "srv")
    for name in library.services(package):
        module.service(library.service(name))
    return module.text() if module.classes else ""


def stub_files(library: DefinitionLibrary) -> dict[str, str]:
    """All stubs of a library: text by path below msgdefs, with forward slashes."""
    found = {}
    for package in library.packages():
        found[f"{package}/msg/__init__.pyi"] = message_stub(package, library)
        found[f"{package}/srv/__init__.pyi"] = service_stub(package, library)
    return {path: text for path, text in found.items() if text}


def main(arguments: list[str]) -> int:
    """Write the stubs, or list the outdated ones with `--check`."""
    if arguments not in ([], ["--check"]):
        sys.stderr.write("usage: python -m tools.stubs [--check]\n")
        return 2
    root = import_module("msgdefs").__path__[0]
    stale = 0
    for path, text in sorted(stub_files(bundled()).items()):
        file = os.path.join(root, *path.split("/"))
        if _read(file) == text:
            continue
        stale += 1
        if arguments:
            sys.stdout.write(f"not current: {file}\n")
        else:
            with open(file, "w", encoding="utf-8", newline="\n") as out:
                out.write(text)
    sys.stdout.write(f"{stale} stubs {'not current' if arguments else 'written'}\n")
    return 1 if stale and arguments else 0


def _read(file: str) -> str | None:
    try:
        with open(file, encoding="utf-8") as source:  # line ends of a Windows check-out are not a change
            return source.read()
    except OSError:
        return None


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
