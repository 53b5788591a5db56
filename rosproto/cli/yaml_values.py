"""Values as YAML text and back. Writing block YAML of plain values needs no library; reading any YAML does.

Flow collections, scalars and JSON are read by `rosproto.typed_values`; block YAML with PyYAML (extra `cli`).
"""

from __future__ import annotations

import base64
import itertools
import re
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any

from rosproto.cli.exit_codes import CommandError
from rosproto.typed_values import angle_loader, parse_value

if TYPE_CHECKING:
    from rosproto.codec import Message

BLOCK = re.compile(r":(\s|$)|^\s*[-?!&*|>]")
"""A text that YAML takes for more than itself: `a: 1`, `- 1`, `!degrees 90`."""
TAG = re.compile(r"[\[{,:]\s*[!&*]")
"""A tag, anchor or alias inside a flow collection: `[!degrees 90]`."""
PLAIN = re.compile(r"[A-Za-z_/][\w/. -]*\w|[A-Za-z_/]", re.ASCII)


def to_text(value: object) -> str:
    """Return block YAML as of rosparam: sorted keys, unquoted strings where possible."""
    if isinstance(value, (dict, list, bytes, bytearray)) and value:
        return "\n".join(_block(value)) + "\n"
    return _scalar(value)


def to_flow(value: object) -> str:
    """In one line, as it is typed on a command line: `{data: false, name: ''}`; keys in their own order."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_scalar(key)}: {to_flow(item)}" for key, item in value.items()) + "}"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(to_flow, value)) + "]"
    return _scalar(value)


def _block(value: dict[str, object] | list[object] | bytes | bytearray) -> list[str]:
    lines: list[str] = []
    if isinstance(value, (bytes, bytearray)):
        text = base64.b64encode(value).decode("ascii")
        return ["!!binary |", *("  " + text[at : at + 76] for at in range(0, len(text), 76))]
    if isinstance(value, dict):
        for key in sorted(value, key=str):
            item = value[key]
            head = f"{_scalar(key)}:"
            if isinstance(item, dict) and item:
                lines += [head, *("  " + line for line in _block(item))]
            elif isinstance(item, list) and item:
                lines += [head, *_block(item)]
            elif isinstance(item, (bytes, bytearray)):
                first, *more = _block(item)
                lines += [f"{head} {first}", *more]
            else:
                lines.append(f"{head} {_scalar(item)}")
        return lines
    for item in value:
        nested = item if isinstance(item, (dict, list, bytes, bytearray)) else None
        inner = _block(nested) if nested else [_scalar(item)]
        lines.append(f"- {inner[0]}")
        lines += ["  " + line for line in inner[1:]]
    return lines


def _scalar(value: object) -> str:
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
    """Quote a string unless it reads back unchanged."""
    if PLAIN.fullmatch(text) and ": " not in text and " #" not in text and parse_value(text) == text:
        return text
    if "\n" not in text and text.isprintable() and text.isascii():
        return "'" + text.replace("'", "''") + "'"
    from rosproto.codec.text import quoted

    return quoted(text)


def value_of(word: str) -> object:
    """Parse a value of the command line: scalars and flow collections, or any YAML with PyYAML.

    Raises:
        ValueError, CommandError: Invalid value; the text has the position.
    """
    if "\n" in word.strip():
        return load_text(word, "the value")
    try:
        value = parse_value(word)
        quoted = word.strip()[:1] in ("'", '"')
        if quoted or not (BLOCK if isinstance(value, str) else TAG).search(word):
            return value
        try:
            return _only(_load_with_library(word, "the value"), "the value")
        except ModuleNotFoundError:
            return value
    except ValueError as error:
        try:
            return _only(_load_with_library(word, "the value"), "the value")
        except (ModuleNotFoundError, CommandError):
            raise error from None


def fields_of(words: list[str], cls: type[Message]) -> object:
    """Return the fields of a message from the words of a command line: a dict or a list; None without any."""
    values = [value_of(word) for word in words]
    if not values:
        return None
    if len(values) == 1 and (isinstance(values[0], dict) or len(cls.__slots__) != 1):
        return values[0]
    return values


def load_documents(lines: Iterable[str], origin: str) -> Iterator[object]:
    """Yield the non-empty values of a text with `---` separators, each once complete."""
    part: list[str] = []
    for line in itertools.chain(lines, ("---",)):
        if line.rstrip() != "---":
            part.append(line)
            continue
        if any(text.strip() for text in part):
            yield load_text("".join(part), origin)
        part = []


def load_text(text: str, origin: str) -> object:
    """Parse a YAML or JSON text of one document; errors as of `load_all`."""
    return _only(load_all(text, origin), origin)


def _only(documents: list[object], origin: str) -> object:
    if len(documents) > 1:
        raise CommandError(f"{origin}: {len(documents)} documents, separated by ---; expected one")
    return documents[0] if documents else None


def load_all(text: str, origin: str) -> list[object]:
    """Parse the documents of a YAML text, or a JSON text.

    Raises:
        CommandError: It is neither, or it is block YAML and PyYAML is missing (then it names the extra).
    """
    try:
        return _load_with_library(text, origin)
    except ModuleNotFoundError:
        stripped = text.strip()
        if stripped[:1] in ("{", "[") or "\n" not in stripped:
            return [parse_value(stripped)]
        raise CommandError(
            f'{origin}: YAML over several lines needs PyYAML: pip install ".[cli]", or write JSON'
        ) from None


def _load_with_library(text: str, origin: str) -> list[object]:
    import yaml  # type: ignore[import-untyped]

    def wrong(unit: str, node: Any) -> Exception:
        what = f"{node.value.strip()!r} is not an angle: write a number, or a sum or product with pi"
        error: Exception = yaml.constructor.ConstructorError(None, None, what, node.start_mark)
        return error

    try:
        return list(yaml.load_all(text, Loader=angle_loader(yaml, wrong)))
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        at = "" if mark is None else f", line {mark.line + 1}, column {mark.column + 1}"
        problem = getattr(error, "problem", None) or str(error)
        raise CommandError(f"{origin}{at}: not YAML: {' '.join(problem.split())}") from error
