"""The TCPROS connection header: `key=value` fields, each with its length (wiki.ros.org/ROS/TCPROS).

Bag files use the same form for their record headers, with other rules for the values; this module is for
the text headers of a connection.
"""

from __future__ import annotations

from collections.abc import Mapping
from struct import Struct

from rosproto.errors import LocalProtocolError, RemoteProtocolError

_LENGTH = Struct("<I")
MOST_FIELDS = 1000  # real ones have a dozen; each costs far more than the bytes it came in


def encode_header(fields: Mapping[str, str]) -> bytes:
    """The complete header with its own 4-byte length, ready to be sent.

    Fields are sorted by key, as rospy and roscpp both write them. Values may hold `=` and newlines, and
    the surrogate escapes with which `decode_header` keeps bytes that are not UTF-8.

    Raises:
        LocalProtocolError: A key is empty or holds `=`, or a key or value is no text.
    """
    parts = [_encode_field(key, fields[key]) for key in sorted(fields)]
    body = b"".join(parts)
    return _LENGTH.pack(len(body)) + body


def _encode_field(key: str, value: str) -> bytes:
    if not isinstance(key, str) or not isinstance(value, str):
        raise LocalProtocolError(
            f"connection header field {key!r}={value!r}: key and value must be str, "
            f"not {type(key).__name__} and {type(value).__name__}"
        )
    if not key or "=" in key:
        raise LocalProtocolError(f"connection header key {key!r}: must not be empty nor hold '='")
    try:
        field = f"{key}={value}".encode("utf-8", "surrogateescape")
    except UnicodeEncodeError as error:
        raise LocalProtocolError(f"connection header field {key}: {error}; it cannot be sent") from error
    return _LENGTH.pack(len(field)) + field


def decode_header(body: bytes | bytearray | memoryview) -> dict[str, str]:
    """The fields of a header body (without the outer length), in the order they came.

    Any order is accepted, unknown keys are kept, the last of two equal keys counts (as in rospy and
    roscpp). A field is split at its *first* `=`; white space around the key is dropped, as rospy does.
    Bytes that are not UTF-8 (comments of a definition text may hold them) become surrogate escapes, so
    that encoding the value again gives the same bytes.

    Raises:
        RemoteProtocolError: The body is not a sequence of such fields, or of more than `MOST_FIELDS`.
    """
    fields: dict[str, str] = {}
    data = bytes(body)
    position, end, count = 0, len(data), 0
    while position < end:
        count += 1
        if count > MOST_FIELDS:
            raise RemoteProtocolError(f"connection header: more than {MOST_FIELDS} fields")
        start = position + 4
        if start > end:
            raise RemoteProtocolError(f"connection header: {end - position} stray bytes at byte {position}")
        (length,) = _LENGTH.unpack_from(data, position)
        position = start + length
        if position > end:
            raise RemoteProtocolError(
                f"connection header: field at byte {start} says {length} bytes, but {end - start} are left; "
                "the peer does not speak TCPROS or the stream is out of step"
            )
        key, value = _decode_field(data[start:position], start)
        fields[key] = value
    return fields


def _decode_field(field: bytes, offset: int) -> tuple[str, str]:
    key, equals, value = field.partition(b"=")
    key = key.strip()
    if not equals or not key:
        raise RemoteProtocolError(
            f"connection header: field at byte {offset} is {field[:40]!r}, expected key=value"
        )
    return key.decode("utf-8", "surrogateescape"), value.decode("utf-8", "surrogateescape")
