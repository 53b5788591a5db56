"""Learn an unknown type from the definition in a publisher's connection header.

Source: wiki.ros.org/ROS/Connection Header (`message_definition`).
"""

from __future__ import annotations

from rosproto.codec import define, message_class
from rosproto.errors import CodecError, DefinitionError, RemoteProtocolError
from rosproto.node.definitions.topic_type import TopicType


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
        raise RemoteProtocolError(
            f"{topic}: {peer} describes {name} in a text that cannot be used: {error}"
        ) from error
    if learned.md5sum != md5sum:
        raise RemoteProtocolError(
            f"{topic}: {peer} announces {name} with md5sum {md5sum}, but the definition it sent has"
            f" {learned.md5sum}: its messages could be decoded wrongly, so they are not taken"
        )
    return learned
