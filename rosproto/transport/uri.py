"""Parse, compare and format URIs, hosts and ports as text; no name is looked up."""

from __future__ import annotations

import re
import socket

from rosproto.sentence import say

MASTER_PORT = 11311
DEFAULT_MASTER_URI = f"http://localhost:{MASTER_PORT}/"
_MISTYPED_SCHEME = re.compile(r"(http|rosrpc)(//|:/|/)(?!/)", re.IGNORECASE)
_DOTS = "\u3002\uff0e\uff61"  # RFC 3490 treats these as dots, too


def master_uri_of(address: str) -> str:
    """The URI of a master as people name it: "robot", "robot:11311", "fe80::1", or a URI, which stays.

    A host without a port means port 11311; in a URI port 80, as in ROS (see `parse_uri`, which also refuses
    what is not an address: it is returned unchanged).
    """
    text = address.strip().removesuffix("/")
    if not text or "/" in text:
        return address
    host = f"[{text}]" if text.count(":") > 1 and not text.startswith("[") else text
    has_port = ":" in host.rpartition("]")[2]
    return f"http://{host}/" if has_port else f"http://{host}:{MASTER_PORT}/"


def parse_uri(uri: str) -> tuple[str, int]:
    """Host and port of an `http://` or `rosrpc://` URI; the host without brackets, in lower case.

    Trailing slash, path and scheme may be absent; "" is the default master. The default port is 80, as in
    rosgraph's parse_http_host_and_port; `master_uri_of` adds a master's.

    Raises:
        ValueError: There is no host, or the port is invalid.
    """
    if wrong := _MISTYPED_SCHEME.match(uri.strip()):
        text = "URI {uri!r}: {mark!r} behind {scheme} should be '://', as in http://10.0.0.7:11311/"
        raise ValueError(say(text, uri=uri, mark=wrong[2], scheme=wrong[1]))
    host, port = _split_authority(_authority(uri or DEFAULT_MASTER_URI), uri)
    if not host or any(character.isspace() or character in "@[]" for character in host):
        raise ValueError(say("URI {uri!r}: no host; expected something like http://10.0.0.7:11311/", uri=uri))
    plain_host(host)
    if not port:
        return host, 80
    if not (port.isascii() and port.isdigit()) or len(port) > 5 or int(port) > 65535:
        raise ValueError(
            say("URI {uri!r}: port {port!r} must be a number from 0 to 65535", uri=uri, port=port)
        )
    return host, int(port)


def plain_host(host: str) -> str:
    """Return the host if its digits and dots are ASCII.

    Resolvers read digits and dots of other scripts (from an input method) as ASCII, so that people and
    `is_loopback` would see another host than the system. Letters of other scripts are allowed in names.

    Raises:
        ValueError: It has other digits or dots.
    """
    if not host.isascii() and any(c in _DOTS or (c.isdigit() and not c.isascii()) for c in host):
        wrong = "host {host!r} has digits or dots that are not ASCII; expected something like 10.0.0.7"
        raise ValueError(say(wrong, host=host))
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
            say("URI {uri!r}: an IPv6 address must be in brackets, as in http://[::1]:11311/", uri=uri)
        )
    host, _, port = authority.partition(":")
    return host, port


def uri_path(uri: str) -> str:
    """The path of a URI; "/" if there is none (every ROS server answers on it)."""
    rest = _after_scheme(uri)
    slash = rest.find("/")
    return rest[slash:] if slash >= 0 else "/"


def format_address(host: str, port: int) -> str:
    """ "host:port", with an IPv6 host in brackets."""
    return f"[{host}]:{port}" if ":" in host else f"{host}:{port}"


def make_uri(host: str, port: int, scheme: str = "http") -> str:
    """ "http://host:port/", with the trailing slash that rospy and roscpp register."""
    return f"{scheme}://{format_address(host, port)}/"


def same_uri(one: str, other: str) -> bool:
    """Whether two URIs mean the same server: host (in any case) and port, as roscpp compares them."""
    if one == other:
        return True
    try:
        return parse_uri(one) == parse_uri(other)
    except ValueError:
        return False


def is_loopback(host: str) -> bool:
    """Whether the host is `localhost`, 127.* or ::1. Only the text counts; no name is looked up."""
    host = host.lower().strip("[]").removeprefix("::ffff:")
    return host in ("localhost", "::1") or (host.startswith("127.") and _family(host) == socket.AF_INET)


def is_numeric(host: str) -> bool:
    """Whether the host is an address, so that no name has to be looked up."""
    return _family(host.strip("[]")) is not None


def _family(host: str) -> socket.AddressFamily | None:
    """The family of a numeric address, None for a name. IPv6 may have a scope id, as fe80::1%eth0."""
    for family, text in ((socket.AF_INET, host), (socket.AF_INET6, host.partition("%")[0])):
        try:
            socket.inet_pton(family, text)
        except (OSError, ValueError):
            continue
        return family
    return None
