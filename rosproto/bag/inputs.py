"""Check and convert arguments of bag writers: times (Time, or seconds since 1970), headers and messages."""

from __future__ import annotations

from collections.abc import Mapping
from math import isfinite
from numbers import Real
from typing import Any

from rosproto.bag.messages import RawMessage
from rosproto.bag.records import NS, Connection
from rosproto.codec import Message
from rosproto.time import Time

Stamp = Time | float
_OWN_FIELDS = ("topic", "type", "md5sum", "message_definition")


def check_header(header: Mapping[str, str]) -> None:
    """Refuse a connection header that cannot be stored.

    Raises:
        ValueError: A name or value is not a string, or a name contains `=`.
    """
    for key, value in header.items():
        if not isinstance(key, str) or not isinstance(value, str) or "=" in key:
            raise ValueError(f"header {key!r}={value!r}: texts are expected, the name without `=`")


def check_message(topic: str, message: object) -> None:
    """Refuse anything that is not a message.

    Raises:
        TypeError: It is something else.
    """
    if not isinstance(message, Message):
        raise TypeError(
            f"{topic}: a message of message_class(), msgdefs or a raw one is expected, "
            f"not {type(message).__name__}; encoded bytes go in with write_raw"
        )


def own_text(cls: type[Message], header: Mapping[str, str] | None) -> str:
    """The publisher's text of this definition, comments included (`rosbag check` compares it); "" if none."""
    if not header or header.get("md5sum") != cls._md5sum or header.get("type") != cls._type:
        return ""
    return header.get("message_definition", "")


def identity(connection: Connection) -> tuple[object, ...]:
    """A key that is equal for equal connections."""
    facts = {k: v for k, v in connection.header.items() if k not in _OWN_FIELDS}
    topic = connection.header.get("topic", connection.topic)
    return (
        connection.topic, topic, connection.type, connection.md5sum, connection.definition,
        frozenset(facts.items()),
    )  # fmt: skip


def as_raw(topic: str, message: Message) -> RawMessage:
    """A message that was received undecoded, with the type information of its connection header.

    Raises:
        ValueError: It has no connection header, so its type is unknown.
    """
    header = message._connection_header
    if not header or "type" not in header or "md5sum" not in header:
        raise ValueError(
            f"{topic}: an AnyMsg without connection header has no type; write a message of a known type, "
            "or use write_raw"
        )
    definition = header.get("message_definition", "")
    connection = Connection(-1, topic, header["type"], header["md5sum"], definition, header)
    return RawMessage(connection.type, _buff(message), connection.md5sum, (0, 0), connection)


def data_of(message: RawMessage) -> bytes:
    """The bytes of a raw message."""
    return message.data


def _buff(message: Any) -> bytes:
    return bytes(message._buff)


def seconds_and_rest(stamp: Any) -> tuple[int, int]:
    """Seconds and nanoseconds of any number (numpy's too), or of an object with secs and nsecs.

    Raises:
        ValueError: It is not a time, or not finite.
    """
    if isinstance(stamp, Real):
        if not isfinite(stamp):
            raise out_of_range(float(stamp))
        return divmod(round((stamp if isinstance(stamp, int) else float(stamp)) * NS), NS)
    try:
        return stamp.secs, stamp.nsecs
    except AttributeError:
        raise ValueError(
            f"time {stamp!r}: Time, or seconds since 1970, is expected, not {type(stamp).__name__}"
        ) from None


def to_ns(stamp: Stamp) -> int:
    """Nanoseconds since 1970.

    Raises:
        ValueError: See `seconds_and_rest`.
    """
    secs, nsecs = seconds_and_rest(stamp)
    return int(secs) * NS + int(nsecs)


def out_of_range(stamp: Stamp) -> ValueError:
    """The error of a time that no bag can store."""
    hint = "; give seconds, not nanoseconds" if isinstance(stamp, (int, float)) and stamp > 1e12 else ""
    return ValueError(
        f"time {stamp!r}: a bag stores unsigned 32-bit seconds and nanoseconds since 1970{hint}"
    )
