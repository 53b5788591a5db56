"""The types of topics in the graph, which a client's types are compared with, and of services."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping

from rosproto.bounded_cache import BoundedCache
from rosproto.errors import RosError
from rosproto.gateway.access import Refused
from rosproto.logs import get_logger
from rosproto.node import Node
from rosproto.node.services.probe import probe
from rosproto.transport.deadline import Deadline
from rosproto.transport.uri import parse_uri

_log = get_logger("rosproto.gateway")


def topic_type(node: Node, topic: str) -> str | None:
    """The type of a topic by the master; None if unknown.

    Raises:
        MasterError, ConnectionLost, RosTimeout: The master does not answer.
    """
    known = node.master.get_topic_types().get(topic)
    return None if known in (None, "", "*") else known


def insist_type(node: Node, topic: str, type_name: str) -> None:
    """Check a client's type of a topic.

    The master also remembers types of nodes that have left; a type that no other node uses does not count.

    Raises:
        Refused: Other nodes use the topic with another type.
        MasterError, ConnectionLost, RosTimeout: The master does not answer.
    """
    known = topic_type(node, topic)
    if known is None or known == type_name:
        return
    state = node.master.get_system_state()
    if {*state.publishers.get(topic, ()), *state.subscribers.get(topic, ())} - {node.name}:
        raise Refused(f"{topic} is of type {known}, not {type_name[:200]}")


MAX_REMEMBERED = 2000
PROBE_SECONDS = 2.0  # longest time for one probe
AGAIN_AFTER_SECONDS = 10.0  # until a provider that did not answer is probed again


class ServiceTypes:
    """The connection headers of providers, each probed once. Thread-safe.

    Args:
        node: Probes the providers.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._headers: BoundedCache[tuple[str, str], tuple[Mapping[str, str], float]] = BoundedCache(
            MAX_REMEMBERED
        )

    def known(self, service: str, provider: str) -> Mapping[str, str] | None:
        """The header of a provider; empty if it did not answer, None if it is to be probed."""
        header, valid_until = self._headers.get((service, provider)) or ({}, 0.0)
        return header if time.monotonic() < valid_until else None

    def header(self, service: str, provider: str, deadline: Deadline | None = None) -> Mapping[str, str]:
        """The header of a provider, which is probed if need be; empty if it does not answer.

        Args:
            service: Name of the service.
            provider: The provider's address (rosrpc://...), or its node's name; another one is probed again.
            deadline: For the probe.
        """
        header = self.known(service, provider)
        if header is not None:
            return header
        try:
            address = parse_uri(provider) if "://" in provider else None
            limit = Deadline(None) if deadline is None else deadline
            header = probe(self._node, service, limit.at_most(PROBE_SECONDS), address=address)
            valid_until = math.inf
        except (RosError, OSError, ValueError) as problem:
            _log.info("! the type of %s is not known: %s", service, problem)
            header, valid_until = {}, time.monotonic() + AGAIN_AFTER_SECONDS
        self._headers.put((service, provider), (header, valid_until))
        return header
