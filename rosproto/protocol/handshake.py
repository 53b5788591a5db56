"""The TCPROS connection header, and what the headers of the four roles must say (wiki.ros.org/ROS/TCPROS).

A header is a sequence of `key=value` fields, each with its length. Bags use the same form for record headers,
with binary values; see rosproto/bag for those.

The md5sum decides whether two sides match, as in rospy and roscpp; types only make the error readable. Where
the wiki is silent: a subscriber or a service client may send the wildcard `*` for md5sum and type (rostopic
echo, rosservice call, rosbag record). Among the serving sides only a publisher of AnyMsg sends it (rospy's
relays): it does not know the type of its messages, and only wildcard subscribers receive them. roscpp's
subscriber sends no message_definition and its service client no type, so neither is required.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from struct import Struct
from typing import NamedTuple

from rosproto.errors import LocalProtocolError, Md5sumMismatch, RemoteProtocolError
from rosproto.text import printable

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
                "the peer does not speak TCPROS or the stream is out of sync"
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


ANY = "*"
_MD5SUM = r"(?<![0-9a-f])[0-9a-f]{32}(?![0-9a-f])"
_TRUE = ("1", "true")


class HandshakeRefused(RemoteProtocolError):
    """The other side answered the connection header with an error.

    Attributes:
        name: Topic or service.
        peer: Address or URI of the other side.
        text: The other side's error text.
    """

    def __init__(self, name: str, peer: str, text: str) -> None:
        super().__init__(f"{name}: {peer or 'the other side'} refused the connection: {printable(text)}")
        self.name = name
        self.peer = peer
        self.text = text


class PublisherReply(NamedTuple):
    """A publisher's header; type and md5sum are those of the messages it will send."""

    callerid: str
    type_name: str
    md5sum: str
    message_definition: str


class ServiceRequest(NamedTuple):
    """A service client's header. After a `probe` the reply header is sent and no call follows."""

    callerid: str
    persistent: bool
    probe: bool


def subscriber_header(
    *,
    topic: str,
    type_name: str,
    md5sum: str,
    callerid: str,
    message_definition: str = "",
    tcp_nodelay: bool = False,
) -> dict[str, str]:
    """The header that a subscriber sends first. "*" for type and md5sum accepts any type."""
    fields = {
        "callerid": callerid,
        "md5sum": md5sum,
        "tcp_nodelay": "1" if tcp_nodelay else "0",
        "topic": topic,
        "type": type_name,
    }
    if message_definition:
        fields["message_definition"] = message_definition
    return fields


def publisher_header(
    *,
    topic: str,
    type_name: str,
    md5sum: str,
    callerid: str,
    message_definition: str,
    latching: bool = False,
) -> dict[str, str]:
    """The header with which a publisher replies. rosbag and rostopic use `message_definition`, the full text.

    Raises:
        LocalProtocolError: One of type and md5sum is the wildcard (both are, for AnyMsg), or empty.
    """
    if not type_name == md5sum == ANY:
        _refuse_wildcard(f"publisher of {topic}", type_name, md5sum)
    return {
        "callerid": callerid,
        "latching": "1" if latching else "0",
        "md5sum": md5sum,
        "message_definition": message_definition,
        "topic": topic,
        "type": type_name,
    }


def service_client_header(
    *,
    service: str,
    md5sum: str,
    callerid: str,
    type_name: str = "",
    persistent: bool = False,
    probe: bool = False,
) -> dict[str, str]:
    """The header that a service client sends first; `probe` asks for the reply header only."""
    fields = {"callerid": callerid, "md5sum": md5sum, "service": service}
    if type_name:
        fields["type"] = type_name
    if persistent:
        fields["persistent"] = "1"
    if probe:
        fields["probe"] = "1"
    return fields


def service_server_header(
    *,
    service: str,
    type_name: str,
    md5sum: str,
    callerid: str,
    request_type: str = "",
    response_type: str = "",
) -> dict[str, str]:
    """The header with which a service server replies. rospy's client and `rosservice type` need `type`.

    Raises:
        LocalProtocolError: Type or md5sum is the wildcard.
    """
    _refuse_wildcard(f"server of {service}", type_name, md5sum)
    return {
        "callerid": callerid,
        "md5sum": md5sum,
        "request_type": request_type or f"{type_name}Request",
        "response_type": response_type or f"{type_name}Response",
        "service": service,
        "type": type_name,
    }


