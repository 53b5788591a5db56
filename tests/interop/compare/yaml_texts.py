"""Random YAML as people and files have it."""

from __future__ import annotations

import random

SCALARS = (
    "0 1 -1 5 007 017 08 0x1F 0b11 0o17 1_000 +3 2147483647 2147483648 -2147483648 -2147483649 1.5 -0.5 .5 1. 1e3 1.5e3 "
    "1e-3 1.0e+10 1.e+3 .inf -.inf .nan inf nan true false True FALSE yes No on OFF y n ~ null Null '' \"\" 'a b' \"a\\tb\" "
    "'it''s' a 'a: b' word a_b a/b a-b /a deg(90) rad(pi) rad(pi/2) rad(2*pi) deg(-45.5) 'deg(90)' 1:30 12:30:45 1.2.3 "
    "= @x %y x# #c a#b !!str !!str\u00a05 *a &a <<"
).replace("\u00a0", "~").split(" ")  # fmt: skip
SCALARS = [text.replace("!!str~5", "!!str 5") for text in SCALARS] + [
    "two words", "'two words'", "a, b", "2001-01-01", "gr\u00fcn", "\u4e2d\u6587", "'\u4e2d'", '"\\u4e2d"', "!!binary aGk=", "!!float 3",
    "!!int '7'", "[]", "{}", "a  b", "a:b", "a :b", "http://x:1/y", "C:\\x", "-", "- x", "--", "-a", "?", "? x", "{a", "[a", "]",
    "'a", '"a', "a'", "1 2", "1,2", "(1)", "$x", "|", "> x", "`x`",
]  # fmt: skip
KEYS = ["a", "b", "c", "speed", "a_b", "x1", "_x", "/abs", "/abs/deep", "d/e", "1", "1.5", "true", "yes", "y", "'1'", "'q k'",
        "~", "_ns", "\u00e4", "'/q'", "a b", '"b"']  # fmt: skip
USUAL_KEYS = ["a", "b", "c", "speed", "a_b", "x1"]


def key(chance: random.Random) -> str:
    return chance.choice(USUAL_KEYS if chance.random() < 0.75 else KEYS)


def scalar(chance: random.Random) -> str:
    return chance.choice(SCALARS[:28] if chance.random() < 0.5 else SCALARS)


def flow(chance: random.Random, depth: int = 0) -> str:
    """A value in one line."""
    kind = chance.random()
    if kind < 0.6 or depth > 2:
        return scalar(chance)
    gap = chance.choice(["", " "])
    count = chance.randrange(4)
    if kind < 0.8:
        return "[" + gap + ", ".join(flow(chance, depth + 1) for _ in range(count)) + gap + "]"
    return (
        "{" + gap + ", ".join(f"{key(chance)}: {flow(chance, depth + 1)}" for _ in range(count)) + gap + "}"
    )


def block(chance: random.Random, indent: str = "", depth: int = 0) -> str:
    """Lines of names and values."""
    lines = []
    for _ in range(chance.randrange(1, 4)):
        if depth < 3 and chance.random() < 0.35:
            lines.append(f"{indent}{key(chance)}:\n{block(chance, indent + '  ', depth + 1)}")
        elif chance.random() < 0.1:
            items = "".join(f"{indent}- {flow(chance, 1)}\n" for _ in range(chance.randrange(1, 3)))
            lines.append(f"{indent}{key(chance)}:\n{items}")
        else:
            comment = chance.choice(["", "", "", "  # why"])
            lines.append(f"{indent}{key(chance)}: {flow(chance, 1)}{comment}\n")
    return "".join(lines)


def document(chance: random.Random) -> str:
    """A file: names and values, sometimes something else, sometimes several documents, or Windows' line ends."""
    kind = chance.random()
    if kind < 0.8:
        text = block(chance)
        if chance.random() < 0.15:
            text = f"_ns: {chance.choice(['inner', '/outer', 'a/b', '5', ''])}\n" + text
    else:
        text = flow(chance) + chance.choice(["", "\n"])
    if chance.random() < 0.12:
        text = text.rstrip("\n") + "\n---\n" + document(chance)
    if chance.random() < 0.05:
        text = text.replace("\n", "\r\n")
    return text
