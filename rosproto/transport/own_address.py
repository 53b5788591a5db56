"""Choose the address of this computer that a node announces, and the one that it listens on.

The order: the argument `host`, `__hostname`, `__ip`, ROS_HOSTNAME, ROS_IP, else the address on the route to
the master. A host *name* that resolves to loopback, as in Debian's /etc/hosts, is announced, but the node
listens on the address towards the master, because others could not reach loopback.

`rosproto/node/graph/listening.py` opens the sockets; `network_interfaces.py` lists every address of this
computer.
"""

from __future__ import annotations

import socket
from collections.abc import Mapping

from rosproto.errors import RosError
from rosproto.sentence import say
from rosproto.transport.deadline import Deadline
from rosproto.transport.name_lookup import resolve
from rosproto.transport.os_errors import translate
from rosproto.transport.uri import format_address, is_loopback, is_numeric


def choose_own_address(host: str | None, master: tuple[str, int], timeout: float) -> tuple[str, str]:
    """Return the host to announce and the address to listen on.

    Args:
        host: As the caller gave it; None: the address that routes to the master.
        master: The master's host and port.
        timeout: Seconds for looking up names.

    Raises:
        ConnectionLost: There is no route to the master, or a name is unknown.
    """
    if host is None:
        address = local_address_towards(*master, timeout)
        return address, address
    addresses = resolve(host)
    if is_loopback(addresses[0]) and not is_loopback(host):
        return host, local_address_towards(*master, timeout)
    return host, addresses[0]


def host_from_environment(
    environment: Mapping[str, str], specials: Mapping[str, str] | None = None
) -> str | None:
    """The host that the user gave for this computer; None if none was given.

    The order is rosgraph.network's: `__hostname` and `__ip` (command line), then ROS_HOSTNAME, then ROS_IP;
    empty ones do not count. Where rosgraph would guess, use `local_address_towards`.

    Raises:
        ValueError: The value is a URI or has a port.
    """
    sources = [(specials or {}, "__hostname"), (specials or {}, "__ip")]
    sources += [(environment, "ROS_HOSTNAME"), (environment, "ROS_IP")]
    for mapping, name in sources:
        host = mapping.get(name, "").strip()
        if host:
            if "/" in host or (":" in host and not is_numeric(host)):
                wrong = "{option}={value!r}: must be a host name or address, without scheme and port"
                raise ValueError(say(wrong, option=name, value=host))
            return host.strip("[]")
    return None


def local_address_towards(host: str, port: int, timeout: float | None = 5.0) -> str:
    """Our own address on the route to a peer: the address that the peer can connect to.

    A UDP socket is connected, which picks a route without sending a packet. rospy and roscpp use the host
    name, the first interface or a public address instead, which fails with VPNs and docker.

    Raises:
        ConnectionLost: The name is unknown or there is no route.
        RosTimeout: The name server did not answer.
    """
    problem: RosError | None = None
    cause: OSError | None = None
    for address in resolve(host, Deadline(timeout)):
        family = socket.AF_INET6 if ":" in address else socket.AF_INET
        try:
            with socket.socket(family, socket.SOCK_DGRAM) as probe:
                probe.connect((address, port or 9))
                return str(probe.getsockname()[0])
        except OSError as error:
            peer = format_address(address, port)
            problem = problem or translate(error, say("find the route to {host}", host=peer), peer)
            cause = cause or error
    assert problem is not None
    raise problem from cause
