"""The sentences in source files: what commands can print, found by reading, with stand-ins for what is filled in.

A sentence is a text (plain or an f-string) with at least three English words that is neither a docstring, nor a help
text or an example of a parser, nor a line for the log, nor a pattern.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

__all__ = ["english_left", "literals", "sentences"]

_LEFT_OUT_CALLS = {"add_argument", "add_argument_group", "add_parser", "debug", "info", "warning", "exception", "compile",
                   "sub", "search", "match", "fullmatch", "Thread", "NamedTuple", "getattr", "removeprefix", "startswith"}  # fmt: skip
_LEFT_OUT_NAMES = {"ADVICE", "HELP", "__all__", "EXIT_CODES", "EXAMPLES"}
_QUOTED = re.compile(
    r"`[^`]*`|https?://\S+|'[^']*'|--?[a-zA-Z][\w-]*|/[\w/.-]+|\b\w+\(\)|\b[\w.]+\.\w+(\(.*?\))?"
)
_WORDS = re.compile(r"[A-Za-z]{2,}(?:[ ,:;]+(?:[a-z]{1,}|[A-Z]{2,})){2,}")


def english_left(text: str) -> str:
    """A run of three English words or more in a text for people; "" when there is none.

    Commands in backquotes, options, paths, addresses, quoted words and names in code are no English.
    """
    found = _WORDS.search(_QUOTED.sub("·", text))
    return found[0] if found else ""


def sentences(path: Path) -> Iterator[tuple[int, str]]:
    """(line, sentence) of a source file; what is filled in is ⟨1⟩, ⟨2⟩ ..."""
    yield from _in(ast.parse(path.read_text("utf-8")))


def _in(node: ast.AST) -> Iterator[tuple[int, str]]:
    if isinstance(node, (ast.JoinedStr, ast.Constant)):
        text = _filled(node)
        if text is not None and english_left(text):
            yield node.lineno, text
        if isinstance(node, ast.JoinedStr):  # what is filled in may be a sentence, too
            for value in node.values:
                if isinstance(value, ast.FormattedValue):
                    yield from _in(value.value)
        return
    for child in _children(node):
        yield from _in(child)


def _children(node: ast.AST) -> Iterator[ast.AST]:
    if isinstance(node, ast.Call):
        name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
        if name in _LEFT_OUT_CALLS:
            return
    if isinstance(node, (ast.Assign, ast.AnnAssign)):
        targets = node.targets if isinstance(node, ast.Assign) else [node.target]
        if any(getattr(target, "id", "") in _LEFT_OUT_NAMES for target in targets):
            return
    if isinstance(node, ast.FunctionDef) and node.name == "add_arguments":
        return
    for child in ast.iter_child_nodes(node):
        if not (isinstance(child, ast.Expr) and isinstance(child.value, ast.Constant)):  # a docstring
            yield child


def _filled(node: ast.AST) -> str | None:
    if isinstance(node, ast.Constant):
        return node.value if isinstance(node.value, str) else None
    assert isinstance(node, ast.JoinedStr)
    parts = []
    for value in node.values:
        if isinstance(value, ast.Constant):
            parts.append(str(value.value))
        else:
            parts.append(f"⟨{len([p for p in parts if p.startswith('⟨')]) + 1}⟩")
    return "".join(parts)


def literals(*rooms: str, leaving_out: str = "") -> set[str]:
    """Every plain text in the sources of these folders."""
    root = Path(__file__).resolve().parents[2]
    return {
        node.value
        for room in rooms
        for path in (root / room).rglob("*.py")
        if path != root / leaving_out
        for node in ast.walk(ast.parse(path.read_text("utf-8")))
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
    }
