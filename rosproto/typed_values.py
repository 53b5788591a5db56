"""Parse values typed on a command line: `0.5`, `true`, `[1, 2]`, `{a: 1, b: two words}`.

The part of YAML that people type into `_param:=value` and `param set`: scalars and flow collections. Every
JSON text has the same value as in JSON. Block YAML, anchors and tags are not supported; PyYAML reads them,
with rosparam's angles by `angle_loader`.
"""

from __future__ import annotations

import ast
import math
import operator
import re
import warnings
from collections.abc import Callable
from typing import Any

__all__ = ["angle_loader", "expression_tree", "parse_value"]

ANGLES = {unit: re.compile(rf"{unit[:3]}\([^)]*\)$") for unit in ("degrees", "radians")}
_SEXAGESIMAL = re.compile(r"[-+]?[0-9][0-9_]*(:[0-5]?[0-9])+(\.[0-9_]*)?", re.ASCII)
DEPTH = 64
"""Deepest nesting of collections; the same limit as for XML-RPC, which transports the value."""

CONSTANTS: dict[str, object] = {
    **dict.fromkeys(("", "~", "null", "Null", "NULL"), None),
    **{form: True for word in ("true", "yes", "on") for form in (word, word.title(), word.upper())},
    **{form: False for word in ("false", "no", "off") for form in (word, word.title(), word.upper())},
    **dict.fromkeys((".inf", ".Inf", ".INF", "+.inf", "+.Inf", "+.INF"), float("inf")),
    **dict.fromkeys(("-.inf", "-.Inf", "-.INF"), float("-inf")),
    **dict.fromkeys((".nan", ".NaN", ".NAN"), float("nan")),
}
"""YAML 1.1's words, as PyYAML (and so rospy and rosparam) reads them."""

ESCAPES = {
    "0": "\0", "a": "\a", "b": "\b", "t": "\t", "n": "\n", "v": "\v", "f": "\f", "r": "\r",
    "e": "\x1b", '"': '"', "/": "/", "\\": "\\", " ": " ", "_": "\xa0", "N": "\x85",
    "L": "\u2028", "P": "\u2029",
}  # fmt: skip
HEX_ESCAPES = {"x": 2, "u": 4, "U": 8}


def parse_value(text: str) -> object:
    """Parse a value.

    Returns:
        None, bool, int, float, str, list or dict.

    Raises:
        ValueError: A quote or bracket is not closed, or something follows the value.
    """
    reader = _Parser(text.strip())
    first = reader.text[:1]
    if first not in ("[", "{", '"', "'"):
        return _scalar(reader.text)
    value = reader.value("", 0)
    if reader.position < len(reader.text):
        raise reader.wrong("nothing more")
    return value


def _scalar(text: str) -> object:
    if text in CONSTANTS:
        return CONSTANTS[text]
    for unit, pattern in ANGLES.items():
        if pattern.match(text):
            return angle(unit, text)
    if _SEXAGESIMAL.fullmatch(text):  # YAML 1.1: 1:30 is 90
        total: float = 0
        for part in text.lstrip("+-").replace("_", "").split(":"):
            total = total * 60 + (float(part) if "." in part else int(part))
        return -total if text[0] == "-" else total
    if text[0] not in "+-.0123456789":
        return text
    for read in (_integer, _float):
        try:
            return read(text)
        except ValueError:
            pass
    return text


def _integer(text: str) -> int:
    """YAML 1.1: 10, 0x1F, 0b11, 1_000, and octal 017."""
    digits = text.lstrip("+-").replace("_", "")
    if (
        len(text) - len(text.lstrip("+-")) > 1
        or not digits.isascii()
        or digits != digits.strip()
        or "o" in digits
    ):
        raise ValueError(text)
    sign = -1 if text[0] == "-" else 1
    if digits[:2] in ("0x", "0b"):
        return sign * int(digits, 0)
    if digits[:1] == "0" and len(digits) > 1:
        return sign * int(digits, 8)
    return sign * int(digits)


def _float(text: str) -> float:
    """With or without a dot: JSON's 1e3 is a number, which PyYAML would call a string."""
    if not text.isascii() or not any(mark in text for mark in ".eE") or "n" in text.lower():
        raise ValueError(text)  # Python would also take nan, inf, infinity and 08
    return float(text)


