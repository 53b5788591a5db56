"""Read XML-RPC documents with expat, in one pass, without recursion.

A table says which element may contain which; anything else is refused by name. Text between elements must be
white space. Text in a `<value>` without a type is a string, white space included (roscpp writes strings so).
"""

from __future__ import annotations

import pyexpat as expat  # the same as xml.parsers.expat, without importing its package
from binascii import Error as Base64Error
from binascii import a2b_base64
from collections.abc import Callable
from dataclasses import dataclass, field

from rosproto.errors import RemoteProtocolError, TooLarge
from rosproto.protocol.wire_limits import Limits
from rosproto.protocol.xmlrpc import DateTime

_INTEGERS = ("int", "i4", "i8", "i2", "i1")
_SCALARS = frozenset(
    [*_INTEGERS, "boolean", "string", "double", "float", "base64", "dateTime.iso8601", "nil"]
)
_CHILDREN: dict[str, frozenset[str]] = {
    "": frozenset(["methodCall", "methodResponse"]),
    "methodCall": frozenset(["methodName", "params"]),
    "methodResponse": frozenset(["params", "fault"]),
    "params": frozenset(["param"]),
    "param": frozenset(["value"]),
    "fault": frozenset(["value"]),
    "value": _SCALARS | {"array", "struct"},
    "array": frozenset(["data"]),
    "data": frozenset(["value"]),
    "struct": frozenset(["member"]),
    "member": frozenset(["name", "value"]),
}
_TEXTS = frozenset(["string", "name", "methodName"])
_LEAVES = _SCALARS | _TEXTS
_ONE_CHILD = frozenset(["param", "fault", "value", "array"])
_NONE: frozenset[str] = frozenset()
_NUMBER_CHARACTERS = 4096  # the longest double printed with %f has 1 100
_WHITE = " \t\r\n"


@dataclass(slots=True)
class Document:
    """A parsed document.

    Attributes:
        kind: "methodCall" or "methodResponse".
        method: Method name of a call.
        is_fault: The response is a fault; its struct is the only value.
        values: Arguments of a call, or the response's value.
    """

    kind: str = ""
    method: str = ""
    is_fault: bool = False
    values: list[object] = field(default_factory=list)


_MISSING = object()
"""Stands for a `<value>` without a typed child (so far)."""


class _Reader:
    """expat's handlers. `_path` contains the open elements, `_results` one partial result for each."""

    def __init__(self, limits: Limits) -> None:
        self.document = Document()
        self._limits = limits
        self._path: list[str] = [""]
        self._results: list[object] = [None]
        self._text: list[str] = []
        self._depth = 0

    def doctype(self, *_: object) -> None:
        raise RemoteProtocolError("XML-RPC: the document has a DOCTYPE or declares entities; refused")

    def start(self, tag: str, _attributes: object) -> None:
        parent = self._path[-1]
        if tag not in _CHILDREN.get(parent, _NONE):
            tag = self._other_spelling(tag, parent)
        if self._text:
            self._only_white(parent)
        if parent in _ONE_CHILD and self._results[-1] is not _MISSING:
            raise RemoteProtocolError(f"XML-RPC: a second <{tag}> inside one <{parent}>")
        self._path.append(tag)
        self._results.append(_MISSING if tag in _ONE_CHILD else self._fresh(tag))
        if tag in ("array", "struct"):
            self._depth += 1
            if self._depth > self._limits.xml_depth:
                raise TooLarge("xml_depth", self._depth, self._limits.xml_depth)

    def _other_spelling(self, tag: str, parent: str) -> str:
        """Accept Apache's extensions ex:nil and ex:i8; refuse anything else."""
        plain = tag.removeprefix("ex:")
        if plain not in _CHILDREN.get(parent, _NONE):
            raise RemoteProtocolError(f"XML-RPC: <{tag[:40]}> inside <{parent or 'document'}>")
        return plain

    def _fresh(self, tag: str) -> object:
        if tag in ("params", "data"):
            return []
        if tag == "struct":
            return {}
        return [None, None] if tag == "member" else None  # name and value

    def text(self, data: str) -> None:
        self._text.append(data)

    def _only_white(self, tag: str) -> None:
        """Refuse text other than white space between elements."""
        text = "".join(self._text).strip(_WHITE)
        self._text.clear()
        if text:
            raise RemoteProtocolError(f"XML-RPC: text {text[:40]!r} inside <{tag}>")

    def _take_text(self) -> str:
        text = "".join(self._text)
        self._text.clear()
        return text

    def end(self, _tag: str) -> None:
        tag, result = self._path.pop(), self._results.pop()
        if tag in _LEAVES:
            text = self._take_text()
            self._end_leaf(tag, text if tag in _TEXTS else _scalar(tag, text))
        elif tag == "value":
            if result is _MISSING:
                result = self._take_text()
            elif self._text:
                self._only_white(tag)
            self._end_value(result)
        else:
            if self._text:
                self._only_white(tag)
            self._end_container(tag, result)

    def _end_leaf(self, tag: str, result: object) -> None:
        around = self._path[-1]
        if around == "value":
            self._results[-1] = result
        elif around == "member":
            self._results[-1][0] = result  # type: ignore[index]
        else:
            self.document.method = str(result).strip()

    def _end_value(self, result: object) -> None:
        around, outer = self._path[-1], self._results[-1]
        if around == "data":
            outer.append(result)  # type: ignore[attr-defined]
        elif around == "member":
            outer[1] = result  # type: ignore[index]
        else:
            self._results[-1] = result

    def _end_container(self, tag: str, result: object) -> None:
        outer = self._results[-1]
        if tag == "member":
            self._add_member(result)
        elif tag in ("struct", "array"):
            self._depth -= 1
            if result is _MISSING:
                raise RemoteProtocolError("XML-RPC: an <array> without <data>")
            self._results[-1] = result
        elif tag == "data":
            self._results[-1] = result
        elif tag == "params":
            self.document.values = result  # type: ignore[assignment]
        elif tag in ("methodCall", "methodResponse"):
            self.document.kind = tag
        else:
            value = None if result is _MISSING else result  # roscpp omits unset values
            if tag == "param":
                outer.append(value)  # type: ignore[attr-defined]
            else:
                self.document.is_fault, self.document.values = True, [value]

    def _add_member(self, member: object) -> None:
        name = member[0]  # type: ignore[index]
        if name is None:
            raise RemoteProtocolError("XML-RPC: a <member> without <name>")
        self._results[-1][name] = member[1]  # type: ignore[index]