def error_header(text: str) -> dict[str, str]:
    """The refusal that either side sends before it closes: one field, `error`."""
    return {"error": text}


def check_subscriber_header(
    fields: Mapping[str, str],
    *,
    topic: str,
    type_name: str,
    md5sum: str,
    peer: str = "",
) -> None:
    """On the publisher: check a subscriber's header. `str(error)` is the text for `error_header`.

    Args:
        fields: The subscriber's header.
        topic: Our topic.
        type_name: Our type.
        md5sum: Our md5sum (of the revision that would be sent).
        peer: Address of the subscriber, for errors.

    Raises:
        Md5sumMismatch: Another definition.
        HandshakeRefused: The header is an error.
        RemoteProtocolError: A required field is missing, or the topic is another.
    """
    name = _check_required(fields, topic, peer, "subscriber", ("topic", "md5sum", "callerid"))
    if fields["topic"] != topic:
        raise RemoteProtocolError(f"{name} wants topic {fields['topic']}, this link is for {topic}")
    if md5sum == ANY != fields["md5sum"]:
        raise _types_differ(fields, topic, type_name, md5sum, peer)
    _check_md5sum(fields, topic, type_name, md5sum, peer, "asks for")


def check_publisher_header(
    fields: Mapping[str, str], *, topic: str, type_name: str, md5sum: str, peer: str = ""
) -> PublisherReply:
    """On the subscriber: check a publisher's header. With "*", the reply's type and md5sum are accepted; they
    are "*" as well if it publishes AnyMsg.

    Raises:
        Md5sumMismatch: Another definition; `message_definition` has the publisher's full text. Also if the
            publisher refused us and its text names another md5sum.
        HandshakeRefused: The publisher refused us for another reason.
        RemoteProtocolError: A required field is missing.
    """
    _check_refusal(fields, topic, type_name, md5sum, peer)
    name = _check_required(fields, topic, peer, "publisher", ("md5sum",))
    _check_md5sum(fields, topic, type_name, md5sum, peer, "offers")
    real_type, real_md5sum = _real(fields, type_name, md5sum, name)
    return PublisherReply(
        callerid=fields.get("callerid", ""),
        type_name=real_type,
        md5sum=real_md5sum,
        message_definition=fields.get("message_definition", ""),
    )


def check_service_client_header(
    fields: Mapping[str, str], *, service: str, type_name: str, md5sum: str, peer: str = ""
) -> ServiceRequest:
    """On the service server: check a client's header. `str(error)` is the text for `error_header`.

    Raises:
        Md5sumMismatch: Another definition.
        RemoteProtocolError: A required field is missing, or the service is another.
    """
    name = _check_required(fields, service, peer, "service client", ("service", "md5sum", "callerid"))
    if fields["service"] != service:
        raise RemoteProtocolError(f"{name} wants service {fields['service']}, this link is for {service}")
    _check_md5sum(fields, service, type_name, md5sum, peer, "asks for")
    return ServiceRequest(fields["callerid"], _flag(fields, "persistent"), _flag(fields, "probe"))


def check_service_server_header(
    fields: Mapping[str, str], *, service: str, type_name: str, md5sum: str, peer: str = ""
) -> None:
    """On the service client: check a server's header. With "*", any type and md5sum are accepted.

    Raises:
        Md5sumMismatch: Another definition.
        HandshakeRefused: The server refused us.
        RemoteProtocolError: A required field is missing.
    """
    _check_refusal(fields, service, type_name, md5sum, peer)
    _check_required(fields, service, peer, "service server", ("md5sum",))
    _check_md5sum(fields, service, type_name, md5sum, peer, "offers")


def is_md5sum(text: str) -> bool:
    """Whether a text has the form of an md5sum; peers send texts of any length."""
    return re.fullmatch(r"[0-9a-f]{32}", text) is not None


