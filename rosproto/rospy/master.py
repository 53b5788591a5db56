"""Calls to the master with the results of xmlrpc.client: raw triples, OSError without an answer."""

from __future__ import annotations

import os
import threading
from typing import NoReturn

from rosproto.errors import ConnectionLost, LocalProtocolError, MasterError, RosError, RosTimeout
from rosproto.node.options import host_names
from rosproto.transport.robot_host_names import HostNames
from rosproto.transport.xmlrpc_client import XmlRpcClient

TIMEOUT = 60.0  # seconds; rospy has no limit

_clients: dict[tuple[int, str], XmlRpcClient] = {}
_lock = threading.Lock()


def call(uri: str, method: str, *params: object) -> object:
    """Call a method of the master (or a node) and return the reply as it is.

    Raises:
        OSError: It cannot be reached; the operating system's own error, if there is one.
        TypeError, OverflowError: An argument cannot be sent.
        xmlrpc.client.Fault: It answered with a fault.
    """
    try:
        return _with_binaries(_client(uri).call(method, *params))
    except RosError as error:
        _refuse(error, params)


def _client(uri: str) -> XmlRpcClient:
    """One client per process and URI: a forked child must not share its parent's connections."""
    key = (os.getpid(), uri)
    with _lock:
        client = _clients.get(key)
        if client is None:
            client = _clients[key] = XmlRpcClient(uri, timeout=TIMEOUT, hosts=HostNames(host_names()))
        return client


def _refuse(error: RosError, params: tuple[object, ...]) -> NoReturn:
    if isinstance(error, MasterError):
        from xmlrpc.client import Fault

        raise Fault(error.code, error.text) from None
    if isinstance(error, LocalProtocolError):
        from xmlrpc.client import dumps

        try:
            dumps(params)  # type: ignore[arg-type]  # the error of xmlrpc.client for what cannot be sent
        except (TypeError, OverflowError) as refused:
            raise refused from None
        raise TypeError(str(error)) from None
    if isinstance(error, (ConnectionLost, RosTimeout)):
        cause: BaseException | None = error
        while cause is not None:
            if isinstance(cause, OSError) and cause.errno is not None:
                raise cause from None
            cause = cause.__cause__ or cause.__context__
    raise error


def _with_binaries(value: object) -> object:
    """The reply with bytes as `xmlrpc.client.Binary`."""
    if isinstance(value, list):
        return [_with_binaries(item) for item in value]
    if isinstance(value, dict):
        return {key: _with_binaries(item) for key, item in value.items()}
    if isinstance(value, bytes):
        from xmlrpc.client import Binary

        return Binary(value)
    return value