def _scalar(tag: str, text: str) -> object:
    try:
        return _SCALAR_READERS[tag](text)
    except (ValueError, Base64Error, KeyError) as error:
        raise RemoteProtocolError(f"XML-RPC: <{tag}> holds {text[:40]!r}, not a valid {tag}") from error


def _read_int(text: str) -> int:
    text = _number(text)
    if not text.lstrip("+-").isdigit() or len(text) > 64:
        raise ValueError(text[:64])
    return int(text)


def _read_double(text: str) -> float:
    return float(_number(text))  # accepts exponents, nan and inf, which roscpp writes


def _number(text: str) -> str:
    """Strip white space and check the characters; int() and float() would also accept underscores and other
    scripts' digits.
    """
    text = text.strip(_WHITE)
    if not text.isascii() or "_" in text or len(text) > _NUMBER_CHARACTERS:
        raise ValueError(text[:40])
    return text


_BOOLEANS = {"1": True, "0": False, "true": True, "false": False}
_SCALAR_READERS: dict[str, Callable[[str], object]] = {
    **dict.fromkeys(_INTEGERS, _read_int),
    "boolean": lambda text: _BOOLEANS[text.strip(_WHITE).lower()],
    "double": _read_double,
    "float": _read_double,
    "base64": lambda text: a2b_base64(text),
    "dateTime.iso8601": lambda text: DateTime(text.strip(_WHITE)),
    "nil": lambda _text: None,
}


def read_document(body: bytes, limits: Limits) -> Document:
    """Read one document.

    The body is decoded as UTF-8, or as ISO-8859-1 if it declares that. No other encoding is allowed, since
    Python would import a codec by a name that the peer chose.

    Raises:
        TooLarge: `xml_body_bytes` or `xml_depth`.
        RemoteProtocolError: Malformed, not XML-RPC, not UTF-8, or with a DOCTYPE.
    """
    if len(body) > limits.xml_body_bytes:
        raise TooLarge("xml_body_bytes", len(body), limits.xml_body_bytes)
    reader = _Reader(limits)
    parser = expat.ParserCreate(_encoding(body))
    parser.StartDoctypeDeclHandler = reader.doctype
    parser.EntityDeclHandler = reader.doctype
    parser.StartElementHandler = reader.start
    parser.EndElementHandler = reader.end
    parser.CharacterDataHandler = reader.text
    parser.buffer_text = True
    try:
        parser.Parse(body, True)
    except expat.ExpatError as error:
        raise RemoteProtocolError(f"XML-RPC: {_explain(body, error)}") from error
    return reader.document


def _encoding(body: bytes) -> str:
    head = body[:200]
    declaration = head[: head.find(b"?>") + 1].lower()
    return "iso-8859-1" if b"iso-8859-1" in declaration else "utf-8"


def _explain(body: bytes, error: expat.ExpatError) -> str:
    try:
        body.decode("utf-8")
    except UnicodeDecodeError as bad:
        return f"the document is not UTF-8 (byte {bad.start} is 0x{body[bad.start]:02X})"
    return f"the document is malformed: {error}"
