"""Send notifications to one node by the calls of its slave API (`notifier.py` decides when).

When a name is registered from a new URI, the previous holder is shut down (wiki.ros.org/ROS/Master_API). But
ports are reused: the process there now may be an unrelated node with a dead node's port (ros_comm#2241,
#2018). rosmaster shuts it down all the same. Here the process is identified first:

1. Another name is registered with that URI, so it is another node. (The master knows; no call.)
2. `getName` answers (rospy, this library): the name decides.
3. roscpp has no such call. But every roscpp and rospy node publishes /rosout, and a publisher sends its name
   as `callerid` on a connection: connect to one of its publications as a raw subscriber, read the reply's
   header, disconnect. The name decides.
4. None of its publications can be reached: it must still publish and subscribe everything that the old node
   was registered for, and at least one topic besides /rosout and /clock, which all nodes share.
5. Otherwise the process is unknown, and nothing is sent. Users notice two nodes of one name; they could not
   explain the end of an unrelated node.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from contextlib import closing
from enum import Enum

from rosproto.errors import ConnectionLost, MasterError, RemoteProtocolError, RosError, RosTimeout
from rosproto.logs import PeerLog, get_logger
from rosproto.master.notifications import Notification, ParamUpdate, PublisherUpdate, Shutdown
from rosproto.master.notifier import DeliveryOutcome
from rosproto.protocol.handshake import subscriber_header
from rosproto.protocol.wire_limits import Limits
from rosproto.transport import Deadline, XmlRpcClient, connect, read_header, unpack, write_header

_log = get_logger("rosproto.master")

CALLER_ID = "/master"
COMMON_TOPICS = frozenset({"/rosout", "/clock"})
MAX_ASKED = 3  # publications asked for the callerid


class NodeSender:
    """Calls one node (a `Sender` of the notifier).

    The node's reply is ignored: roscpp and rospy disagree on the status of an unexpected update. In
    particular, -1 from paramUpdate does not end the subscription. rosmaster intends that (and, by an error in
    its reverse_lookup, never does it), but rospy replies -1 for every key below a subscribed namespace, and
    for an update that overtakes the reply of its own subscribeParam.

    Args:
        uri: The node's XML-RPC URI.
        names_at: Names registered with a URI at this moment.
        timeout: Seconds for one call; for identifying a node, all calls together.
        limits: Limits of the node's replies.
        peer_log: The master's log of what nodes do.
    """

    def __init__(
        self,
        uri: str,
        names_at: Callable[[str], list[str]],
        *,
        timeout: float,
        limits: Limits,
        peer_log: PeerLog | None = None,
    ) -> None:
        self.uri = uri
        self._names_at = names_at
        self._timeout = timeout
        self._limits = limits
        self._peer_log = peer_log or PeerLog("rosproto.master")
        try:
            self._client: XmlRpcClient | None = XmlRpcClient(uri, limits=limits, timeout=timeout)
        except ValueError:  # registered with an invalid URI
            self._client = None

    def send(self, note: Notification) -> DeliveryOutcome:
        """Make one call; return its outcome."""
        if self._client is None:
            return DeliveryOutcome.GONE
        if not isinstance(note, Shutdown) and not self._names_at(self.uri):
            return DeliveryOutcome.GONE  # all its names are unregistered; another process may listen there
        try:
            self._make(self._client, note)
        except RosTimeout as error:
            _log.debug("! %s to %s: %s", note.key, self.uri, error)
            return DeliveryOutcome.SILENT
        except ConnectionLost as error:
            _log.debug("! %s to %s: %s", note.key, self.uri, error)
            return DeliveryOutcome.GONE if _is_refused(error) else DeliveryOutcome.SILENT
        except RosError as error:  # it replied, though with an invalid reply or a fault
            _log.debug("! %s to %s: %s", note.key, self.uri, error)
        return DeliveryOutcome.DONE

    def close(self) -> None:
        """Close the connection; a running call ends."""
        if self._client is not None:
            self._client.close()

    def _make(self, client: XmlRpcClient, note: Notification) -> None:
        if isinstance(note, PublisherUpdate):
            client.call("publisherUpdate", CALLER_ID, note.topic, list(note.publishers))
        elif isinstance(note, ParamUpdate):
            client.call("paramUpdate", CALLER_ID, note.parameter, note.value)
        else:
            self._shut_down(client, note)

    def _shut_down(self, client: XmlRpcClient, note: Shutdown) -> None:
        """Ask the previous holder of a name to end, if it is really that node (see above)."""
        others = [name for name in self._names_at(note.uri) if name != note.name]
        if others:
            text = "= %s moved; its old address %s is %s now, left alone"
            self._peer_log.info("", text, note.name, note.uri, others[0])
            return
        if note.name in self._names_at(note.uri):
            return  # the name is registered at this address again: the process there is the right one
        verdict = identify(client, note, self._limits, Deadline(self._timeout))
        if verdict is not Verdict.SAME:
            self._peer_log.warning(
                "",
                "! %s was registered twice; the process at its old address %s is %s, so it is not shut down",
                note.name,
                note.uri,
                "another node" if verdict is Verdict.OTHER else "not known",
            )
            return
        self._peer_log.info("", "> shutdown of %s at %s: %s", note.name, note.uri, note.reason)
        client.call("shutdown", CALLER_ID, note.reason)


def _is_refused(error: ConnectionLost) -> bool:
    """Whether the connection was refused, which is final. No route, unknown names and broken connections may
    recover.
    """
    cause: BaseException | None = error
    while cause is not None:
        if isinstance(cause, ConnectionRefusedError):
            return True
        cause = cause.__cause__
    return False


class Verdict(Enum):
    """Whether the process at a previous URI is the node that was registered there."""

    SAME = "same"
    OTHER = "other"
    UNKNOWN = "unknown"


def identify(client: XmlRpcClient, note: Shutdown, limits: Limits, deadline: Deadline) -> Verdict:
    """Find out whether the process at `client.uri` is the node of `note`.

    Raises:
        ConnectionLost: Nothing listens there.
        RosTimeout: It does not answer before the deadline.
    """
    reported = _name_by_call(client, deadline)
    if reported is not None:
        return compare_names(note.name, reported)
    publications = _topics(client, "getPublications", deadline)
    for topic in _topics_to_try(publications, note.publications):
        reported = _name_by_topic(client, topic, limits, deadline)
        if reported is not None:
            return compare_names(note.name, reported)
    subscriptions = _topics(client, "getSubscriptions", deadline)
    return compare_topics(note.publications | note.subscriptions, publications | subscriptions)


def compare_names(expected: str, reported: str) -> Verdict:
    """Compare the old node's name with the name that the process reported."""
    return Verdict.SAME if reported.strip("/") == expected.strip("/") else Verdict.OTHER