def _refuse_wildcard(what: str, type_name: str, md5sum: str) -> None:
    if ANY in (type_name, md5sum) or not type_name or not md5sum:
        raise LocalProtocolError(
            f"{what}: type {type_name!r} and md5sum {md5sum!r} must be real, not '*' or empty"
        )


def _flag(fields: Mapping[str, str], key: str) -> bool:
    return fields.get(key, "").strip().lower() in _TRUE


def _check_required(
    fields: Mapping[str, str], name: str, peer: str, role: str, required: tuple[str, ...]
) -> str:
    """Raise unless all fields are present; return the name of the peer for errors."""
    who = f"{name}: {role} {fields.get('callerid', '')} at {peer or 'unknown address'}"
    if "error" in fields:
        raise HandshakeRefused(name, peer, fields["error"])
    # rospy takes an empty callerid.
    missing = [key for key in required if not fields.get(key) and (key != "callerid" or key not in fields)]
    if missing:
        raise RemoteProtocolError(
            f"{who}: connection header without {', '.join(missing)}; "
            f"it has {', '.join(fields) or 'no fields'}"
        )
    return who


def _check_refusal(fields: Mapping[str, str], name: str, type_name: str, md5sum: str, peer: str) -> None:
    """Raise for an `error` reply; if its text names another md5sum, that is the cause (rospy, roscpp)."""
    text = fields.get("error")
    if text is None:
        return
    others = [found for found in re.findall(_MD5SUM, text) if found != md5sum]
    if not others:
        raise HandshakeRefused(name, peer, text)
    raise Md5sumMismatch(
        f"{name}: {peer or 'the other side'} refused {type_name} with md5sum {md5sum}: {text}; "
        "use the definition the other side has",
        name=name,
        peer=peer,
        type_name=type_name,
        md5sum=md5sum,
        remote_md5sum=others[0],
    )


def _types_differ(
    fields: Mapping[str, str], topic: str, type_name: str, md5sum: str, peer: str
) -> Md5sumMismatch:
    """The error for a definite type requested from a publisher of AnyMsg, in rospy's words."""
    asked = fields.get("type", "")
    text = (
        f"{topic}: topic types do not match: [{asked or fields['md5sum']}] vs. [{type_name}]; it is published"
        " as AnyMsg, which has no type: subscribe with AnyMsg, or have the relay publish the type"
    )
    return _mismatch(text, fields, topic, type_name, md5sum, peer)


def _mismatch(
    text: str, fields: Mapping[str, str], name: str, type_name: str, md5sum: str, peer: str
) -> Md5sumMismatch:
    return Md5sumMismatch(
        text,
        name=name,
        peer=peer,
        type_name=type_name,
        md5sum=md5sum,
        remote_type=fields.get("type", ""),
        remote_md5sum=fields["md5sum"],
        message_definition=fields.get("message_definition", ""),
    )


def _check_md5sum(
    fields: Mapping[str, str],
    name: str,
    type_name: str,
    md5sum: str,
    peer: str,
    verb: str,
) -> None:
    theirs = fields["md5sum"]
    if md5sum == theirs or ANY in (md5sum, theirs):
        return
    remote_type = fields.get("type", "")
    who = " ".join(part for part in (fields.get("callerid", ""), f"({peer})" if peer else "") if part)
    text = (
        f"{name}: {who or 'the other side'} {verb} {remote_type or 'an unnamed type'} with md5sum {theirs}, "
        f"expected {type_name} with md5sum {md5sum}; compare the two definitions "
        "(error.message_definition has the other side's, when it sent one)"
    )
    raise _mismatch(text, fields, name, type_name, md5sum, peer)


def _real(fields: Mapping[str, str], type_name: str, md5sum: str, name: str) -> tuple[str, str]:
    """Type and md5sum of the messages sent: the publisher's; ours where an old peer left its type out."""
    real_md5sum = fields["md5sum"] if fields["md5sum"] != ANY else md5sum
    real_type = fields.get("type", "")
    if md5sum == real_md5sum == real_type == ANY:
        return ANY, ANY
    if real_type in ("", ANY):
        real_type = type_name
    if ANY in (real_md5sum, real_type) or not real_type:
        raise RemoteProtocolError(
            f"{name} did not say which type it sends, and this side did not ask for one"
        )
    return real_type, real_md5sum