class _Parser:
    """Recursive descent parser for one text."""

    def __init__(self, text: str) -> None:
        self.text = text
        self.position = 0

    def wrong(self, expected: str) -> ValueError:
        return ValueError(
            f"{self.text[:80]!r}: expected {expected} at character {self.position + 1}; "
            f"quote a text that begins with a bracket or a quote"
        )

    def value(self, stops: str, depth: int) -> object:
        """One value; a plain scalar ends before one of `stops`. Blanks around it are skipped."""
        if depth > DEPTH:
            raise self.wrong(f"at most {DEPTH} brackets inside each other")
        self._blanks()
        first = self.text[self.position : self.position + 1]
        if first == "[":
            found: object = self._list(depth)
        elif first == "{":
            found = self._dict(depth)
        elif first and first in "\"'":
            found = self._quoted(first)
        else:
            found = _scalar(self._plain(stops))
        self._blanks()
        return found

    def _blanks(self) -> None:
        while self.text[self.position : self.position + 1].isspace():
            self.position += 1

    def _take(self, character: str) -> bool:
        if self.text[self.position : self.position + 1] != character:
            return False
        self.position += 1
        return True

    def _list(self, depth: int) -> list[object]:
        self.position += 1
        found: list[object] = []
        self._blanks()
        while not self._take("]"):
            if self.text[self.position : self.position + 1] == ",":
                raise self.wrong("an element")
            found.append(self.value(",]", depth + 1))
            if not self._take(",") and self.text[self.position : self.position + 1] != "]":
                raise self.wrong("`,` or `]`")
            self._blanks()
        return found

    def _dict(self, depth: int) -> dict[object, object]:
        self.position += 1
        found: dict[object, object] = {}
        self._blanks()
        while not self._take("}"):
            key = self._key()
            self._blanks()
            if not self._take(":"):
                raise self.wrong("`:` after a key")
            found[key] = self.value(",}", depth + 1)
            if not self._take(",") and self.text[self.position : self.position + 1] != "}":
                raise self.wrong("`,` or `}`")
            self._blanks()
        return found

    def _key(self) -> object:
        first = self.text[self.position : self.position + 1]
        if first and first in "\"'":
            return self._quoted(first)
        key = self._plain(":,}")
        if not key:
            raise self.wrong("a key")
        return _scalar(key)

    def _plain(self, stops: str) -> str:
        start = self.position
        while self.position < len(self.text) and self.text[self.position] not in stops:
            self.position += 1
        return self.text[start : self.position].strip()

    def _quoted(self, quote: str) -> str:
        self.position += 1
        parts: list[str] = []
        while self.position < len(self.text):
            character = self.text[self.position]
            self.position += 1
            if character == "\\" and quote == '"':
                parts.append(self._escape())
            elif character != quote:
                parts.append(character)
            elif quote == "'" and self._take("'"):  # YAML doubles a quote inside
                parts.append("'")
            else:
                # JSON writes a character beyond 16 bits as two surrogates.
                return "".join(parts).encode("utf-16", "surrogatepass").decode("utf-16", "replace")
        raise self.wrong(f"a closing {quote}")

    def _escape(self) -> str:
        character = self.text[self.position : self.position + 1]
        self.position += 1
        if character in HEX_ESCAPES:
            digits = self.text[self.position : self.position + HEX_ESCAPES[character]]
            self.position += len(digits)
            if len(digits) == HEX_ESCAPES[character] and digits.isalnum():
                try:
                    return chr(int(digits, 16))
                except (ValueError, OverflowError):
                    pass
        elif character in ESCAPES:
            return ESCAPES[character]
        raise self.wrong("a known escape after `\\`")


# -- angles --------------------------------------------------------------------------------------------------

_OPERATORS: dict[type[ast.AST], Callable[..., float]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.UAdd: operator.pos,
    ast.USub: operator.neg,
}


def angle_loader(yaml: Any, wrong: Callable[[str, Any], Exception]) -> type:
    """PyYAML's safe loader with rosparam's angles: deg(90), rad(pi/2), !degrees 90.

    Args:
        yaml: PyYAML.
        wrong: Returns the error for what is not an angle; called with the unit and the node of the text.
    """

    class Loader(yaml.SafeLoader):  # type: ignore[misc]
        """A subclass: PyYAML's shared class stays unchanged."""

    def constructor(unit: str) -> Callable[..., float]:
        def construct(loader: Any, node: Any) -> float:
            try:
                return angle(unit, loader.construct_scalar(node))
            except ValueError:
                raise wrong(unit, node) from None

        return construct

    for unit, pattern in ANGLES.items():
        Loader.add_implicit_resolver(f"!{unit}", pattern, unit[0])
        Loader.add_constructor(f"!{unit}", constructor(unit))
    return Loader


def angle(unit: str, text: str) -> float:
    """Compute an angle in radians: `deg(90)`, `rad(pi/2)`, or what stands between the brackets.

    Raises:
        ValueError: It is not a number, or a sum or product with pi.
    """
    text = text.strip()
    inner = text[4:-1] if text.startswith(f"{unit[:3]}(") and text.endswith(")") else text
    try:
        value = float(_arithmetic(expression_tree(inner)))
    except (SyntaxError, ValueError, KeyError, ArithmeticError, RecursionError, MemoryError):
        raise ValueError(f"{text!r} is not an angle: write a number, or a sum or product with pi") from None
    return value * math.pi / 180.0 if unit == "degrees" else value


def expression_tree(text: str) -> ast.expr:
    """Parse a Python expression, without Python's warnings about its style (`1if x else 2`).

    Raises:
        SyntaxError, ValueError, RecursionError, MemoryError: The text is not a Python expression or too deep.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return ast.parse(text.strip(), mode="eval").body


def _arithmetic(node: ast.expr) -> float:
    """Compute a sum or product of numbers and pi; anything else is a KeyError."""
    if isinstance(node, ast.Constant) and isinstance(node.value, (int, float)):
        return node.value
    if isinstance(node, ast.BinOp):
        return _OPERATORS[type(node.op)](_arithmetic(node.left), _arithmetic(node.right))
    if isinstance(node, ast.UnaryOp):
        return _OPERATORS[type(node.op)](_arithmetic(node.operand))
    return {"pi": math.pi}[getattr(node, "id", "")]
