"""Definitions: what genmsg reads of a text, and what genpy makes of a text with sections."""

from __future__ import annotations

import random
from typing import Any

from rosproto.codec import decode, define, encode, strify_message
from rosproto.errors import CodecError, DefinitionError
from rosproto.msg import DefinitionLibrary, parse_message, parse_service
from tests.interop.compare.comparison import Answer, Case, Kind, Peer

ALPHABET = [
    "int8", "uint8", "char", "byte", "bool", "string", "float32", "time", "Header", "U", "p/U", "std_msgs/Header", "header",
    "a", "b", "A", "X1", "_", "=", "=", " = ", "#", "[]", "[3]", "[0]", "[", "]", "1", "-1", "255", "256", "1.5", "True", "'x'",
    " ", " ", " ", " ", "  ", "\n", "\n", "\n", "\r\n", "\t", "---\n", "/", ".", "\\", '"', "\r", "\x0b", "\x0c", "\u00a0", "\u2028",
]  # fmt: skip
USED = {"U": "int8 x # u\nint8 K=1\n", "V": "U u\nHeader header\n", "W": "X x", "X": "W[] w"}
HEADER = "uint32 seq\ntime stamp\nstring frame_id\n"


def message(text: str, **used: str) -> Case:
    types = {f"p/{name}": body for name, body in used.items()}
    return {"types": {"std_msgs/Header": HEADER, **types, "p/T": text}, "main": "p/T", "kind": "msg"}


def service(text: str, **used: str) -> Case:
    return {"types": {**message("", **used)["types"], "p/S": text}, "main": "p/S", "kind": "srv"}


def random_text(chance: random.Random) -> str:
    """Mostly lines that are nearly legal, some of them noise."""
    lines = []
    for _ in range(chance.randrange(6)):
        kind = chance.random()
        name = f"f{chance.randrange(8)}"
        array = chance.choice(["", "", "", "[]", "[2]", "[02]"])
        base = chance.choice(ALPHABET[:12])
        if kind < 0.5:
            lines.append(f"{base}{array} {name}" + chance.choice(["", "  # x", " #=", "\r"]))
        elif kind < 0.75:
            value = chance.choice(["1", "-1", "200", "300", "x # y", "1.5", "True", "", "'a'", "0x1"])
            lines.append(
                f"{base}{chance.choice([' ', '  '])}{name.upper()}{chance.choice(['=', ' = ', '= '])}{value}"
            )
        else:
            lines.append("".join(chance.choice(ALPHABET) for _ in range(chance.randrange(8))))
    return chance.choice(["\n", "\n", "\n", "\r\n"]).join(lines) + chance.choice(["", "\n"])


def unlike_anyone(text: str) -> bool:
    """True for the documented differences: a constant whose name no generator can use."""
    for line in text.split("\n"):
        clean = line.partition("#")[0].strip()
        left = clean.partition("=")[0].split()
        indented = line[:1] in " \t" and clean.startswith("string")
        if "=" in clean and (indented or len(left) != 2 or not left[1].isidentifier() or left[1][0] == "_"):
            return True
    return False


def read(case: Case) -> Answer:
    """Our library's reading of a definition."""
    library = DefinitionLibrary()
    name, kind = case["main"], case["kind"]
    try:
        for other, text in case["types"].items():
            parse = parse_service if other == name and kind == "srv" else parse_message
            library.add(parse(text, other))
        parts = [name] if kind == "msg" else [name + "Request", name + "Response"]
        specs = [library.message(part) for part in parts]
        return {
            "md5": library.md5sum(name, kind=kind),
            "full_text": [library.full_text(part) for part in parts],
            "fields": [[[str(f.type), f.name] for f in spec.fields] for spec in specs],
            "constants": [
                [[c.type, c.name, c.text, repr(c.value)] for c in spec.constants] for spec in specs
            ],
            "header": [spec.has_header for spec in specs],
        }
    except DefinitionError as error:
        return {"error": "DefinitionError", "says": str(error)}


class Definition(Kind):
    """Messages and services, read by our library."""

    asked = "definition"

    def draw(self, chance: random.Random) -> Case:
        if chance.random() < 0.3:
            return service(
                random_text(chance) + chance.choice(["---\n", "---\r\n", "--- \n"]) + random_text(chance),
                **USED,
            )
        return message(random_text(chance), **USED)

    def ours(self, case: Case) -> Answer:
        return read(case)


class DefinitionByLayer(Definition):
    """The same, read by the package genmsg of our layer."""

    def __init__(self, layer: Peer) -> None:
        self._layer = layer

    def ours(self, case: Case) -> Answer:
        return self._layer.ask(self.asked, case)


