"""Hosts, ports and URIs: parsing, resolving, and which of our addresses a peer can reach.

Nothing here asks a name server about a numeric address or about `localhost`, and nothing does reverse DNS:
a missing name server would otherwise cost seconds per connection.
"""

from __future__ import annotations

import socket
import threading
from collections.abc import Mapping

from rosproto.errors import ConnectionLost, RosError
from rosproto.sentence import say
from rosproto.transport.deadline import Deadline
from rosproto.transport.os_errors import translate

DEFAULT_MASTER_URI = "http://localhost:11311/"
_DOTS = "\u3002\uff0e\uff61"  # what RFC 3490 takes for a dot, besides the dot


def parse_uri(uri: str, default_port: int = 80) -> tuple[str, int]:
    """Host and port of an `http://` or `rosrpc://` URI; the host without brackets, in lower case.

    Trailing slash, path and scheme may be absent; "" is the default master. A missing port is
    `default_port`: 80, as rosgraph's parse_http_host_and_port has it, not 11311.

    Raises:
        ValueError: There is no host, or the port is not a port.
    """
    host, port = _split_authority(_authority(uri or DEFAULT_MASTER_URI), uri)
    if not host or any(character.isspace() or character in "@[]" for character in host):
        raise ValueError(say("URI {uri!r}: no host; expected something like http://10.0.0.7:11311/", uri=uri))
    plain_host(host)
    if not port:
        return host, default_port
    if not (port.isascii() and port.isdigit()) or len(port) > 5 or int(port) > 65535:
        raise ValueError(say("URI {uri!r}: port {port!r} is no number from 0 to 65535", uri=uri, port=port))
    return host, int(port)


def plain_host(host: str) -> str:
    """The host, unless it has digits or dots of other scripts.

    Resolvers read those as ASCII, so that what an input method wrote would be another computer to people and
    to `is_loopback` than to the system. Letters of other scripts are names.

    Raises:
        ValueError: It has such.
    """
    if not host.isascii() and any(c in _DOTS or (c.isdigit() and not c.isascii()) for c in host):
        raise ValueError(
            say(
                "host {host!r} has digits or dots that are not ASCII; expected something like 10.0.0.7",
                host=host,
            )
        )
    return host


def _authority(uri: str) -> str:
    return _after_scheme(uri).split("/", 1)[0].split("?", 1)[0].lower()


def _after_scheme(uri: str) -> str:
    scheme, mark, rest = uri.strip().partition("://")
    return rest if mark and "/" not in scheme else uri.strip()


def _split_authority(authority: str, uri: str) -> tuple[str, str]:
    if authority.startswith("["):
        host, bracket, rest = authority[1:].partition("]")
        if not bracket or (rest and not rest.startswith(":")):
            raise ValueError(say("URI {uri!r}: brackets do not match; expected [address]:port", uri=uri))
        return host, rest[1:]
    if authority.count(":") > 1:
        raise ValueError(
            say("URI {uri!r}: an IPv6 address must stand in brackets, as in http://[::1]:11311/", uri=uri)
        )
    host, _, port = authority.partition(":")
    return host, port


def uri_path(uri: str) -> str:
    """The path of a URI; "/" when there is none (every ROS server answers on it)."""
    rest = _after_scheme(uri)
    slash = rest.find("/")
    return rest[slash:] if slash >= 0 else "/"


def format_address(host: str, port: int) -> str:
    """ "host:port", an IPv6 host in brackets."""
    return f"[{host}]:{port}" if ":" in host else f"{host}:{port}"


def make_uri(host: str, port: int, scheme: str = "http") -> str:
    """ "http://host:port/", with the trailing slash that rospy and roscpp register."""
    return f"{scheme}://{format_address(host, port)}/"


def same_uri(one: str, other: str) -> bool:
    """Do two URIs mean the same server: host (any case) and port, as roscpp compares them."""
    if one == other:
        return True
    try:
        return parse_uri(one) == parse_uri(other)
    except ValueError:
        return False


def is_loopback(host: str) -> bool:
    """Is this `localhost`, 127.* or ::1? Judged by the text alone, no name is looked up."""
    host = host.lower().strip("[]").removeprefix("::ffff:")
    return host in ("localhost", "::1") or (host.startswith("127.") and _family(host) == socket.AF_INET)


def is_numeric(host: str) -> bool:
    """Is this an address, so that no name has to be looked up?"""
    return _family(host.strip("[]")) is not None


def resolve(host: str, deadline: Deadline | None = None) -> list[str]:
    """Numeric addresses of a host, the best first: IPv4 before IPv6 (ROS 1 peers speak IPv4).

    Numeric addresses and `localhost` (127.0.0.1 before ::1: Windows would wait two seconds for the other)
    are answered here. A name is looked up in a thread, because the system's resolver knows no time-out.

    Raises:
        ConnectionLost: The name is unknown.
        RosTimeout: The name server did not answer before `deadline` (None: within 10 seconds).
    """
    host = host.strip("[]")
    try:
        plain_host(host)
    except ValueError as error:
        raise ConnectionLost(str(error), peer=host) from None
    if _family(host) is not None:
        return [host]
    if host.lower() == "localhost":
        return ["127.0.0.1", "::1"]
    wrong = _wrong_ipv4(host)
    if wrong:
        raise ConnectionLost(wrong, peer=host)
    return _look_up(host, deadline or Deadline(10.0))


