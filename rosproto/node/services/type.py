"""What "type" means when a service is opened: a class, a "package/Type" name, or None to ask the provider."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rosproto.codec import service_class
from rosproto.errors import LocalProtocolError, ServiceError
from rosproto.node.revisions.revisions import Revisions
from rosproto.node.services import probe as service_probe
from rosproto.transport.deadline import Deadline

if TYPE_CHECKING:
    from rosproto.node.graph.caller import Caller

ServiceTypeGiven = type | str | None
"""A service class, "package/Type", or None: ask the provider for its type."""

PROBE_SECONDS = 10.0


def resolve_service_type(type_: Any, service: str, revisions: Revisions | None = None) -> Any:
    """The service class; a name is looked for as `resolve_type` does.

    Raises:
        DefinitionError: There is no such service type.
        LocalProtocolError: It is no service type.
    """
    if isinstance(type_, str):
        return service_class(type_, revisions.library_for(type_, "srv") if revisions else None)
    if hasattr(type_, "_request_class") and hasattr(type_, "_md5sum"):
        return type_
    raise LocalProtocolError(
        f'service {service}: {type_!r} is no service type; give a class such as SetBool or "std_srvs/SetBool"'
    )


def ask_type(caller: Caller, revisions: Revisions, service: str) -> Any:
    """The class of what the present provider says it provides.

    Raises:
        ServiceError, ConnectionLost, RosTimeout: It cannot be asked.
        DefinitionError: We have no definition of its type.
    """
    name = service_probe.probe(caller, service, Deadline(PROBE_SECONDS)).get("type", "")
    if not name or name == "*":
        raise ServiceError(service, "its provider does not tell the type; give it")
    return service_class(name, revisions.library_for(name, "srv"))
