"""Services for viewers: finds their types, and calls them.

Only the provider of a service knows its type. Each provider is probed once, in the background, while viewers
are connected.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping

from rosproto.codec import ServiceType, decode, encode, service_class
from rosproto.errors import CodecError, RosError
from rosproto.gateway.access import Access, Refused, insist
from rosproto.gateway.foxglove.advertised_channels import AdvertisedService
from rosproto.gateway.foxglove.graph import GraphView
from rosproto.gateway.foxglove.messages import ROS1, Call
from rosproto.gateway.gateway_server import GatewayState
from rosproto.gateway.topic_type import ServiceTypes
from rosproto.node import Node


class ServiceClasses:
    """The classes of the services that viewers see.

    Args:
        node: Probes the providers.
        access: Which services are visible.
    """

    def __init__(self, node: Node, access: Access) -> None:
        self._node = node
        self._access = access
        self._types = ServiceTypes(node)
        self._asking = threading.Lock()

    def present(self, view: GraphView) -> dict[str, type[ServiceType]]:
        """The services of a view whose type is known, with their classes."""
        found = {
            service: self._class_of(self._types.known(service, who)) for service, who in self._open(view)
        }
        return {service: kind for service, kind in found.items() if kind is not None}

    def _open(self, view: GraphView) -> list[tuple[str, str]]:
        """The visible services of a view: (service, provider)."""
        return [
            (service, nodes[0])
            for service, nodes in sorted(view.state.services.items())
            if nodes and self._access.shows("service", service)
        ]

    def ask(self, view: GraphView, stop: Callable[[], bool]) -> bool:
        """Probe providers that have not been probed yet; True if a type was found. May take a while."""
        if not self._asking.acquire(blocking=False):
            return False
        try:
            found = False
            for service, provider in self._open(view):
                if stop():
                    break
                if self._types.known(service, provider) is None:
                    header = self._types.header(service, provider)
                    found |= self._class_of(header) is not None
            return found
        finally:
            self._asking.release()

    def _class_of(self, header: Mapping[str, str] | None) -> type[ServiceType] | None:
        """The class by a provider's header; None if its definition is not known."""
        name = (header or {}).get("type", "")
        try:
            kind = service_class(name, self._node.definitions.library_for(name, "srv"))
        except (RosError, ValueError):
            return None
        md5sum = (header or {}).get("md5sum", kind._md5sum)
        return kind if md5sum in (kind._md5sum, "*") else self._node.definitions.service(kind, md5sum) or kind


def call(service: AdvertisedService, asked: Call, state: GatewayState) -> bytes:
    """Call a service for a client; waits for the answer.

    Raises:
        Refused: The client may not call it, or the request is not valid.
        RosError: The call failed.
    """
    kind = service.kind
    insist(state.access.may_write("service", service.name, kind._type))
    if asked.encoding != ROS1:
        raise Refused(f"the request's encoding is {asked.encoding[:40]!r}, not {ROS1}")
    try:
        request = decode(kind._request_class, asked.data)
    except CodecError as problem:
        raise Refused(f"the request does not match {kind._type}: {problem}") from None
    with state.node.service_client(service.name, kind) as client:
        answer = bytes(encode(client.call(request, timeout=state.limits.call_seconds)))
    if len(answer) > state.limits.answer_bytes // 2:
        raise Refused(f"the answer has {len(answer)} bytes, which is too large")
    return answer
