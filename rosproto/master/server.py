"""`Master`, a ROS master over HTTP: the API, its notifier and an XML-RPC server."""

from __future__ import annotations

import os
import threading

from rosproto.errors import RosError
from rosproto.logs import PeerLog, get_logger
from rosproto.master.api import MasterApi, UnknownMethod
from rosproto.master.notifier import Notifier
from rosproto.master.parameters import ParameterTree
from rosproto.master.registry import SUCCESS, Registry
from rosproto.master.slave_calls import NodeSender
from rosproto.protocol.wire_limits import Limits
from rosproto.protocol.xmlrpc import Fault
from rosproto.transport import Peer, XmlRpcServer, is_loopback, local_address_towards, make_uri
from rosproto.transport.deadline import wait_event
from rosproto.transport.forking import is_forked_child
from rosproto.transport.tcp_server import Allow

_log = get_logger("rosproto.master")

ROS_DISTRO = "noetic\n"  # with the newline of roscore's `rosversion -d`
ROS_VERSION = "1.16.0\n"  # of the ros_comm that this follows
_WILDCARDS = ("0.0.0.0", "::", "")
# Documentation addresses (RFC 5737, RFC 3849), used only to find the interface of the default route.
_ELSEWHERE = {"0.0.0.0": "192.0.2.1", "": "192.0.2.1", "::": "2001:db8::1"}
_REPLY_DEPTH = 4  # levels around a parameter's value in the reply of a getParam inside a multicall


class Master:
    """A ROS master: name service of a graph, and its parameter server.

    Runs in its own threads from construction until `close()`; usable in a `with`. A process may have any
    number of masters. `/run_id`, `/rosdistro` and `/rosversion` are set as roscore does (roslaunch refuses a
    master without `/run_id`).

    Args:
        host: Address to listen on: only this computer by default, "0.0.0.0" for every interface.
        port: Port; 0 takes a free one, 11311 is the default of nodes.
        advertise: Host in `uri` if others should use another one than `host`. For a wildcard the address of
            the default route is used, and `getUri` replies to each caller with the address that it called.
        limits: Limits of sizes, times and connections.
        allow: Who may connect: addresses, or a function of the address; None for everybody.
        allow_shutdown: Whether the API's `shutdown` is obeyed; None: from this computer only.
        call_timeout: Seconds for one notification to a node.

    Raises:
        ConnectionLost: The port is taken, or the address is not this computer's; the text names it.

    Attributes:
        host: As given.
        port: The actual port.
        uri: XML-RPC URI, for ROS_MASTER_URI.
    """

    def __init__(
        self,
        host: str = "127.0.0.1",
        port: int = 0,
        *,
        advertise: str | None = None,
        limits: Limits | None = None,
        allow: Allow = None,
        allow_shutdown: bool | None = None,
        call_timeout: float = 5.0,
    ) -> None:
        limits = limits or Limits()
        self._allow_shutdown = allow_shutdown
        self._ended = threading.Event()
        self._process = os.getpid()
        self._closing = threading.Lock()
        registry = Registry()
        peer_log = PeerLog("rosproto.master")
        self._notifier = Notifier(
            lambda uri: NodeSender(
                uri, self._names_at, timeout=call_timeout, limits=limits, peer_log=peer_log
            )
        )
        self._api = MasterApi(
            self._notifier.post,
            stop=self._stop,
            may_stop=self._may_stop,
            registry=registry,
            parameters=ParameterTree(
                registry.param_subscribers.providers, max_depth=limits.xml_depth - _REPLY_DEPTH
            ),
        )
        self._set_core_parameters()
        shown = advertise or _reachable(host)
        self._follows_caller = not advertise and host in _WILDCARDS
        self._api.uri = make_uri(shown, port)  # already correct if the port is given; see below
        self._server = XmlRpcServer(
            host or "0.0.0.0",
            port,
            self.answer,
            limits=limits,
            allow=allow,
            name="master",
            advertise=shown,
        )
        self.host = host
        self.port = self._server.port
        self.uri = self._api.uri = self._server.uri
        _log.info("= master listens at %s", self.uri)

    def __enter__(self) -> Master:
        return self

    def __exit__(self, *exc: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<Master {self.uri}{' closed' if self.closed else ''}>"

    @property
    def closed(self) -> bool:
        """Whether it has ended, by `close()` or by a `shutdown` call."""
        return self._ended.is_set()

    def wait(self, timeout: float | None = None) -> bool:
        """Wait until the master has ended; False after `timeout` seconds."""
        return wait_event(self._ended, timeout)

    def flush(self, timeout: float = 5.0) -> bool:
        """Wait until every notification so far was delivered or given up; False after `timeout` seconds."""
        return self._notifier.wait_until_quiet(timeout)

    def stats(self) -> dict[str, int]:
        """Registrations, connections, and the notifier's counters."""
        with self._api.lock:
            registrations = len(self._api.registry)
        counts = {"registrations": registrations, "connections": self._server.connections}
        return {**counts, **self._notifier.stats()}

    def close(self, timeout: float = 5.0) -> None:
        """Stop connections and notifications. Idempotent, returns within about `timeout` seconds.

        Without effect in a fork of the process that opened it, where the master continues.
        """
        if is_forked_child(self._process):
            return
        with self._closing:
            self._server.close(timeout / 2)
            self._notifier.close(timeout / 2)
            self._ended.set()

    def answer(self, method: str, params: list[object], peer: Peer) -> object:
        """Answer one call as over the network; `LocalClient` calls this."""
        if method == "system.listMethods":
            return [*self._api.methods(), "system.listMethods", "system.multicall"]
        try:
            answer = self._api.dispatch(method, params, peer)
        except UnknownMethod as error:
            raise Fault(1, str(error)) from error
        if method == "getUri" and answer[0] == SUCCESS:
            answer[2] = self._uri_for(peer)
        return answer

    # -- inside ------------------------------------------------------------------------------------------

    def _uri_for(self, peer: Peer) -> str:
        """Our URI for one caller: with a wildcard, the address that the caller connected to."""
        local = peer.local_host if self._follows_caller else ""
        return make_uri(local, self.port) if local and "%" not in local else self.uri

    def _set_core_parameters(self) -> None:
        import uuid  # costs more to import than the rest of this module, and only masters need it

        for key, value in (
            ("/run_id", str(uuid.uuid4())),
            ("/rosdistro", ROS_DISTRO),
            ("/rosversion", ROS_VERSION),
        ):
            self._api.dispatch("setParam", ["/master", key, value])

    def _names_at(self, uri: str) -> list[str]:
        with self._api.lock:
            return self._api.registry.names_at(uri)

    def _may_stop(self, peer: str) -> bool:
        if self._allow_shutdown is not None:
            return self._allow_shutdown
        # A caller on this computer has a loopback address, or the address that it connects to.
        return isinstance(peer, Peer) and (is_loopback(peer.host) or peer.host == peer.local_host)

    def _stop(self, reason: str) -> None:
        """Obey `shutdown` from another thread, because the caller still waits for the reply."""
        _log.warning("= master ends: %s", reason)
        threading.Thread(target=self._stop_soon, name="rosproto:master-shutdown", daemon=True).start()

    def _stop_soon(self) -> None:
        self._ended.wait(0.1)  # time to send the reply, which is optional
        self.close()


def _reachable(host: str) -> str:
    """The host for our URI; a wildcard is replaced, since nobody can connect to it."""
    if host not in _WILDCARDS:
        return host
    try:
        return local_address_towards(_ELSEWHERE[host], 80)
    except RosError:  # no default route: the computer has no network
        return "::1" if host == "::" else "127.0.0.1"
