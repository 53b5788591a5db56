"""Typed calls of another node's slave API, for nodes and tools (wiki.ros.org/ROS/Slave_API)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from rosproto.node.graph import api_client
from rosproto.node.graph.api_client import ApiClient
from rosproto.protocol.wire_limits import Limits
from rosproto.transport import HostNames, XmlRpcClient, unpack


class BusConnection(NamedTuple):
    """One connection of a node, as getBusInfo reports it; peers differ in the fields they fill in.

    Attributes:
        connection_id: The node's number for it.
        destination: Name or URI of the other side.
        direction: "i" in, "o" out, "b" both.
        transport: "TCPROS", "UDPROS", "INTRAPROCESS".
        topic: Topic name.
        connected: Whether it is up.
        info: More information, such as addresses; "" if there is none.
    """

    connection_id: int
    destination: str
    direction: str
    transport: str
    topic: str
    connected: bool
    info: str


class NodeClient(ApiClient):
    """Calls one node's slave API.

    Thread-safe. Every method takes `timeout` in seconds; None takes the client's. Errors are those of
    `MasterClient`: MasterError when the node refuses, ConnectionLost, RosTimeout, RemoteProtocolError.

    Args:
        uri: The node's XML-RPC URI (`MasterClient.lookup_node`).
        caller_id: Our name.
        timeout: Seconds per call.
        limits: Bounds for the answers.
        hosts: Knows host names that the system does not (`Node.hosts`).
    """

    def __init__(
        self,
        uri: str,
        caller_id: str,
        *,
        timeout: float = 5.0,
        limits: Limits | None = None,
        client: XmlRpcClient | None = None,
        hosts: HostNames | None = None,
    ) -> None:
        super().__init__(uri, caller_id, timeout=timeout, limits=limits, client=client, hosts=hosts)

    def get_bus_stats(self, *, timeout: float | None = None) -> list[object]:
        """Statistics [publish, subscribe, service], unchanged; the rows differ between libraries."""
        seconds = self._timeout if timeout is None else timeout
        reply = self._client.call("getBusStats", self.caller_id, timeout=seconds)
        if isinstance(reply, list) and reply and isinstance(reply[0], list):
            return reply  # roscpp's XMLRPCManager gives the value alone, without code and text
        value = unpack("getBusStats", reply, self.uri)
        return api_client.checked("getBusStats", self.uri, value, api_client.as_list)

    def get_bus_info(self, *, timeout: float | None = None) -> list[BusConnection]:
        """The node's connections."""
        rows = self._typed(api_client.as_list, "getBusInfo", timeout=timeout)
        return [api_client.checked("getBusInfo", self.uri, row, _as_connection) for row in rows]

    def get_master_uri(self, *, timeout: float | None = None) -> str:
        """The master the node uses."""
        return self._typed(api_client.as_str, "getMasterUri", timeout=timeout)

    def shutdown(self, reason: str = "", *, timeout: float | None = None) -> None:
        """Ask the node to end; MasterError when it refuses."""
        self.call("shutdown", reason, timeout=timeout)

    def get_pid(self, *, timeout: float | None = None) -> int:
        """Process id of the node, on its computer."""
        return self._typed(api_client.as_int, "getPid", timeout=timeout)

    def get_name(self, *, timeout: float | None = None) -> str:
        """The node's name; rospy and this library answer, roscpp does not know the method (MasterError)."""
        return self._typed(api_client.as_str, "getName", timeout=timeout)

    def get_subscriptions(self, *, timeout: float | None = None) -> list[tuple[str, str]]:
        """(topic, type) of what the node subscribes to."""
        return self._typed(api_client.as_pairs, "getSubscriptions", timeout=timeout)

    def get_publications(self, *, timeout: float | None = None) -> list[tuple[str, str]]:
        """(topic, type) of what the node publishes."""
        return self._typed(api_client.as_pairs, "getPublications", timeout=timeout)

    def request_topic(
        self,
        topic: str,
        protocols: Sequence[Sequence[object]] = (("TCPROS",),),
        *,
        timeout: float | None = None,
    ) -> list[object]:
        """Ask where to connect for a topic: ["TCPROS", host, port], or [] when the node offers nothing.

        Args:
            topic: Resolved topic.
            protocols: The protocols we support, the preferred one first, each with its parameters.
        """
        wanted = [list(protocol) for protocol in protocols]
        return self._typed(api_client.as_list, "requestTopic", topic, wanted, timeout=timeout)

    def param_update(self, key: str, value: object, *, timeout: float | None = None) -> None:
        """Tell the node a parameter's new value (for masters)."""
        self.call("paramUpdate", key, value, timeout=timeout)

    def publisher_update(
        self, topic: str, publishers: Sequence[str], *, timeout: float | None = None
    ) -> None:
        """Tell the node all publishers of a topic (for masters)."""
        self.call("publisherUpdate", topic, list(publishers), timeout=timeout)


def _as_connection(row: object) -> BusConnection:
    """[id, destination, direction, transport, topic, connected, info]; the last two may be missing."""
    cells = api_client.as_list(row)
    if len(cells) < 5:
        raise TypeError("[id, destination, direction, transport, topic, connected, info]")
    connected = bool(cells[5]) if len(cells) > 5 else True
    words = [str(cell) for cell in cells[1:5]]
    return BusConnection(
        api_client.int_or_none(cells[0]) or 0,
        words[0],
        words[1],
        words[2],
        words[3],
        connected,
        str(cells[6]) if len(cells) > 6 else "",
    )
