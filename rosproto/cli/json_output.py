"""JSON that is safe to print: what a terminal would obey is escaped as JSON escapes it, and stays correct."""

from __future__ import annotations

import json
import re
from typing import Any

__all__ = ["json_text"]

_NOT_ASCII = re.compile(r"[^\x00-\x7e]+")


def json_text(value: object, *, ascii_only: bool = False, **options: Any) -> str:
    """`json.dumps`, with letters as they are and everything that is not printable as `\\u202e`.

    Args:
        value: What `json.dumps` takes.
        ascii_only: Escape all that is not ASCII.
        options: Handed on to `json.dumps`.
    """
    text = json.dumps(value, ensure_ascii=ascii_only, **options)
    return text if text.isprintable() else _NOT_ASCII.sub(_escaped, text)


def _escaped(found: re.Match[str]) -> str:
    return "".join(c if c.isprintable() or c == "\u3000" else json.dumps(c)[1:-1] for c in found[0])
