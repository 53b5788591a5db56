"""str(msg): the indented `name: value` text that genpy prints, which is YAML."""

from __future__ import annotations

import sys
from typing import Any

from rosproto.codec.message import Message
from rosproto.time import TVal


def strify_message(value: Any, indent: str = "", *, width: int | None = None) -> str:
    """A value as genpy's text; nested values begin on a new line where genpy's do.

    Unlike in genpy, fields are named as in the definition (`in`, not `in_`).

    Args:
        value: A message or a field's value.
        indent: Blanks before each line.
        width: Characters of each number, as genpy's fixed_numeric_width; None for no fixed width.
    """
    if isinstance(value, Message):
        return _message(value, indent, width)
    if isinstance(value, TVal):
        least = 9 if width is None else width
        return f"\n{indent}secs: {value.secs:{width or ''}d}\n{indent}nsecs: {value.nsecs:{least}d}"
    if isinstance(value, str):
        # Imported here and below: compiling its patterns takes longer than importing the codec.
        from rosproto.codec.yaml_text import double_quoted

        return double_quoted(value)
    if isinstance(value, (bytes, bytearray)):
        value = list(value)
    if hasattr(value, "tolist") and hasattr(value, "dtype"):
        value = value.tolist()
    if isinstance(value, (list, tuple)):
        return _items(value, indent, width)
    return str(value) if width is None else _fixed(value, width)


def _message(message: Message, indent: str, width: int | None) -> str:
    lines = "\n".join(
        f"{indent}{name}: {strify_message(getattr(message, name, None), '  ' + indent, width=width)}"
        for name in message.__slots__
    )
    return "\n" + lines if indent else lines


def _items(items: Any, indent: str, width: int | None) -> str:
    if not items:
        return "[]"
    if isinstance(items[0], (int, float)):
        if width is None:
            return str(list(items))
        return "[" + ", ".join(_fixed(item, width) for item in items) + "]"
    if isinstance(items[0], str):
        from rosproto.codec.yaml_text import list_item

        lines = [line for item in items for line in f"- {list_item(item)}".split("\n")]
        return "".join(f"\n{indent}{line}" for line in lines)
    prefix = "\n" + indent + "- "
    return "".join(prefix + strify_message(item, indent + "  ", width=width) for item in items)


def _fixed(value: Any, width: int) -> str:
    """Cut decimals to the width, but keep all digits before the point."""
    if isinstance(value, float):
        text = f"{value:.{width}f}"
        return text[: max(text.find("."), width)]
    return f"{value:{width}d}" if isinstance(value, int) and not isinstance(value, bool) else str(value)


def quoted(text: str) -> str:
    """A string as YAML in one line: double-quoted, or '' when empty."""
    from rosproto.codec.yaml_text import double_quoted

    return double_quoted(text, width=sys.maxsize)