def _wrong_ipv4(host: str) -> str | None:
    """What is wrong with digits and dots that are no address; None for a name.

    No name server is asked: the last part of a name is never a number (RFC 3696, section 2). Short forms that
    some systems' resolvers understand (127.1) are left to them.
    """
    parts = host.removesuffix(".").split(".")
    if not all(part.isascii() and part.isdigit() for part in parts) or len(parts) == 1:
        return None
    large = [part for part in parts if int(part[:9]) > 255]
    if len(parts) > 4:
        why = say("it has {count} numbers, and an address has 4", count=len(parts))
    elif large and len(parts) == 4:
        why = say("{number} is more than 255", number=large[0][:20])
    else:
        return None
    return say(
        "{host} is not a valid IPv4 address: {why}; expected something like 10.0.0.7", host=host[:80], why=why
    )


def _family(host: str) -> socket.AddressFamily | None:
    """The family of a numeric address, None for a name. (Scope ids as in fe80::1%eth0 belong to IPv6.)"""
    for family, text in ((socket.AF_INET, host), (socket.AF_INET6, host.partition("%")[0])):
        try:
            socket.inet_pton(family, text)
        except (OSError, ValueError):
            continue
        return family
    return None


class _Lookup:
    """A question to the name server that is under way, in a thread of its own."""

    def __init__(self, host: str) -> None:
        self.host = host
        self.addresses: list[str] = []
        self.failure: Exception | None = None
        self.done = threading.Event()

    def run(self) -> None:
        try:
            found = socket.getaddrinfo(self.host, None, 0, socket.SOCK_STREAM)
            found.sort(key=lambda entry: entry[0] != socket.AF_INET)
            self.addresses = list(dict.fromkeys(str(entry[4][0]) for entry in found))
        except (OSError, UnicodeError) as error:  # UnicodeError: a label longer than 63 characters
            self.failure = error
        finally:
            with _lookups_lock:
                del _lookups[self.host]
            self.done.set()


# Lookups under way, so that many links retrying one unknown name share one thread. It may hang for half a
# minute, and nothing can end it earlier.
_lookups: dict[str, _Lookup] = {}
_lookups_lock = threading.Lock()


def _look_up(host: str, deadline: Deadline) -> list[str]:
    with _lookups_lock:
        lookup = _lookups.get(host)
        if lookup is None:
            lookup = _Lookup(host)
            threading.Thread(target=lookup.run, name=f"rosproto:resolve {host}", daemon=True).start()
            _lookups[host] = lookup
    if not lookup.done.wait(deadline.remaining()):
        raise deadline.error(say("look up host name {host!r}", host=host))
    if lookup.addresses:
        return list(lookup.addresses)
    raise ConnectionLost(
        say(
            "host name {host!r} cannot be resolved ({error}); add it to the hosts file or the name "
            "server, or let the other side announce a numeric address (ROS_IP or ROS_HOSTNAME there)",
            host=host,
            error=lookup.failure,
        ),
        peer=host,
    ) from lookup.failure


def local_address_towards(host: str, port: int, timeout: float | None = 5.0) -> str:
    """Our own address on the route to a peer: what the peer can connect back to.

    A UDP socket is connected, which picks a route; no packet is sent. Better than the host name, the
    first interface or a public address, which rospy and roscpp take and which fail with VPNs and docker.

    Raises:
        ConnectionLost: The name is unknown or there is no route.
        RosTimeout: The name server did not answer.
    """
    problem: RosError | None = None
    cause: OSError | None = None
    for address in resolve(host, Deadline(timeout)):
        family = _family(address) or socket.AF_INET
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


def host_from_environment(
    environment: Mapping[str, str], specials: Mapping[str, str] | None = None
) -> str | None:
    """The host the user says this computer has: rosgraph.network's order, up to where it starts guessing.

    `__hostname` and `__ip` (command line), then ROS_HOSTNAME, then ROS_IP; empty ones do not count. None:
    nobody said, use `local_address_towards`.

    Raises:
        ValueError: The value is a URI or has a port, which a host must not have.
    """
    sources = [(specials or {}, "__hostname"), (specials or {}, "__ip")]
    sources += [(environment, "ROS_HOSTNAME"), (environment, "ROS_IP")]
    for mapping, name in sources:
        host = mapping.get(name, "").strip()
        if host:
            if "/" in host or (":" in host and _family(host.strip("[]")) is None):
                raise ValueError(
                    say(
                        "{option}={value!r}: must be a host name or address, without scheme and port",
                        option=name,
                        value=host,
                    )
                )
            return host.strip("[]")
    return None
