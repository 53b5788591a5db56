"""Addresses of this computer, as ROS announces them, and the connection header of TCPROS."""

import os
import socket
import sys
from functools import cache
from urllib.parse import urlparse

from rosproto.errors import ProtocolError, RosError
from rosproto.protocol.handshake import decode_header, encode_header
from rosproto.transport.network_interfaces import interface_addresses
from rosproto.transport.own_address import local_address_towards
from rosproto.transport.uri import is_loopback

from .rosenv import ROS_HOSTNAME, ROS_IP, ROS_IPV6, get_master_uri

MAX_HEADER_BYTES = 1 << 24  # of a header; real ones have some hundred


def parse_http_host_and_port(url):
    """Host and port of a URL.

    Raises:
        ValueError: It is not a URL with a host.
    """
    if not url:
        raise ValueError("not a valid URL")
    parts = urlparse(url)
    host, port = parts.hostname, parts.port
    if not parts.scheme or not host:
        raise ValueError("not a valid URL")
    return host, port or 80


# -- addresses ----------------------------------------------------------------------------------------------


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
    """The address under which others reach this computer.

    The one on the route to the master; with a local master, that of the first interface.
    """
    override = get_address_override()
    if override:
        return override
    try:
        routed = local_address_towards(*parse_http_host_and_port(get_master_uri()), timeout=1.0)
        if not is_loopback(routed):
            return routed
    except (RosError, OSError, ValueError):
        pass  # there is no way to the master
    found = get_local_addresses()
    if len(found) == 1:
        return found[0]
    return next((one for one in found if not is_loopback(one)), "::1" if use_ipv6() else "127.0.0.1")


get_host_name = get_local_address


def create_local_xmlrpc_uri(port):
    """http://host:port/ of this computer."""
    return "http://%s:%s/" % (get_local_address(), port)


def use_ipv6():
    """True when ROS_IPV6 is on."""
    return os.environ.get(ROS_IPV6) == "on"


def is_local_address(hostname):
    """True for a name or address of this computer."""
    try:
        infos = socket.getaddrinfo(hostname, 0, 0 if use_ipv6() else socket.AF_INET, 0, socket.SOL_TCP)
    except (OSError, UnicodeError):
        return False
    found = {info[4][0] for info in infos}
    return any(is_loopback(one) for one in found) or not found.isdisjoint(get_local_addresses())


def get_local_addresses():
    """Addresses of this computer's interfaces, whatever ROS_IP says; looked up once."""
    return list(_addresses((socket.AF_INET6, socket.AF_INET) if use_ipv6() else (socket.AF_INET,)))


@cache
def _addresses(families):
    return [one for family in families for one in interface_addresses(family)] or ["127.0.0.1"]


def get_bind_address(address=None):
    """The address to listen on: the loopback one, when that is what ROS_IP or ROS_HOSTNAME asks for."""
    if address is None:
        address = get_address_override()
    if address and (address == "localhost" or is_loopback(address)):
        if use_ipv6():
            return "::1"
        return address if address.startswith("127.") else "127.0.0.1"
    return "::" if use_ipv6() else "0.0.0.0"


# -- the connection header (wiki.ros.org/ROS/TCPROS) --------------------------------------------------------


class ROSHandshakeException(Exception):
    """These bytes are not a connection header."""


def encode_ros_handshake_header(header):
    """A header's bytes with its own length in front; keys and values are str or bytes."""
    try:
        return encode_header({_text(key): _text(value) for key, value in header.items()})
    except ProtocolError as error:
        raise ROSHandshakeException(str(error)) from None


def _text(value):
    return value.decode("utf-8", "surrogateescape") if isinstance(value, bytes) else value


def decode_ros_handshake_header(header_str):
    """The fields of a header with its length in front; bytes after it are ignored.

    Raises:
        ROSHandshakeException: It is not one, or is incomplete.
    """
    size = int.from_bytes(header_str[:4], "little")
    if len(header_str) < 4 + size or len(header_str) < 4:
        raise ROSHandshakeException(
            "Incomplete header. Expected %s bytes but only have %s" % (4 + size, len(header_str))
        )
    try:
        return decode_header(header_str[4 : 4 + size])
    except ProtocolError as error:
        raise ROSHandshakeException(str(error)) from None


def read_ros_handshake_header(sock, b, buff_size):
    """Read a header from a socket; bytes received after it stay in the buffer `b` (BytesIO).

    The socket's own time-out is the limit of each read.

    Raises:
        ROSHandshakeException: It is not one, or the other side closed before it was complete.
    """
    while True:
        data = b.getvalue()[: b.tell()]
        size = int.from_bytes(data[:4], "little")
        if len(data) >= 4 and size > MAX_HEADER_BYTES:
            raise ROSHandshakeException(
                "%s bytes cannot be the length of a header; the stream is out of sync" % size
            )
        if len(data) >= 4 and len(data) - 4 >= size:
            break
        received = sock.recv(buff_size)
        if not received:
            raise ROSHandshakeException(
                "connection from sender terminated before handshake header received. %s bytes were received."
                " Please check sender for additional details." % b.tell()
            )
        b.write(received)
    b.seek(0)
    b.truncate(0)
    b.write(data[4 + size :])
    return decode_ros_handshake_header(data)


def write_ros_handshake_header(sock, header):
    """Send a header; returns the number of bytes."""
    data = encode_ros_handshake_header(header)
    sock.sendall(data)
    return len(data)
