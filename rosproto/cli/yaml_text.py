"""Values as YAML text and back. Writing block YAML of plain values needs no library; reading any YAML does.

Flow collections, scalars and JSON are read by `rosproto.values`; block YAML with PyYAML (extra `cli`).
"""

from __future__ import annotations

import re
from typing import Any

from rosproto.codec.text import quoted
from rosproto.values import parse_value

from .graph import CommandError

__all__ = ["load_text", "to_text"]

PLAIN = re.compile(r"[A-Za-z_/][\w/. -]*\w|[A-Za-z_/]", re.ASCII)


def to_text(value: Any) -> str:
    """Block YAML as rosparam prints it: keys sorted, strings plain where they can be."""
    if isinstance(value, (dict, list)) and value:
        return "\n".join(_block(value)) + "\n"
    return _scalar(value)


def _block(value: Any) -> list[str]:
    lines: list[str] = []
    if isinstance(value, dict):
        for key in sorted(value, key=str):
            item = value[key]
            head = f"{_scalar(key)}:"
            if isinstance(item, dict) and item:
                lines += [head, *("  " + line for line in _block(item))]
            elif isinstance(item, list) and item:
                lines += [head, *_block(item)]
            else:
                lines.append(f"{head} {_scalar(item)}")
        return lines
    for item in value:
        inner = _block(item) if isinstance(item, (dict, list)) and item else [_scalar(item)]
        lines.append(f"- {inner[0]}")
        lines += ["  " + line for line in inner[1:]]
    return lines


def _scalar(value: Any) -> str:
    if value is None:
        return "null"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return _float(value)
    if isinstance(value, str):
        return _string(value)
    if isinstance(value, dict):
        return "{}"
    if isinstance(value, list):
        return "[]"
    return str(value)


def _float(value: float) -> str:
    text = repr(value)
    if text in ("inf", "-inf", "nan"):
        return text.replace("inf", ".inf").replace("nan", ".nan")
    return text if "e" not in text or "." in text else text.replace("e", ".0e")


def _string(text: str) -> str:
    """Plain only when it would be read back as the same string."""
    if PLAIN.fullmatch(text) and ": " not in text and " #" not in text and parse_value(text) == text:
        return text
    if "\n" not in text and text.isprintable() and text.isascii():
        return "'" + text.replace("'", "''") + "'"
    return quoted(text)


def load_text(text: str, origin: str) -> Any:
    """The value of a YAML or JSON text.

    Raises:
        CommandError: It is neither, or it is block YAML and PyYAML is missing (then it names the extra).
    """
    try:
        return _load_with_library(text, origin)
    except ModuleNotFoundError:
        stripped = text.strip()
        if stripped[:1] in ("{", "[") or "\n" not in stripped:
            return parse_value(stripped)
        raise CommandError(
            f"{origin}: YAML over several lines needs PyYAML: pip install 'woosh-pure[cli]', or write JSON"
        ) from None


def _load_with_library(text: str, origin: str) -> Any:
    import yaml  # type: ignore[import-untyped]

    try:
        return yaml.safe_load(text)
    except yaml.YAMLError as error:
        raise CommandError(f"{origin}: not YAML: {error}") from error
