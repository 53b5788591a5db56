"""XML-RPC as the ROS master and slave APIs use it: convert Python values to documents and back.

Documents are written so that roscpp's parser (XmlRpcValue.cpp) can read them: compact tags without
attributes, named entities only, integers of 32 bits, no `<nil/>`, no `<i8>`. The reader accepts harmless
variants (`i8`, `nil`, `ex:` prefixes) and refuses what could be abused: DOCTYPE and entity declarations;
nesting and size are limited, and nothing recurses.

Values: str, int, float, bool, bytes (base64), `DateTime`, list, dict with str keys. `None` is read (from
`<nil/>`, and where roscpp omits a value) but never written.

The reader is in `xmlrpc_reader`; expat is imported with the first document that is read.
"""

from __future__ import annotations

import re
import sys
from binascii import b2a_base64
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

from rosproto.errors import LocalProtocolError, RemoteProtocolError, RosError
from rosproto.protocol.framing import BytesLike
from rosproto.protocol.wire_limits import Limits

if TYPE_CHECKING:
    from rosproto.protocol.xmlrpc_reader import Document

_HEAD = '<?xml version="1.0"?>'
_INT_MIN, _INT_MAX = -(2**31), 2**31 - 1
_MAX_DEPTH = 64  # as deep as a receiver accepts (Limits.xml_depth)
_DEFAULT_LIMITS = Limits()

# XML 1.0 cannot contain these, not even as numeric references. Carriage return is legal, but conforming
# parsers read it as a newline; roscpp, which does not decode numeric references, keeps it.
_FORBIDDEN = "[\x00-\x08\x0b\x0c\x0e-\x1f\ud800-\udfff\ufffe\uffff]"  # compiled with its first use


class Fault(RosError):
    """The other side replied with an XML-RPC fault. A dispatcher raises it to send one.

    Attributes:
        code: faultCode.
        text: faultString.
    """

    def __init__(self, code: int, text: str) -> None:
        super().__init__(f"XML-RPC fault {code}: {text}")
        self.code = code
        self.text = text


class DateTime(str):
    """The text of a `<dateTime.iso8601>`, not interpreted; written back unchanged."""

    __slots__ = ()


def encode_call(method: str, params: Iterable[object] = ()) -> bytes:
    """Encode a `<methodCall>` document.

    Raises:
        LocalProtocolError: A value cannot be encoded; the text says which and why.
    """
    out = [_HEAD, "<methodCall><methodName>", _escape(method, "method name"), "</methodName><params>"]
    for number, value in enumerate(params):
        out.append("<param>")
        _write(out, value, f"{method} argument {number}", 0)
        out.append("</param>")
    out.append("</params></methodCall>")
    return "".join(out).encode()


def encode_response(value: object) -> bytes:
    """Encode a `<methodResponse>` document with one value.

    Raises:
        LocalProtocolError: The value cannot be encoded.
    """
    out = [_HEAD, "<methodResponse><params><param>"]
    _write(out, value, "response", 0)
    out.append("</param></params></methodResponse>")
    return "".join(out).encode()


def encode_fault(code: int, text: str) -> bytes:
    """Encode a `<methodResponse>` document with a fault; characters that XML cannot contain become `?`."""
    out = [_HEAD, "<methodResponse><fault>"]
    _write(out, {"faultCode": code, "faultString": re.sub(_FORBIDDEN, "?", text)}, "fault", 0)
    out.append("</fault></methodResponse>")
    return "".join(out).encode()


def decode_call(body: BytesLike, limits: Limits = _DEFAULT_LIMITS) -> tuple[str, list[object]]:
    """Method name and arguments of a `<methodCall>` document.

    Raises:
        TooLarge: More bytes or deeper nesting than `limits` allows.
        RemoteProtocolError: Not such a document, not UTF-8, or it declares entities.
    """
    document = _read(body, limits)
    if document.kind != "methodCall" or not document.method:
        raise RemoteProtocolError(
            f"XML-RPC: expected a <methodCall> with a <methodName>, got <{document.kind}>"
        )
    return document.method, document.values


def decode_response(body: BytesLike, limits: Limits = _DEFAULT_LIMITS) -> object:
    """The value of a `<methodResponse>` document; None if the peer omitted it (roscpp does).

    Raises:
        Fault: The document is a fault.
        TooLarge: More bytes or deeper nesting than `limits` allows.
        RemoteProtocolError: Not such a document, not UTF-8, or it declares entities.
    """
    document = _read(body, limits)
    if document.kind != "methodResponse":
        raise RemoteProtocolError(f"XML-RPC: expected a <methodResponse>, got <{document.kind}>")
    if document.is_fault:
        raise _fault(document.values)
    if len(document.values) > 1:
        raise RemoteProtocolError(f"XML-RPC: a response has one value, got {len(document.values)}")
    return document.values[0] if document.values else None


