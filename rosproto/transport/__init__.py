"""Sockets, deadlines, servers and clients: all I/O and waiting of the libraries below the node."""

from __future__ import annotations

from rosproto.transport.address import (
    format_address,
    host_from_environment,
    is_loopback,
    local_address_towards,
    make_uri,
    parse_uri,
    resolve,
    same_uri,
)
from rosproto.transport.backoff import Backoff
from rosproto.transport.clock import SYSTEM, Clock
from rosproto.transport.connecting import connect
from rosproto.transport.deadline import Deadline
from rosproto.transport.host_names import HostNames, parse_host_names
from rosproto.transport.tcp import interrupt, listen, tune
from rosproto.transport.tcp_server import TcpServer
from rosproto.transport.tcpros_io import (
    ClosedBeforeHeader,
    read_header,
    write_all,
    write_header,
)
from rosproto.transport.xmlrpc_client import XmlRpcClient, unpack
from rosproto.transport.xmlrpc_server import Peer, XmlRpcServer

__all__ = [
    "SYSTEM",
    "Backoff",
    "Clock",
    "ClosedBeforeHeader",
    "Deadline",
    "HostNames",
    "Peer",
    "TcpServer",
    "XmlRpcClient",
    "XmlRpcServer",
    "connect",
    "format_address",
    "host_from_environment",
    "interrupt",
    "is_loopback",
    "listen",
    "local_address_towards",
    "make_uri",
    "parse_host_names",
    "parse_uri",
    "read_header",
    "resolve",
    "same_uri",
    "tune",
    "unpack",
    "write_all",
    "write_header",
]