def compare_topics(registered: Collection[str], reported: Collection[str]) -> Verdict:
    """Compare the topics that a node was registered for with those that the process reports."""
    known, now = set(registered), set(reported)
    if not known <= now:
        return Verdict.OTHER
    return Verdict.SAME if known - COMMON_TOPICS else Verdict.UNKNOWN


def _name_by_call(client: XmlRpcClient, deadline: Deadline) -> str | None:
    try:
        value = unpack("getName", client.call("getName", CALLER_ID, timeout=deadline.remaining()))
    except (MasterError, RemoteProtocolError):
        return None  # roscpp: no such method
    return value if isinstance(value, str) and value else None


def _topics(client: XmlRpcClient, method: str, deadline: Deadline) -> frozenset[str]:
    try:
        rows = unpack(method, client.call(method, CALLER_ID, timeout=deadline.remaining()))
    except (MasterError, RemoteProtocolError):
        return frozenset()
    if not isinstance(rows, list):
        return frozenset()
    return frozenset(row[0] for row in rows if isinstance(row, list) and row and isinstance(row[0], str))


def _topics_to_try(publications: frozenset[str], registered: frozenset[str]) -> list[str]:
    """/rosout first, since connecting to it has no side effect on a robot; then the other publications."""
    order = sorted(publications, key=lambda topic: (topic != "/rosout", topic not in registered, topic))
    return order[:MAX_ASKED]


def _name_by_topic(client: XmlRpcClient, topic: str, limits: Limits, deadline: Deadline) -> str | None:
    """`callerid` of the publisher's connection header; None if none is received."""
    # One silent publication must not use up the time of the others.
    step = Deadline((deadline.remaining() or 0.0) / 2)
    try:
        where = unpack(
            "requestTopic",
            client.call("requestTopic", CALLER_ID, topic, [["TCPROS"]], timeout=step.remaining()),
        )
        if not isinstance(where, list) or len(where) < 3 or where[0] != "TCPROS":
            return None
        with closing(connect(str(where[1]), int(where[2]), step)) as sock:
            header = subscriber_header(topic=topic, type_name="*", md5sum="*", callerid=CALLER_ID)
            write_header(sock, header, step)
            return read_header(sock, limits, step).get("callerid")
    except (RosError, ValueError, TypeError):
        return None
