"""The `type` argument of topics and services: a class, a "package/Type" name, or None.

None takes the publisher's own type (`unknown_type.py`), or asks the provider of a service for it.
"""

from __future__ import annotations

from typing import Any, Protocol

from rosproto.codec import Message, message_class, service_class
from rosproto.errors import LocalProtocolError
from rosproto.msg import DefinitionLibrary
from rosproto.node.definitions.topic_type import ANY, WILDCARD, TopicType

TypeGiven = type[Message] | str | None
"""A message class, "package/Type", or None: take the publisher's own definition."""

ServiceTypeGiven = type | str | None
"""A service class, "package/Type", or None: ask the provider for its type."""


class DefinitionSource(Protocol):
    """Finds the definition of a type that is given by name: `KnownDefinitions`."""

    def library_for(self, name: str, kind: str = "msg") -> DefinitionLibrary | None:
        """The library that has it; None for the bundled one."""


def resolve_type(given: Any, revisions: DefinitionSource | None = None) -> TopicType:
    """Resolve a `type` argument; a name is looked up by `KnownDefinitions.library_for`.

    Raises:
        DefinitionError: No such type is known.
        TypeError: It has none of the three forms.
    """
    if given is None or given == ANY:
        return WILDCARD
    if isinstance(given, str):
        return TopicType(message_class(given, revisions.library_for(given) if revisions else None))
    if isinstance(given, type) and hasattr(given, "_md5sum") and hasattr(given, "_type"):
        return TopicType(given)
    raise TypeError(
        f'a topic type is a message class, a "package/Type" string or None,'
        f" not {type(given).__name__} {given!r}"
    )


def resolve_service_type(type_: Any, service: str, revisions: DefinitionSource | None = None) -> Any:
    """The service class; a name is looked up as by `resolve_type`.

    Raises:
        DefinitionError: There is no such service type.
        LocalProtocolError: It is not a service type.
    """
    if isinstance(type_, str):
        return service_class(type_, revisions.library_for(type_, "srv") if revisions else None)
    if hasattr(type_, "_request_class") and hasattr(type_, "_md5sum"):
        return type_
    raise LocalProtocolError(
        f'service {service}: {type_!r} is no service type; give a class such as SetBool or "std_srvs/SetBool"'
    )
