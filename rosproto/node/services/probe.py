"""Find the provider of a service, check whether it answers, wait for it.

Source: wiki.ros.org/ROS/Master_API (lookupService), wiki.ros.org/ROS/TCPROS; the `probe` field is
rospy's and roscpp's: the provider answers with its header and closes, no request follows.
"""

from __future__ import annotations

import threading

from rosproto.errors import ConnectionLost, MasterError, RosError, RosTimeout, ServiceError
from rosproto.node.graph.master_client import CallerIdentity
from rosproto.node.services.link import ServiceLink
from rosproto.protocol.handshake import HandshakeRefused, service_client_header
from rosproto.sentence import advice, say
from rosproto.transport.backoff import Backoff
from rosproto.transport.deadline import Deadline
from rosproto.transport.uri import parse_uri

# A provider usually appears within a second. After that, two requests a second limit the load of a master
# with many clients.
FIRST_PAUSE_SECONDS = 0.02
MAX_PAUSE_SECONDS = 0.5
MAX_PROBE_SECONDS = 5.0  # seconds: a provider that is silent may be replaced by another one meanwhile


def lookup(caller: CallerIdentity, service: str, deadline: Deadline) -> tuple[str, int]:
    """Address of the current provider, from the master.

    Raises:
        ServiceError: The master knows no provider.
        MasterError: The master's answer is not a usable address.
    """
    try:
        uri = caller.master.lookup_service(service, timeout=_step(deadline, f"lookup of service {service}"))
    except MasterError as error:
        raise ServiceError(
            service,
            advice(
                "no node provides it (master {master}: {text}); start the provider, check the name and its "
                "namespace, or wait for it with wait()",
                key="not-there",
                master=caller.master.uri,
                text=error.text,
            ),
        ) from error
    try:
        return parse_uri(uri)
    except ValueError as error:
        raise MasterError(
            "lookupService", 1, f"unusable service URI {uri!r}", uri=caller.master.uri
        ) from error


def _step(deadline: Deadline, what: str) -> float | None:
    deadline.check(what)
    return deadline.remaining()


def probe(
    caller: CallerIdentity, service: str, deadline: Deadline, *, address: tuple[str, int] | None = None
) -> dict[str, str]:
    """The provider's connection header: `type`, `md5sum`, `callerid` and further fields.

    Raises:
        ServiceError: No provider is registered, or the registered one does not provide the service.
        ConnectionLost: The provider cannot be reached.
        RosTimeout: The deadline passed.
    """
    fields = service_client_header(service=service, md5sum="*", callerid=caller.name, probe=True)
    address = address or lookup(caller, service, deadline)
    try:
        link = ServiceLink.open(
            address, fields, service=service, limits=caller.limits, deadline=deadline, hosts=caller.hosts
        )
    except HandshakeRefused as error:
        raise ServiceError(service, error.text) from None
    link.close()
    return link.header


def wait(
    caller: CallerIdentity, service: str, timeout: float | None, *, stop: threading.Event | None = None
) -> None:
    """Return as soon as a provider of `service` answers a probe.

    Args:
        caller: Identity of the calling node.
        service: Resolved name.
        timeout: Seconds; None waits for ever.
        stop: Ends the wait early with ConnectionLost (the client or node was closed).

    Raises:
        RosTimeout: No provider answered in time; the text gives the last reason.
        ConnectionLost: `stop` was set.
    """
    deadline, pause, stop = (
        Deadline(timeout),
        Backoff(FIRST_PAUSE_SECONDS, maximum=MAX_PAUSE_SECONDS),
        stop or threading.Event(),
    )
    reason: RosError | None = None
    while True:
        try:
            probe(caller, service, deadline.at_most(MAX_PROBE_SECONDS))
            return
        except RosError as error:
            # The last attempt may have had no time left for a result.
            if reason is None or not (deadline.expired and isinstance(error, RosTimeout)):
                reason = error
        remaining = deadline.remaining()
        if remaining == 0:
            text = "service {name} did not appear within {timeout} s: {why}"
            text = say(text, name=service, timeout=timeout, why=reason)
            raise RosTimeout(text, what=f"service {service}", seconds=timeout) from reason
        delay = pause.next()
        if stop.wait(delay if remaining is None else min(delay, remaining)):
            text = say("service {name}: closed while waiting for it", name=service)
            raise ConnectionLost(text, peer=caller.master.uri)
