"""Full definition texts: a message's own text, then that of each type it uses.

Connection headers (`message_definition`) and bags contain them, so that receivers can decode unknown types.
Format: gentools.compute_full_text in genmsg.
"""

from __future__ import annotations

from collections.abc import Iterable

from rosproto.errors import DefinitionError
from rosproto.msg.parser import is_legal_type_name

SEPARATOR = "=" * 80


def join_full_text(text: str, dependencies: Iterable[tuple[str, str]]) -> str:
    """The full text of a type.

    Args:
        text: Its own definition.
        dependencies: Name and text of each type it uses, in order, each once.
    """
    return "\n".join([text, *(f"{SEPARATOR}\nMSG: {name}\n{part}" for name, part in dependencies)])


def split_full_text(text: str, name: str) -> dict[str, str]:
    """Split a full text by type.

    Args:
        text: Untrusted text from a peer.
        name: "package/Type" of the first part.

    Returns:
        Text by type name, the message itself first.

    Raises:
        DefinitionError: A type name is not legal, or two parts define the same type differently.
    """
    parts: dict[str, str] = {}
    current, start = name, 1
    lines = text.split("\n")
    body: list[str] = []
    position = 0
    while position < len(lines):
        line = lines[position]
        if _divides(line) and lines[position + 1 : position + 2] and lines[position + 1].startswith("MSG:"):
            _add(parts, current, body, start)
            current, body, start = lines[position + 1][4:].strip(), [], position + 2
            position += 2
            continue
        body.append(line)
        position += 1
    _add(parts, current, body, start)
    return parts


def _divides(line: str) -> bool:
    """Whether the line is a separator: 80 "=" in genmsg, other numbers elsewhere (docs/wire.md, 6)."""
    line = line.rstrip()
    return len(line) >= 3 and line == "=" * len(line)


def _add(parts: dict[str, str], name: str, body: list[str], line: int) -> None:
    if not is_legal_type_name(name):
        raise DefinitionError(
            f'line {line} of the full text: {name[:80]!r} is not a type name; expected "MSG: package/Type"',
            line=line,
        )
    text = "\n".join(body)
    if parts.setdefault(name, text) != text:
        raise DefinitionError(
            f"line {line} of the full text: {name} is defined a second time and differently", line=line
        )
