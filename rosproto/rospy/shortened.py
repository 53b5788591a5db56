"""The texts of the stand-ins as a wheel packs them: the same program on the same lines, without its remarks.

A wheel is limited in size (1 MB), and each program that uses the stand-ins compiles them at its start. What
only a reader of the files needs is left to the source tree: comments, docstrings, wide indentation.
"""

from __future__ import annotations

import ast
import io
import tokenize

__all__ = ["shortened"]

INDENT = 4  # blanks


def shortened(text: str) -> str:
    """A module's text without comments and docstrings, a blank for each indent.

    Every statement stays on its line, so tracebacks name the lines of the files.
    """
    lines = text.splitlines(keepends=True)
    tree = ast.parse(text)
    for first, last in _docstrings(tree, lines):
        lines[first - 1 : last] = ["\n"] * (last - first + 1)
    for token in tokenize.generate_tokens(io.StringIO("".join(lines)).readline):
        if token.type == tokenize.COMMENT:
            number, column = token.start
            lines[number - 1] = lines[number - 1][:column].rstrip() + "\n"
    texts = _within_texts(tree)
    return "".join(line if number in texts else _narrow(line) for number, line in enumerate(lines, 1))


def _narrow(line: str) -> str:
    rest = line.lstrip(" ")
    return " " * ((len(line) - len(rest)) // INDENT) + rest


def _within_texts(tree: ast.Module) -> set[int]:
    """The lines that begin inside a text, where blanks count."""
    found: set[int] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant | ast.JoinedStr):
            found.update(range(node.lineno + 1, (node.end_lineno or node.lineno) + 1))
    return found


def _docstrings(tree: ast.Module, lines: list[str]) -> list[tuple[int, int]]:
    """First and last line of those that have their lines to themselves, and whose body holds more."""
    found = []
    for node in ast.walk(tree):
        if not isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            continue
        if ast.get_docstring(node, clean=False) is None or len(node.body) == 1:
            continue
        inside = node.body[0]
        first, last = inside.lineno, inside.end_lineno or inside.lineno
        alone = not lines[first - 1][: inside.col_offset].strip()
        if alone and lines[last - 1].rstrip().endswith(('"', "'")):
            found.append((first, last))
    return found
