"""Send notifications to one node by the calls of its slave API (`notifier.py` decides when)."""

from __future__ import annotations

from collections.abc import Callable

from rosproto.errors import ConnectionLost, RosError, RosTimeout
from rosproto.logs import PeerLog, get_logger
from rosproto.protocol.wire_limits import Limits
from rosproto.transport import Deadline, XmlRpcClient

from .identity import CALLER_ID, Verdict, identify
from .notifications import Notification, ParamUpdate, PublisherUpdate, Shutdown
from .notifier import DeliveryOutcome

_log = get_logger("rosproto.master")


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
        """Ask the previous holder of a name to end, if it is really that node (see `identity.py`)."""
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
