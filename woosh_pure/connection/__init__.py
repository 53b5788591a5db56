"""The connection to one chassis: its address, our node, its publishers and its clients."""

from __future__ import annotations

from woosh_pure.connection.arguments import master_uri_of
from woosh_pure.connection.clients import Clients
from woosh_pure.connection.connection import Connection

__all__ = ["Clients", "Connection", "master_uri_of"]
