"""The `type` argument of topics and services: a class, a "package/Type" name, or None.

None takes the publisher's own type from its connection header (`learn_type`), or asks the provider of a
service for it.

Source: wiki.ros.org/ROS/Connection Header (`message_definition`).
"""

from __future__ import annotations

from rosproto.codec import Message, ServiceType, define, message_class, service_class
from rosproto.errors import CodecError, DefinitionError, LocalProtocolError, RemoteProtocolError
from rosproto.msg import bundled
from rosproto.node.definitions.known_definitions import KnownDefinitions
from rosproto.node.definitions.topic_type import ANY, WILDCARD, TopicType
from rosproto.sentence import say

TypeGiven = type[Message] | str | None
"""A message class, "package/Type", or None: take the publisher's own definition."""

ServiceTypeGiven = type | str | None
"""A service class, "package/Type", or None: ask the provider for its type."""


def resolve_type(given: object, definitions: KnownDefinitions | None = None) -> TopicType:
    """Resolve a `type` argument; a name is looked up by `KnownDefinitions.library_for`.

    Raises:
        DefinitionError: No such type is known.
        TypeError: It has none of the three forms.
    """
    if given is None or given == ANY:
        return WILDCARD
    if isinstance(given, str):
        return TopicType(message_class(given, definitions.library_for(given) if definitions else None))
    if isinstance(given, type) and hasattr(given, "_md5sum") and hasattr(given, "_type"):
        return TopicType(given)
    text = 'a topic type is a message class, a "package/Type" string or None, not {kind} {given!r}'
    raise TypeError(say(text, kind=type(given).__name__, given=given))


def resolve_service_type(
    type_: ServiceTypeGiven, service: str, definitions: KnownDefinitions | None = None
) -> type[ServiceType]:
    """The service class; a name is looked up as by `resolve_type`.

    Raises:
        DefinitionError: There is no such service type.
        LocalProtocolError: It is not a service type.
    """
    if isinstance(type_, str):
        return service_class(type_, definitions.library_for(type_, "srv") if definitions else None)
    if type_ is not None and hasattr(type_, "_request_class") and hasattr(type_, "_md5sum"):
        return type_
    text = 'service {name}: {given!r} is not a service type; give a class or "std_srvs/SetBool"'
    raise LocalProtocolError(say(text, name=service, given=type_))


def bundled_text(name: str, md5sum: str) -> str:
    """The bundled definition if it has this md5sum, for publishers that send none; else ""."""
    try:
        library = bundled()
        return library.full_text(name) if library.md5sum(name) == md5sum else ""
    except DefinitionError:
        return ""


def learn_type(name: str, md5sum: str, definition: str, *, topic: str, peer: str) -> TopicType:
    """The type a publisher described in its connection header.

    A bundled definition with the same md5sum is preferred, because programs import its class.

    Raises:
        RemoteProtocolError: The text is not a definition, or does not have the announced md5sum.
    """
    try:
        known = TopicType(message_class(name))
        if known.md5sum == md5sum:
            return known
    except DefinitionError:
        pass  # not bundled: use the publisher's text
    try:
        learned = TopicType(define(name, definition))
    except (DefinitionError, CodecError, ValueError) as error:
        text = "{topic}: {peer} sent a definition of {type} that cannot be used: {error}"
        raise RemoteProtocolError(say(text, topic=topic, peer=peer, type=name, error=error)) from error
    if learned.md5sum != md5sum:
        text = (
            "{topic}: {peer} announces {type} with md5sum {md5sum}, but the definition it sent has "
            "{other}: its messages are rejected, because they could be decoded wrongly"
        )
        text = say(text, topic=topic, peer=peer, type=name, md5sum=md5sum, other=learned.md5sum)
        raise RemoteProtocolError(text)
    return learned