def _read(body: BytesLike, limits: Limits) -> Document:
    from rosproto.protocol.xmlrpc_reader import read_document  # late: expat costs import time

    return read_document(bytes(body), limits)


def _fault(values: list[object]) -> Fault:
    fault = values[0] if values else None
    if not isinstance(fault, dict):
        raise RemoteProtocolError("XML-RPC: the fault holds no struct")
    code, text = fault.get("faultCode", 0), fault.get("faultString", "")
    return Fault(code if isinstance(code, int) else 0, text if isinstance(text, str) else repr(text))


def _write(out: list[str], value: object, where: str, depth: int) -> None:
    """Append one `<value>`. The order of the checks matters: bool is an int, DateTime a str."""
    if isinstance(value, DateTime):
        out.append(f"<value><dateTime.iso8601>{_escape(value, where)}</dateTime.iso8601></value>")
    elif isinstance(value, str):
        out.append(f"<value><string>{_escape(value, where)}</string></value>")
    elif isinstance(value, bool):
        out.append("<value><boolean>1</boolean></value>" if value else "<value><boolean>0</boolean></value>")
    elif isinstance(value, int):
        out.append(f"<value><int>{_integer(value, where)}</int></value>")
    elif isinstance(value, float):
        # repr: the shortest text of the same double; numpy.float64 has another repr
        out.append(f"<value><double>{float.__repr__(value)}</double></value>")
    elif isinstance(value, (bytes, bytearray, memoryview)):
        out.append(f"<value><base64>{b2a_base64(value, newline=False).decode()}</base64></value>")
    elif isinstance(value, Mapping):
        _write_struct(out, value, where, depth)
    elif isinstance(value, (list, tuple)):
        _write_array(out, value, where, depth)
    else:
        _write_other(out, value, where, depth)


def _integer(value: int, where: str) -> int:
    if not _INT_MIN <= value <= _INT_MAX:
        raise LocalProtocolError(
            f"{where}: {value} does not fit the 32 bits of an XML-RPC integer "
            "(roscpp would truncate it silently); send a float or a string"
        )
    return int(value)


def _write_array(out: list[str], value: Iterable[object], where: str, depth: int) -> None:
    _check_depth(where, depth)
    out.append("<value><array><data>")
    for item in value:
        _write(out, item, where, depth + 1)
    out.append("</data></array></value>")


def _write_struct(out: list[str], value: Mapping[object, object], where: str, depth: int) -> None:
    _check_depth(where, depth)
    out.append("<value><struct>")
    for key, item in value.items():
        if not isinstance(key, str):
            raise LocalProtocolError(
                f"{where}: key {key!r} is {type(key).__name__}; XML-RPC structs have str keys"
            )
        out.append(f"<member><name>{_escape(key, where)}</name>")
        _write(out, item, where, depth + 1)
        out.append("</member>")
    out.append("</struct></value>")


def _check_depth(where: str, depth: int) -> None:
    if depth >= _MAX_DEPTH:
        raise LocalProtocolError(
            f"{where}: nested deeper than {_MAX_DEPTH} levels, or a container holds itself"
        )


def _write_other(out: list[str], value: object, where: str, depth: int) -> None:
    convert = getattr(value, "tolist", None)  # numpy arrays and scalars, without importing numpy
    if convert is not None:
        _check_depth(where, depth)
        _write(out, convert(), where, depth + 1)
        return
    datetime = sys.modules.get("datetime")  # a value can be a datetime only if it was imported
    if datetime is not None and isinstance(value, datetime.datetime):
        _write(out, DateTime(value.strftime("%Y%m%dT%H:%M:%S")), where, depth)
        return
    hint = "leave it out" if value is None else "send str, int, float, bool, bytes, list or dict"
    raise LocalProtocolError(f"{where}: XML-RPC cannot carry {type(value).__name__} ({value!r:.80}); {hint}")


def _escape(text: str, where: str) -> str:
    forbidden = None if text.isprintable() else re.search(_FORBIDDEN, text)
    if forbidden is not None:
        raise LocalProtocolError(
            f"{where}: character {forbidden.start()} is U+{ord(forbidden.group()):04X}, which XML 1.0 cannot "
            "carry; send bytes instead"
        )
    return text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
