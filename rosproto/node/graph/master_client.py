"""Typed calls of the Master API and the Parameter Server API, for nodes and tools.

Source: wiki.ros.org/ROS/Master_API, wiki.ros.org/ROS/Parameter%20Server%20API.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Protocol

from rosproto.deprecation import former_attribute
from rosproto.errors import ConnectionLost, MasterError, RemoteProtocolError, RosError, RosTimeout
from rosproto.node.graph import api_client
from rosproto.node.graph.api_client import ApiClient
from rosproto.protocol.wire_limits import Limits
from rosproto.transport import HostNames, unpack
from rosproto.transport.xmlrpc_client import LastReply


class SystemState(NamedTuple):
    """The whole graph; each maps a topic or service to the nodes there.

    Attributes:
        publishers: topic -> node names.
        subscribers: topic -> node names.
        services: service -> node names (one).
    """

    publishers: dict[str, list[str]]
    subscribers: dict[str, list[str]]
    services: dict[str, list[str]]

    @property
    def nodes(self) -> list[str]:
        """Every node that is registered for something, sorted."""
        return sorted({name for table in self for names in table.values() for name in names})


class LastGraph(LastReply):
    """The graph that was read before: a large one takes long to decode, and seldom changes."""

    def __init__(self) -> None:
        super().__init__()
        self.state: SystemState | None = None
        self.state_of: object = None


class MasterClient(ApiClient):
    """Calls one master in the name of one node (or tool).

    Thread-safe. Names are sent as given: resolve them before (the master resolves relative ones in the
    caller's namespace). Every method takes `timeout` in seconds for the whole call; None takes the client's.

    All methods raise `MasterError` when the master refuses (`code` -1: wrong arguments, or not found; 0: the
    master failed), `ConnectionLost` and `RosTimeout` when it cannot be reached, and `RemoteProtocolError`
    when its answer is malformed.

    Args:
        uri: The master's XML-RPC URI.
        caller_id: Our node name, or anything a human can recognise.
        timeout: Seconds per call.
        limits: Bounds for the answers.

    Attributes:
        uri: The master's URI in canonical form.
        caller_id: As given.
    """

    _one_by_one = False  # True once the master is known to lack system.multicall

    # -- registration ------------------------------------------------------------------------------------

    def register_publisher(
        self, topic: str, type_name: str, caller_api: str, *, timeout: float | None = None
    ) -> list[str]:
        """Announce that our node (slave API at `caller_api`) publishes a topic; URIs of its subscribers."""
        return self._typed(
            api_client.as_str_list, "registerPublisher", topic, type_name, caller_api, timeout=timeout
        )

    def unregister_publisher(self, topic: str, caller_api: str, *, timeout: float | None = None) -> int:
        """Unregister; 1 if it was registered, else 0."""
        return self._typed(api_client.as_int, "unregisterPublisher", topic, caller_api, timeout=timeout)

    def register_subscriber(
        self, topic: str, type_name: str, caller_api: str, *, timeout: float | None = None
    ) -> list[str]:
        """Announce that our node subscribes to a topic ("*" for any type); URIs of its publishers."""
        return self._typed(
            api_client.as_str_list, "registerSubscriber", topic, type_name, caller_api, timeout=timeout
        )

    def unregister_subscriber(self, topic: str, caller_api: str, *, timeout: float | None = None) -> int:
        """Unregister; 1 if it was registered, else 0."""
        return self._typed(api_client.as_int, "unregisterSubscriber", topic, caller_api, timeout=timeout)

    def register_service(
        self, service: str, service_api: str, caller_api: str, *, timeout: float | None = None
    ) -> None:
        """Announce that our node provides a service at `service_api` (rosrpc://host:port)."""
        self.call("registerService", service, service_api, caller_api, timeout=timeout)

    def unregister_service(self, service: str, service_api: str, *, timeout: float | None = None) -> int:
        """Unregister; 0 if `service_api` is not the current provider."""
        return self._typed(api_client.as_int, "unregisterService", service, service_api, timeout=timeout)

    # -- the graph ---------------------------------------------------------------------------------------

    def lookup_node(self, node: str, *, timeout: float | None = None) -> str:
        """XML-RPC URI of a node; MasterError with code -1 when unknown."""
        return self._typed(api_client.as_str, "lookupNode", node, timeout=timeout)

    def lookup_service(self, service: str, *, timeout: float | None = None) -> str:
        """rosrpc URI of a service; MasterError with code -1 when nobody provides it."""
        return self._typed(api_client.as_str, "lookupService", service, timeout=timeout)

    def get_published_topics(self, subgraph: str = "", *, timeout: float | None = None) -> dict[str, str]:
        """topic -> type of everything published below a namespace ("" for all)."""
        pairs = self._typed(api_client.as_pairs, "getPublishedTopics", subgraph, timeout=timeout)
        return dict(pairs)

    def get_topic_types(self, *, timeout: float | None = None) -> dict[str, str]:
        """topic -> type of every topic the master knows, published or not; "*" for unknown."""
        return dict(self._typed(api_client.as_pairs, "getTopicTypes", timeout=timeout))

    def get_system_state(self, *, timeout: float | None = None, last: LastGraph | None = None) -> SystemState:
        """The publishers, subscribers and services of the graph.

        With `last`, the state is the same object as before while the graph is the same.
        """
        if last is None:
            return self._typed(_as_state, "getSystemState", timeout=timeout)
        value = self.call("getSystemState", timeout=timeout, last=last)
        if last.state is None or last.state_of is not value:
            last.state = api_client.checked("getSystemState", self.uri, value, _as_state)
            last.state_of = value
        return last.state

    def get_uri(self, *, timeout: float | None = None) -> str:
        """The URI that the master has for itself."""
        return self._typed(api_client.as_str, "getUri", timeout=timeout)

    def get_pid(self, *, timeout: float | None = None) -> int:
        """Process id of the master, on its computer."""
        return self._typed(api_client.as_int, "getPid", timeout=timeout)

    def shutdown(self, reason: str = "", *, timeout: float | None = None) -> None:
        """Ask the master to end; every node of the graph loses it."""
        self.call("shutdown", reason, timeout=timeout)

    # -- parameters --------------------------------------------------------------------------------------

    def get_param(self, key: str, *, timeout: float | None = None) -> object:
        """Value of a parameter, a dict for a namespace; MasterError with code -1 when not set."""
        return self.call("getParam", key, timeout=timeout)

    def set_param(self, key: str, value: object, *, timeout: float | None = None) -> None:
        """Set a parameter; a dict replaces the namespace."""
        self.call("setParam", key, value, timeout=timeout)

    def delete_param(self, key: str, *, timeout: float | None = None) -> None:
        """Delete a parameter or namespace; MasterError with code -1 when not set."""
        self.call("deleteParam", key, timeout=timeout)

    def has_param(self, key: str, *, timeout: float | None = None) -> bool:
        """Whether a parameter or namespace is set."""
        return self._typed(api_client.as_bool, "hasParam", key, timeout=timeout)

    def search_param(self, key: str, *, timeout: float | None = None) -> str:
        """Key found upwards from our name; MasterError with code -1 when there is none."""
        return self._typed(api_client.as_str, "searchParam", key, timeout=timeout)

    def get_param_names(self, *, timeout: float | None = None) -> list[str]:
        """Keys of all parameters."""
        return self._typed(api_client.as_str_list, "getParamNames", timeout=timeout)

    def subscribe_param(self, key: str, caller_api: str, *, timeout: float | None = None) -> object:
        """Value now (`{}` when not set), and paramUpdate calls to `caller_api` from now on."""
        return self.call("subscribeParam", caller_api, key, timeout=timeout)

    def unsubscribe_param(self, key: str, caller_api: str, *, timeout: float | None = None) -> int:
        """End the paramUpdate calls; 1 if there were any, else 0."""
        return self._typed(api_client.as_int, "unsubscribeParam", caller_api, key, timeout=timeout)

    # -- many calls at once ------------------------------------------------------------------------------

    def multicall(
        self, calls: Sequence[tuple[str, tuple[object, ...]]], *, timeout: float | None = None
    ) -> list[object]:
        """Several methods in one request (system.multicall), our caller id added to each.

        Args:
            calls: (method, parameters without caller id).
            timeout: Seconds for all of them.

        Returns:
            For each call its value, or the MasterError it would have raised.
        """
        structs = [{"methodName": m, "params": [self.caller_id, *params]} for m, params in calls]
        answer = self._client.call("system.multicall", structs, timeout=timeout)
        if not isinstance(answer, list) or len(answer) != len(calls):
            raise RemoteProtocolError(f"system.multicall at {self.uri}: answered {answer!r:.80}")
        return [self._one(calls[i][0], item) for i, item in enumerate(answer)]

    def batch(
        self, calls: Sequence[tuple[str, tuple[object, ...]]], *, timeout: float | None = None
    ) -> list[object]:
        """As `multicall`; a single call, or those for a master without it, are requests of their own.

        Each of these has `timeout`. If the master does not know the method, later calls do not try it again.
        """
        if len(calls) > 1 and not self._one_by_one:
            try:
                return self.multicall(calls, timeout=timeout)
            except (ConnectionLost, RosTimeout):
                raise
            except MasterError:
                self._one_by_one = True
            except RosError:
                pass  # the answer is malformed, or too large
        return [self._alone(method, params, timeout) for method, params in calls]

    several = former_attribute("several", "batch")

    def _alone(self, method: str, params: tuple[object, ...], timeout: float | None) -> object:
        try:
            return self.call(method, *params, timeout=timeout)
        except MasterError as error:
            return error

    def _one(self, method: str, item: object) -> object:
        if isinstance(item, dict) and "faultCode" in item:
            code = api_client.int_or_none(item["faultCode"]) or -1
            return MasterError(method, code, str(item.get("faultString", "")), uri=self.uri)
        try:
            return unpack(method, item[0] if isinstance(item, list) and item else item, self.uri)
        except MasterError as error:
            return error


def _as_state(value: object) -> SystemState:
    tables = api_client.as_list(value)
    if len(tables) != 3:
        raise TypeError("[publishers, subscribers, services]")
    return SystemState(*(api_client.as_rows(table) for table in tables))


class CallerIdentity(Protocol):
    """What a call of another node needs: a `Node` or `Context`.

    Attributes:
        name: The node name, sent as caller id.
        limits: Bounds for the answers.
        hosts: Host names that this computer may not know.
        master: The client of the master.
    """

    @property
    def name(self) -> str: ...

    @property
    def limits(self) -> Limits: ...

    @property
    def hosts(self) -> HostNames: ...

    @property
    def master(self) -> MasterClient: ...
