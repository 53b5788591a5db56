"""The types of services, which only their providers know: asked for by a probe, remembered for a while."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from rosproto.bounded_cache import BoundedCache
from rosproto.errors import RosError
from rosproto.transport.address import parse_uri
from rosproto.transport.deadline import Deadline

if TYPE_CHECKING:
    from rosproto.node import Node

__all__ = ["ServiceTypes"]

MOST_REMEMBERED = 2000
PROBE_SECONDS = 2.0  # for one provider that does not answer
AGAIN_AFTER = 10.0  # seconds until a provider that did not answer is asked again


class ServiceTypes:
    """Types by service name; safe from any thread.

    A provider is identified by its address: when another one takes over the service, it is asked again.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._types: BoundedCache[tuple[str, str], str] = BoundedCache(MOST_REMEMBERED)
        self._silent: BoundedCache[tuple[str, str], float] = BoundedCache(MOST_REMEMBERED)

    def of(self, service: str, deadline: Deadline) -> str:
        """Its type; "" when nobody provides it, or the provider does not say."""
        try:
            uri = self._node.master.lookup_service(service, timeout=deadline.remaining())
        except RosError:
            return ""
        known = self._types.get((service, uri))
        if known is not None:
            return known
        if time.monotonic() - (self._silent.get((service, uri)) or -AGAIN_AFTER) < AGAIN_AFTER:
            return ""
        from rosproto.node.services.probe import probe

        try:
            header = probe(self._node, service, deadline.at_most(PROBE_SECONDS), address=parse_uri(uri))
        except (RosError, ValueError, OSError):
            self._silent.put((service, uri), time.monotonic())
            return ""
        type_name = header.get("type", "")
        self._types.put((service, uri), type_name)
        return type_name