BASES = [
    "int8",
    "uint8",
    "int16",
    "uint32",
    "int64",
    "uint64",
    "float32",
    "float64",
    "bool",
    "byte",
    "char",
    "string",
    "time",
    "duration",
]
RULE = "=" * 80


class FullText(Kind):
    """Definitions with sections, as connection headers and bags carry them: classes, and bytes read by them."""

    asked = "full_text"

    def draw(self, chance: random.Random) -> Case:
        names = ["p/A", "q/B", "p/C", "std_msgs/Header"][: chance.randrange(5)]
        texts = {
            "p/T": self._body(chance, names),
            **{
                name: HEADER if "Header" in name else self._body(chance, names[:at])
                for at, name in enumerate(names)
            },
        }
        end = chance.choice(["\n", "\n", "\n", "\r\n"])
        parts = []
        for name, body in texts.items():
            head = (
                []
                if name == "p/T"
                else [
                    chance.choice([RULE, RULE, "=" * 40]),
                    chance.choice([f"MSG: {name}"] * 4 + [f"MSG:  {name}", f"MSG: {name} "]),
                ]
            )
            parts.append(end.join([*head, *body.split("\n")]))
        text = end.join(parts) + chance.choice(["", end])
        words = [
            b"\0\0\0\0",
            b"\1\0\0\0",
            b"\2\0\0\0",
            b"ABCD",
            b"\xe4\xb8\xad!",
            bytes([chance.randrange(256), chance.randrange(4), 0, 0]),
        ]
        data = b"".join(chance.choices(words, [9, 4, 4, 1, 1, 1], k=chance.choice([0, 2, 10, 30])))
        return {"main": "p/T", "text": text, "bytes": data.hex()}

    def _body(self, chance: random.Random, names: list[str]) -> str:
        lines = []
        for number in range(chance.randrange(5)):
            name = f"f{number}"
            kind = chance.random()
            if kind < 0.15:
                lines.append(
                    chance.choice(
                        [
                            f"int8 {name.upper()}=5",
                            f"string {name.upper()}= a # b ",
                            f"float32 {name.upper()}=1.5 # c",
                            f"bool {name.upper()}=1",
                        ]
                    )
                )
            elif kind < 0.25:
                lines.append(chance.choice(["", "# note", "   ", "  # ==", "#" + RULE, "# MSG: p/A"]))
            else:
                used = [
                    other
                    for other in (*names, *(n.partition("/")[2] for n in names if n[:2] in ("p/", "st")))
                    if other
                ]
                base = chance.choice(used) if used and chance.random() < 0.5 else chance.choice(BASES)
                lines.append(
                    chance.choice(["", "", "", " "])
                    + base
                    + chance.choice(["", "", "[]", "[2]"])
                    + chance.choice([" ", "  ", "\t"])
                    + name
                    + chance.choice(["", "", " # x", "#y", " "])
                )
        return "\n".join(lines)

    def ours(self, case: Case) -> Answer:
        try:
            cls = define(case["main"], case["text"])
        except (DefinitionError, CodecError) as error:
            return {"error": type(error).__name__, "says": str(error)}
        classes: dict[str, Any] = {}
        _collect(cls, classes)
        found = {
            name: [cls._md5sum, list(cls.__slots__), list(cls._slot_types)]
            for name, cls in sorted(classes.items())
        }
        try:
            made = decode(cls, bytes.fromhex(case["bytes"]))
            answer = {"text": strify_message(made), "bytes": encode(made).hex()}
        except CodecError as error:
            answer = {"error": "CodecError", "says": str(error)}
        return {"classes": found, "read": answer}

    def same(self, theirs: Answer, ours: Answer) -> bool:
        if (
            "classes" in theirs and "classes" in ours
        ):  # generate_dynamic makes classes of unused sections, too
            theirs = {
                **theirs,
                "classes": {k: v for k, v in theirs["classes"].items() if k in ours["classes"]},
            }
        return super().same(theirs, ours)


def _collect(cls: Any, found: dict[str, Any]) -> None:
    from rosproto.codec import message_class

    found[cls._type] = cls
    for kind in cls._slot_types:
        base = kind.partition("[")[0]
        if "/" in base and base not in found:
            _collect(message_class(base, cls._binding.library), found)


class FullTextByLayer(FullText):
    """The same, by genpy.dynamic of our layer."""

    def __init__(self, layer: Peer) -> None:
        self._layer = layer

    def ours(self, case: Case) -> Answer:
        return self._layer.ask(self.asked, case)
