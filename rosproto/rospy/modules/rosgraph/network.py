"""Addresses of this computer, as ROS announces them."""

import os
import sys

from .rosenv import ROS_HOSTNAME, ROS_IP, ROS_IPV6, get_master_uri


def parse_http_host_and_port(url):
    """Host and port of a URL.

    Raises:
        ValueError: It is none.
    """
    from urllib.parse import urlparse

    if not url:
        raise ValueError("not a valid URL")
    parts = urlparse(url)
    host, port = parts.hostname, parts.port
    if not host:
        raise ValueError("not a valid URL")
    return host, port or 80


def get_address_override():
    """`__hostname:=` or `__ip:=` of the command line, else ROS_HOSTNAME, else ROS_IP, else None."""
    for word in sys.argv:
        if word.startswith(("__hostname:=", "__ip:=")):
            _, _, value = word.partition(":=")
            if not value or ":=" in value:
                raise ValueError("invalid ROS command-line remapping argument '%s'" % word)
            return value
    return os.environ.get(ROS_HOSTNAME) or os.environ.get(ROS_IP) or None


def get_local_address():
    """The address under which others reach this computer: the one that routes to the master."""
    override = get_address_override()
    if override:
        return override
    from rosproto.errors import RosError
    from rosproto.transport.address import local_address_towards

    try:
        return local_address_towards(*parse_http_host_and_port(get_master_uri()), timeout=1.0)
    except (RosError, OSError, ValueError):
        return "127.0.0.1"


get_host_name = get_local_address


def create_local_xmlrpc_uri(port):
    """http://host:port/ of this computer."""
    return "http://%s:%s/" % (get_local_address(), port)


def use_ipv6():
    """True when ROS_IPV6 is on."""
    return os.environ.get(ROS_IPV6) == "on"


def is_local_address(hostname):
    """True for a name of this computer."""
    import socket

    return hostname in ("localhost", "127.0.0.1", "::1", socket.gethostname(), get_local_address())


def get_local_addresses():
    """Addresses of this computer."""
    import socket

    try:
        infos = socket.getaddrinfo(socket.gethostname(), None, socket.AF_INET)
    except OSError:
        infos = []
    found = [info[4][0] for info in infos]
    return list(dict.fromkeys([get_local_address(), *found, "127.0.0.1"]))


def get_bind_address(address=None):
    """Where servers listen: nowhere else, when only this computer is meant."""
    address = address or get_address_override()
    return "127.0.0.1" if address and address.startswith("127.") else "0.0.0.0"
