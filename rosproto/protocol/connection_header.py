"""The TCPROS connection header: `key=value` fields, each with its length (wiki.ros.org/ROS/TCPROS).

Bags use the same form for record headers, with binary values; see rosproto/bag for those.
"""

from __future__ import annotations

from collections.abc import Mapping
from struct import Struct

from rosproto.errors import LocalProtocolError, RemoteProtocolError

_LENGTH = Struct("<I")
MAX_FIELDS = 1000  # real ones have a dozen; a field takes far more memory than its bytes


def encode_header(fields: Mapping[str, str]) -> bytes:
    """Encode a header, including its 4-byte length.

    Fields are sorted by key, as in rospy and roscpp. Values may contain `=`, newlines, and the surrogate
    escapes by which `decode_header` represents bytes that are not UTF-8.

    Raises:
        LocalProtocolError: A key is empty or contains `=`, or a key or value is not text.
    """
    body = bytearray()
    for key, value in sorted(fields.items()):
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
        body += _LENGTH.pack(len(field)) + field
    return _LENGTH.pack(len(body)) + body


def decode_header(body: bytes | bytearray | memoryview) -> dict[str, str]:
    """The fields of a header body (without the outer length), in their order.

    Any order is accepted, unknown keys are kept, the last of two equal keys counts (as in rospy and roscpp).
    A field is split at its *first* `=`; white space around the key is removed, as in rospy. Bytes that are
    not UTF-8 (comments of a definition may contain them) become surrogate escapes, so that encoding the value
    restores them.

    Raises:
        RemoteProtocolError: The body is not a sequence of such fields, or of more than `MAX_FIELDS`.
    """
    fields: dict[str, str] = {}
    data = bytes(body)
    position, end, count = 0, len(data), 0
    while position < end:
        count += 1
        if count > MAX_FIELDS:
            raise RemoteProtocolError(f"connection header: more than {MAX_FIELDS} fields")
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
        field = data[start:position]
        key, equals, value = field.partition(b"=")
        key = key.strip()
        if not equals or not key:
            raise RemoteProtocolError(
                f"connection header: field at byte {start} is {field[:40]!r}, expected key=value"
            )
        fields[key.decode("utf-8", "surrogateescape")] = value.decode("utf-8", "surrogateescape")
    return fields
