"""Firmwares of the chassis and their definitions.

A firmware is named by the version of the vendor's message package it was built with, or "page" for the
vendor's interface page taken literally. `msgdefs/woosh_msgs/revisions/revisions.txt` maps firmwares to
definitions and gives the evidence.
"""

from __future__ import annotations

from functools import cache

from rosproto.codec import Conversion, DynamicMessage, Message, ServiceType, message_class, service_class
from rosproto.errors import DefinitionError
from rosproto.msg import DefinitionLibrary, bundled
from rosproto.sentence import say

__all__ = ["CURRENT", "Firmware", "firmware", "firmware_names", "revision_label", "revision_of"]

CURRENT = "1.1.4"
"""The package version of the bundled definitions."""
PACKAGE = "woosh_msgs"


class Firmware:
    """One firmware's definitions.

    Attributes:
        name: The requested name.
        library: All definitions of that firmware.
    """

    def __init__(self, name: str, library: DefinitionLibrary) -> None:
        self.name = name
        self.library = library
        self._conversions: dict[tuple[type, type], Conversion] = {}

    def __repr__(self) -> str:
        return f"<Firmware {self.name}>"

    def message_class(self, name: str) -> type[DynamicMessage]:
        """This firmware's class of a message type."""
        return message_class(name, self.library)

    def service_class(self, name: str) -> type[ServiceType]:
        """This firmware's class of a service type."""
        return service_class(name, self.library)

    def convert(self, message: DynamicMessage, to: type[Message]) -> DynamicMessage:
        """Convert a message to another revision's class by field name; unchanged if the md5sums are equal."""
        source = type(message)
        if source._md5sum == to._md5sum:
            return message
        key = (source, to)
        if key not in self._conversions:
            self._conversions[key] = Conversion(source, to)
        converted: DynamicMessage = self._conversions[key](message)
        return converted


@cache
def firmware(name: str = CURRENT) -> Firmware:
    """A firmware by its package version, or "page".

    An unlisted version has the definitions of the next newer listed one: a listed revision is the last
    before a change.

    Raises:
        ValueError: `name` is neither a version nor "page".
    """
    known = bundled().package_revisions(PACKAGE)
    if name in known:
        return Firmware(name, known[name])
    try:
        wanted = _version(name)
    except ValueError:
        wrong = "firmware {name!r}: expected a version of the vendor's message package, one of {names}"
        raise ValueError(say(wrong, name=name, names=", ".join(firmware_names()))) from None
    newer = sorted((_version(label), label) for label in known if label != "page")
    library = next((known[label] for version, label in newer if version >= wanted), bundled())
    return Firmware(name, library)


def firmware_names() -> list[str]:
    """Firmwares with different definitions, newest first."""
    labels = [label for label in bundled().package_revisions(PACKAGE) if label != "page"]
    return [CURRENT, *sorted(labels, key=_version, reverse=True), "page"]


def _version(label: str) -> tuple[int, ...]:
    return tuple(int(part) for part in label.split("."))


def revision_of(cls: type[Message]) -> tuple[str, str]:
    """(firmware, note) of a class by its md5sum; ("", "") if no bundled revision has it."""
    return revision_label(cls._type, cls._md5sum)


def revision_label(type_name: str, md5sum: str) -> tuple[str, str]:
    """As `revision_of`, for a message or service type and an md5sum."""
    try:
        if bundled().md5sum(type_name) == md5sum:
            return CURRENT, ""
        found = [r for r in bundled().revisions(type_name) if r.md5sum == md5sum]
    except DefinitionError:
        return "", ""
    return (found[0].label, found[0].note) if found else ("", "")
