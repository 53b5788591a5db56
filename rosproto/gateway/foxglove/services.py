"""Services for viewers: finds their types, and calls them.

Only the provider of a service knows its type. Each provider is probed once, in the background, while viewers
are connected.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable

from rosproto.codec import ServiceType, decode, encode, service_class
from rosproto.errors import CodecError, RosError
from rosproto.gateway.access import Access, Refused, insist
from rosproto.gateway.foxglove.advertised_channels import AdvertisedService
from rosproto.gateway.foxglove.graph import GraphView
from rosproto.gateway.foxglove.messages import ROS1, Call
from rosproto.gateway.gateway_server import GatewayState
from rosproto.logs import get_logger
from rosproto.node import Node
from rosproto.node.services import probe as service_probe
from rosproto.transport.deadline import Deadline

_log = get_logger("rosproto.gateway")

PROBE_SECONDS = 2.0
AGAIN_AFTER = 30.0


class ServiceTypes:
    """The types of services.

    Args:
        node: Probes the providers.
        access: Which services are visible.
    """

    def __init__(self, node: Node, access: Access) -> None:
        self._node = node
        self._access = access
        self._lock = threading.Lock()
        self._asking = threading.Lock()
        self._found: dict[
            tuple[str, str], tuple[type[ServiceType] | None, float]
        ] = {}  # class or None, and when to probe again

    def present(self, view: GraphView) -> dict[str, type[ServiceType]]:
        """The services of a view whose type is known, with their classes."""
        with self._lock:
            found = {key[0]: self._found.get(key, (None, 0.0))[0] for key in self._open(view)}
        return {name: kind for name, kind in found.items() if kind is not None}

    def _open(self, view: GraphView) -> list[tuple[str, str]]:
        """The visible services of a view: (service, provider)."""
        return [
            (service, nodes[0])
            for service, nodes in sorted(view.state.services.items())
            if nodes and self._access.may_read("service", service) is None
        ]

    def ask(self, view: GraphView, stop: Callable[[], bool]) -> bool:
        """Probe providers that have not been probed yet; True if a type was found. May take a while."""
        if not self._asking.acquire(blocking=False):
            return False
        try:
            found = False
            for key in self._open(view):
                if stop():
                    break
                with self._lock:
                    if time.monotonic() < self._found.get(key, (None, 0.0))[1]:
                        continue
                found |= self._ask_one(key)
            return found
        finally:
            self._asking.release()

    def _ask_one(self, key: tuple[str, str]) -> bool:
        service, _ = key
        try:
            header = service_probe.probe(self._node, service, Deadline(PROBE_SECONDS))
            name = header.get("type", "")
            kind = service_class(name, self._node.definitions.library_for(name, "srv"))
            if header.get("md5sum", kind._md5sum) not in (kind._md5sum, "*"):
                kind = self._node.definitions.service(kind, header["md5sum"]) or kind
        except (RosError, OSError, ValueError) as problem:
            _log.info("! foxglove: %s is not offered: %s", service, problem)
            kind = None
        again = math.inf if kind is not None else time.monotonic() + AGAIN_AFTER
        with self._lock:
            self._found[key] = kind, again
        return kind is not None

    def forget(self, view: GraphView) -> None:
        """Forget all services but those of a view."""
        present = set(self._open(view))
        with self._lock:
            self._found = {key: found for key, found in self._found.items() if key in present}


def call(service: AdvertisedService, asked: Call, state: GatewayState) -> bytes:
    """Call a service for a client; waits for the answer.

    Raises:
        Refused: The client may not call it, or the request is not valid.
        RosError: The call failed.
    """
    kind = service.kind
    insist(state.access.may_write("service", service.name, kind._type))
    if asked.encoding != ROS1:
        raise Refused(f"the request comes as {asked.encoding[:40]!r}, not {ROS1}")
    try:
        request = decode(kind._request_class, asked.data)
    except CodecError as problem:
        raise Refused(f"the request is none of {kind._type}: {problem}") from None
    with state.node.service_client(service.name, kind) as client:
        answer = bytes(encode(client.call(request, timeout=state.limits.call_seconds)))
    if len(answer) > state.limits.answer_bytes // 2:
        raise Refused(f"the answer has {len(answer)} bytes, which is too large")
    return answer
