"""The slave API of this node: answers calls of the master, other nodes and tools.

Every reply is `[code, statusMessage, value]` (-1 the caller's mistake, 0 failure, 1 success) in exactly the
shape the wiki gives; shapes below are checked by `rosnode info`, rqt_graph and test_slave_api.

Callers are not trusted: after a `publisherUpdate` or `paramUpdate` that did not come from the master's
address, the master is asked. A `shutdown` in the master's name is obeyed if the master confirms that the name
is no longer ours (ros_comm#2241: with re-used ports it reaches the wrong node).

Source: wiki.ros.org/ROS/Slave_API; rospy impl/masterslave.py where it is silent.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import TYPE_CHECKING

from rosproto.errors import MasterError, RosError
from rosproto.logs import PeerLog, get_logger
from rosproto.node.graph.master_client import MasterClient
from rosproto.protocol.udpros import UDPROS, DatagramRequest
from rosproto.protocol.xmlrpc import Fault

if TYPE_CHECKING:
    from rosproto.node.topics import TopicTable

_log = get_logger("rosproto.node")

Reply = list[object]


class _BadArgument(Exception):
    """An argument is invalid; the text goes to the caller with code -1."""


class SlaveApi:
    """Dispatch table of one node; the XML-RPC server calls `dispatch`.

    Attributes:
        methods: Method name -> (handler, number of arguments, value of a refusal). A handler takes the
            peer's address and the arguments, and returns the reply.
        on_parameter_update: Hook of the parameter cache: `(key, value, trusted) -> bool`, True when
            subscribed.
    """

    def __init__(
        self,
        *,
        name: str,
        master: MasterClient,
        topics: TopicTable,
        own_uri: Callable[[], str],
        tcpros_address: Callable[[], tuple[str, int]],
        is_master_address: Callable[[str], bool],
        shut_down: Callable[[str], None],
        allow_shutdown: bool = True,
    ) -> None:
        self._name = name
        self._master = master
        self._topics = topics
        self._own_uri = own_uri
        self._tcpros_address = tcpros_address
        self._is_master_address = is_master_address
        self._shut_down = shut_down
        self._allow_shutdown = allow_shutdown
        self._said = PeerLog("rosproto.node")
        self.on_parameter_update: Callable[[str, object, bool], bool] = lambda key, value, trusted: False
        self.methods: dict[str, tuple[Callable[..., Reply], int, object]] = {
            "getBusStats": (lambda *_: [1, "bus stats", topics.bus_stats()], 1, []),
            "getBusInfo": (lambda *_: [1, "bus info", topics.bus_info()], 1, []),
            "getMasterUri": (lambda *_: [1, master.uri, master.uri], 1, ""),
            "getName": (lambda *_: [1, "", name], 1, ""),
            "getUri": (lambda *_: [1, "", own_uri()], 1, ""),
            "getPid": (lambda *_: [1, "", os.getpid()], 1, -1),
            "getSubscriptions": (lambda *_: [1, "subscriptions", topics.subscriptions()], 1, []),
            "getPublications": (lambda *_: [1, "publications", topics.publications()], 1, []),
            "paramUpdate": (self._param_update, 3, 0),
            "publisherUpdate": (self._publisher_update, 3, 0),
            "requestTopic": (self._request_topic, 3, []),
            "shutdown": (self._shutdown, 2, 0),
        }

    def dispatch(self, method: str, params: list[object], peer: str) -> object:
        """Answer one call.

        Args:
            method: Name from the wire.
            params: Its arguments from the wire, of any type and number.
            peer: Address of the caller (`xmlrpc_server.Peer`, or a plain host).

        Raises:
            Fault: No such method.
        """
        entry = self.methods.get(method)
        if entry is None:
            raise Fault(-1, f"the slave API has no method {method[:100]!r}")
        handler, arity, refusal = entry
        if method == "shutdown" and len(params) == 1:
            params = [*params, ""]
        if len(params) != arity:
            return [-1, f"{method} takes {arity} arguments, {len(params)} were given", refusal]
        if not isinstance(params[0], str):
            return [-1, "caller_id must be a string", refusal]
        try:
            return handler(getattr(peer, "host", peer), *params)
        except _BadArgument as error:
            return [-1, str(error), refusal]

    # -- questions ------------------------------------------------------------------------------------------

    def _request_topic(self, peer: str, caller_id: str, topic: object, protocols: object) -> Reply:
        """Choose the first protocol of the list that we support; unknown ones are skipped."""
        if not isinstance(protocols, list) or not protocols:
            raise _BadArgument("parameter [protocols] must be a non-empty list")
        topic = _topic(topic)
        if not self._topics.is_published(topic):
            return [-1, f"Not a publisher of [{topic}]", []]
        refusal = "no supported protocol implementations"
        for protocol in protocols:
            name = protocol[0] if isinstance(protocol, list) and protocol else ""
            if name == "TCPROS":
                host, port = self._tcpros_address()
                return [1, f"ready on {host}:{port}", ["TCPROS", host, port]]
            if name == UDPROS:
                try:
                    answer = self._topics.request_datagrams(topic, DatagramRequest.parse(protocol))
                    return [1, f"datagrams of {topic}", answer]
                except RosError as error:
                    _log.debug("! %s: no datagrams for %s at %s: %s", topic, caller_id[:200], peer, error)
                    refusal = str(error)
        return [0, refusal, []]

    # -- news -----------------------------------------------------------------------------------------------

    def _publisher_update(self, peer: str, caller_id: str, topic: object, publishers: object) -> Reply:
        """Return 1 also for a topic that we no longer subscribe: it may be late (wire.md, fact 27)."""
        topic = _topic(topic)
        uris = _uris(publishers)
        if self._is_master_address(peer):
            self._topics.update_publishers(topic, uris)
        else:
            text = "publisherUpdate of %s came from %s, not from the master: asking it"
            self._said.info("", text, topic, peer)
            self._topics.verify_publishers(topic)
        return [1, "", 0]

    def _param_update(self, peer: str, caller_id: str, key: object, value: object) -> Reply:
        if not isinstance(key, str) or not key.startswith("/"):
            raise _BadArgument("parameter [parameter_key] must be a global name")
        if self.on_parameter_update(key, value, self._is_master_address(peer)):
            return [1, "", 0]
        return [-1, f"not subscribed to [{key}]", 0]

    def _shutdown(self, peer: str, caller_id: str, reason: object) -> Reply:
        reason = str(reason)[:1000]
        refusal = self._why_not(caller_id)
        if refusal:
            text = "shutdown by %s at %s (%s) refused: %s"
            self._said.warning("", text, caller_id[:200], peer, reason, refusal)
            return [0, f"shutdown refused: {refusal}", 0]
        self._shut_down(f"shutdown by {caller_id[:200]} at {peer}: {reason}")
        return [1, "shutdown", 0]

    def _why_not(self, caller_id: str) -> str:
        """Why a shutdown is refused; "" if it is obeyed."""
        if caller_id.rstrip("/") != "/master":
            return "" if self._allow_shutdown else f"{self._name} was opened with allow_shutdown=False"
        try:
            present = self._master.lookup_node(self._name)
        except MasterError:
            return ""  # the master no longer knows the name: it is not ours
        except RosError as error:
            return f"the master at {self._master.uri} did not confirm it: {error}"
        if present.rstrip("/") == self._own_uri().rstrip("/"):
            return f"the master at {self._master.uri} still has {self._name} at {present}"
        return ""


def _topic(value: object) -> str:
    if not isinstance(value, str) or not value.startswith("/") or len(value) > 4096:
        raise _BadArgument(f"parameter [topic] must be a global topic name, not {str(value)[:100]!r}")
    return value


def _uris(value: object) -> list[str]:
    if not isinstance(value, list) or not all(isinstance(uri, str) for uri in value):
        raise _BadArgument("parameter [publishers] must be a list of strings")
    for uri in value:
        if not uri.startswith(("http://", "rosrpc://")):
            raise _BadArgument(f"parameter [publishers] does not contain valid URLs [{uri[:100]}]")
    return value
