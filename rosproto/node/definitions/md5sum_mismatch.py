"""Peers with a different md5sum: messages and service calls are converted by field name, or refused.

Definitions differ between firmware versions. If an md5sum differs, the peer's definition is looked up
(`known_definitions.py`: bundled revisions, the user's folders, the text sent by the peer). If it is found and
compatible, values are converted by field name (`rosproto.codec.conversion`); otherwise the user gets an
error. This module is not used while the md5sums agree.
"""

from __future__ import annotations

from rosproto.codec import Message, ServiceType, define
from rosproto.codec.conversion import Conversion, ConversionError, side_by_side
from rosproto.errors import CodecError, DefinitionError, Md5sumMismatch
from rosproto.logs import PeerLog
from rosproto.node.definitions.known_definitions import KnownDefinitions
from rosproto.node.definitions.topic_type import TopicType
from rosproto.protocol.framing import BytesLike, Decode


class UnconvertibleMessage(Message):
    """Replaces a message whose values do not fit our definition."""

    __slots__ = ("error",)

    def __init__(self, error: CodecError) -> None:
        self.error = error

    def _fill(self) -> None:
        self._connection_header = None


class RevisedType(TopicType):
    """A peer's revision of our type, decoded as ours.

    Attributes:
        theirs: The peer's definition, as a type.
        conversion: From the peer's to ours.
    """

    __slots__ = ("conversion", "theirs")

    def __init__(self, theirs: type[Message], ours: TopicType) -> None:

        super().__init__(ours.message_class)
        self.theirs = TopicType(theirs)
        self.conversion = Conversion(theirs, ours.message_class)

    @property
    def decode(self) -> Decode[Message]:
        """(buffer, start, end) -> message of our class, or `UnconvertibleMessage`."""
        decode, convert = self.theirs.decode, self.conversion.convert

        def decode_and_convert(buffer: BytesLike, start: int, end: int) -> Message:
            message = decode(buffer, start, end)  # an error here means that the stream is out of sync
            try:
                converted: Message = convert(message)
                return converted
            except CodecError as error:
                return UnconvertibleMessage(error)

        return decode_and_convert

    @property
    def may_be_large(self) -> bool:
        return self.theirs.may_be_large


class ServiceRevision:
    """A peer's revision of our service.

    Attributes:
        md5sum: The peer's.
        request_class, response_class: The peer's.
    """

    def __init__(self, ours: type[ServiceType], theirs: type[ServiceType]) -> None:
        self.md5sum = theirs._md5sum
        self.request_class = theirs._request_class
        self.response_class = theirs._response_class
        self.request_to_theirs = Conversion(ours._request_class, theirs._request_class)
        self.request_to_ours = Conversion(theirs._request_class, ours._request_class)
        self.response_to_theirs = Conversion(ours._response_class, theirs._response_class)
        self.response_to_ours = Conversion(theirs._response_class, ours._response_class)


def note_differences(said: PeerLog, what: str, peer: str, conversion: Conversion) -> None:
    """Log, once per link, the fields that only one side has."""
    parts = []
    if conversion.dropped:
        parts.append(f"dropped (no such field there): {', '.join(conversion.dropped)}")
    if conversion.defaulted:
        parts.append(f"given their default: {', '.join(conversion.defaulted)}")
    said.warning(
        what,
        "= %s: %s has another revision of %s; %s",
        what,
        peer,
        conversion.source._type,
        "; ".join(parts) or "every field has a counterpart",
    )


def explained(
    mismatch: Md5sumMismatch, ours: type[Message | ServiceType], definition: str = "", why: str = ""
) -> Md5sumMismatch:
    """The mismatch, with both definitions if the peer's is known."""
    table = why
    if definition and not table and issubclass(ours, Message):
        try:
            theirs = define(mismatch.remote_type or ours._type, definition)
            table = side_by_side(ours._spec, theirs._spec)
        except (DefinitionError, CodecError, ValueError, AttributeError):  # a class of genpy has no _spec
            table = ""
    return Md5sumMismatch(
        f"{mismatch}\n{table}"
        if table
        else f"{mismatch}; nobody here knows that definition: try `woosh learn`",
        name=mismatch.name,
        peer=mismatch.peer,
        type_name=mismatch.type_name,
        md5sum=mismatch.md5sum,
        remote_type=mismatch.remote_type,
        remote_md5sum=mismatch.remote_md5sum,
        message_definition=definition or mismatch.message_definition,
    )


def revised_type(
    definitions: KnownDefinitions, ours: TopicType, md5sum: str, definition: str, mismatch: Md5sumMismatch
) -> RevisedType:
    """The peer's revision of a topic type.

    Raises:
        Md5sumMismatch: It is unknown, or values cannot be converted; shows both definitions if known.
    """
    theirs = definitions.message(ours.message_class, md5sum, definition)
    if theirs is None:
        raise explained(mismatch, ours.message_class, definition) from None
    try:
        return RevisedType(theirs, ours)
    except ConversionError as error:
        raise explained(mismatch, ours.message_class, definition, str(error)) from error


def revised_service(
    definitions: KnownDefinitions, ours: type[ServiceType], md5sum: str, mismatch: Md5sumMismatch
) -> ServiceRevision:
    """The peer's revision of a service.

    Raises:
        Md5sumMismatch: The other side's definition is not known, or its values cannot be converted.
    """
    theirs = definitions.service(ours, md5sum)
    if theirs is None:
        raise explained(mismatch, ours) from None
    try:
        return ServiceRevision(ours, theirs)
    except ConversionError as error:
        raise explained(mismatch, ours, "", str(error)) from error
