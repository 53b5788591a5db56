"""Types for /rosapi, as rosapi/TypeDef: one dict for a type and one for each type it uses.

Definitions come from the node, the bundled ones, or a publisher; those of services, which are not on the
wire, only from the bundled ones and the user's.

Fields are described as by rosapi's objectutils.py, which reads genpy's classes: builtin types by their name,
examples as Python prints the default value, and constants sorted by name. Where the original fails (a field
of type `char`), the description follows the definition.
"""

from __future__ import annotations

import re
from collections.abc import Callable

from rosproto.bounded_cache import BoundedCache
from rosproto.errors import DefinitionError, RosError
from rosproto.gateway.access import Access
from rosproto.gateway.rosbridge.rosapi.graph import RosapiError
from rosproto.gateway.values import definition_name
from rosproto.msg import (
    BUILTIN_TYPES,
    DefinitionLibrary,
    Field,
    FieldType,
    MessageSpec,
    bundled,
    library_from_full_text,
)
from rosproto.node import Node, probe_topic
from rosproto.transport.deadline import Deadline

MAX_TYPES = 300  # of one answer, and the greatest depth: definitions from robots are not trusted
_TIMES = ("time", "duration")
_PARTS_OF_TIME = tuple(Field(name, FieldType("int32")) for name in ("secs", "nsecs"))
_EXAMPLES = {"bool": "False", "string": "", "float32": "0.0", "float64": "0.0"}

Typedef = dict[str, object]


def type_details(spec: MessageSpec, find: Callable[[str], MessageSpec]) -> list[Typedef]:
    """The typedefs of a message and of all types it uses, in order of their first use.

    Args:
        spec: The message, or one half of a service.
        find: Returns the definition of a type by its full name; its exceptions are passed on.
    """
    seen = {spec.name}
    found: list[Typedef] = []

    def visit(spec: MessageSpec) -> None:
        found.append(_typedef(spec))
        for field in spec.fields:
            base = field.type.base
            if base in seen or len(seen) >= MAX_TYPES:
                continue
            seen.add(base)
            if base in _TIMES:
                found.append(_typedef(MessageSpec(base, _PARTS_OF_TIME, (), "")))
            elif not field.type.is_builtin:
                visit(find(base))

    visit(spec)
    return found


def _typedef(spec: MessageSpec) -> Typedef:
    constants = sorted(spec.constants, key=lambda constant: constant.name)
    return {
        "type": spec.name,
        "fieldnames": [field.name for field in spec.fields],
        "fieldtypes": [field.type.base for field in spec.fields],
        "fieldarraylen": [_array_length(field.type) for field in spec.fields],
        "examples": [_example(field.type) for field in spec.fields],
        "constnames": [constant.name for constant in constants],
        "constvalues": [str(constant.value) for constant in constants],
    }


def _array_length(type_: FieldType) -> int:
    return type_.array_length or 0 if type_.is_array else -1


def _example(type_: FieldType) -> str:
    if type_.is_array:
        return "[]"
    if type_.base in _TIMES or not type_.is_builtin:
        return "{}"
    return _EXAMPLES.get(type_.base, "0")


MAX_LEARNED = 256
MAX_CHARACTERS = 4 << 20
MAX_ASKED = 3  # publishers of one type
ASK_SECONDS = 3.0


class Definitions:
    """Definitions by type name, for one node. Thread-safe."""

    def __init__(self, node: Node, access: Access) -> None:
        self._node = node
        self._access = access
        self._learned: BoundedCache[str, DefinitionLibrary] = BoundedCache(MAX_LEARNED, MAX_CHARACTERS)

    def message_details(self, name: str) -> list[Typedef]:
        """Typedefs of a message type; none for a builtin type, as in the original."""
        if name in BUILTIN_TYPES:
            alone = MessageSpec("", (Field("", FieldType(name)),), (), "")
            return type_details(alone, bundled().message)[1:]
        name = self._full_name(name)
        library = self._library(name)
        return self._guard(name, lambda: type_details(library.message(name), library.message))

    def service_details(self, name: str, half: str) -> list[Typedef]:
        """Typedefs of the "request" or "response" of a service type."""
        name = self._full_name(name)
        library = self._node.definitions.library_for(name, "srv") or bundled()
        return self._guard(name, lambda: type_details(getattr(library.service(name), half), library.message))

    def full_text(self, name: str, deadline: Deadline | None = None) -> str:
        """The definition with all types it uses, as in a connection header; "" if unknown."""
        try:
            return self._library(self._full_name(name), deadline).full_text(name, kind="msg")
        except (RosapiError, DefinitionError):
            return ""

    @staticmethod
    def _full_name(name: str) -> str:
        full = definition_name(name)
        if not re.fullmatch("[^/]+/[^/]+", full):
            raise RosapiError(f'"{name}" is not a type; expected package/Type, such as std_msgs/String')
        return full

    @staticmethod
    def _guard(name: str, details: Callable[[], list[Typedef]]) -> list[Typedef]:
        try:
            return details()
        except DefinitionError as error:
            raise RosapiError(f"{name}: its definition is not known here: {error}") from error

    def _library(self, name: str, deadline: Deadline | None = None) -> DefinitionLibrary:
        library = self._node.definitions.library_for(name)
        if library is not None:
            return library
        if bundled().has("msg", name):
            return bundled()
        learned = self._learned.get(name) or self._ask(name, deadline or Deadline(ASK_SECONDS))
        if learned is None:
            raise RosapiError(
                f"the definition of {name} is not known here, "
                "and no publisher of a visible topic has sent it; "
                "give the gateway a folder of .msg files (msg_path)"
            )
        return learned

    def _ask(self, name: str, deadline: Deadline) -> DefinitionLibrary | None:
        """Get the definition from the connection headers of the type's publishers."""
        node = self._node
        try:
            types = node.master.get_topic_types(timeout=deadline.remaining())
            publishers = node.master.get_system_state(timeout=deadline.remaining()).publishers
        except (RosError, OSError):
            return None
        topics = [topic for topic, kind in types.items() if kind == name and topic in publishers]
        places = [(topic, node_name) for topic in topics for node_name in publishers[topic]]
        shown = [(topic, who) for topic, who in places if self._access.shows("topic", topic)]
        for topic, publisher in shown[:MAX_ASKED]:
            try:
                reply = probe_topic(node, topic, publisher, deadline)
                if reply.type_name != name:
                    continue
                library = library_from_full_text(name, reply.message_definition)
            except (RosError, OSError):
                continue  # try the next one
            self._learned.put(name, library, len(reply.message_definition))
            return library
        return None
