"""Sockets, deadlines, servers and clients: all I/O and all waiting below the node."""

from __future__ import annotations

from rosproto.transport.backoff import Backoff
from rosproto.transport.deadline import Deadline, next_item
from rosproto.transport.http_client import HttpClient
from rosproto.transport.listener import AT_ONCE, Listener
from rosproto.transport.os_errors import allow_open_files, max_connections
from rosproto.transport.own_address import local_address_towards
from rosproto.transport.robot_host_names import HostNames, hosts_advice, parse_host_names
from rosproto.transport.tcp import connect, interrupt, read_header, reuse_address, write_header
from rosproto.transport.tcp_server import TcpServer
from rosproto.transport.uri import MASTER_PORT, is_loopback, make_uri, master_uri_of, parse_uri
from rosproto.transport.xmlrpc_client import XmlRpcClient, unpack
from rosproto.transport.xmlrpc_server import Peer, XmlRpcServer

__all__ = [
    "AT_ONCE",
    "MASTER_PORT",
    "Backoff",
    "Deadline",
    "HostNames",
    "HttpClient",
    "Listener",
    "Peer",
    "TcpServer",
    "XmlRpcClient",
    "XmlRpcServer",
    "allow_open_files",
    "connect",
    "hosts_advice",
    "interrupt",
    "is_loopback",
    "local_address_towards",
    "make_uri",
    "master_uri_of",
    "max_connections",
    "next_item",
    "parse_host_names",
    "parse_uri",
    "read_header",
    "reuse_address",
    "unpack",
    "write_header",
]
