"""The node of a program, and the caller of services before there is a node."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from rosproto.errors import Md5sumMismatch
from rosproto.logs import PeerLog
from rosproto.node import Event, EventKind, MasterClient, Node
from rosproto.node.definitions.known_definitions import KnownDefinitions
from rosproto.node.options import host_names
from rosproto.protocol.wire_limits import Limits
from rosproto.transport.robot_host_names import HostNames
from rosproto.transport.uri import parse_uri


class ProgramNode(Node):
    """A `Node` for rospy: the layer has its own clock and /rosout, and decides when the node is closed.

    Args:
        on_shutdown_request: Called with the reason when the master or a tool ends this node, in a thread of
            its own.
        on_refused: Called with a text when a subscriber or a client of a service has another definition.
    """

    def __init__(
        self,
        name: str,
        *,
        on_shutdown_request: Callable[[str], object],
        on_refused: Callable[[str], object],
        **options: Any,
    ) -> None:
        self.on_refused = on_refused
        super().__init__(
            name,
            rosout=False,
            intraprocess=False,
            follow_clock=False,
            # rospy ends it, after the program's own hooks, which still publish: not before them at exit.
            close_at_exit=False,
            on_shutdown_request=on_shutdown_request,
            on_event=self._note,
            any_name=True,
            **options,
        )

    def _note(self, event: Event) -> None:
        if event.kind is EventKind.REFUSED and isinstance(event.error, Md5sumMismatch) and event.header:
            self.on_refused(refusal(event.header, event.error))


def refusal(fields: Mapping[str, str], error: Md5sumMismatch) -> str:
    """rospy's message about a peer that it refuses; `fields` is the peer's connection header."""
    who, ours, md5sum = fields.get("callerid", ""), error.type_name, error.md5sum
    theirs, asked = fields.get("type", ours), fields["md5sum"]
    if "service" in fields:
        why = f"request from [{who}]: md5sums do not match: [{asked}] vs. [{md5sum}]"
    elif theirs != ours:
        why = f"topic types do not match: [{theirs}] vs. [{ours}]"
    else:
        why = (
            f"Client [{who}] wants topic [{fields['topic']}] to have datatype/md5sum [{theirs}/{asked}], but"
            f" our version has [{ours}/{md5sum}] Dropping connection."
        )
    return f"Could not process inbound connection: {why}{dict(fields)}"


class Caller:
    """Calls services without a node: rospy's ServiceProxy works before init_node."""

    def __init__(self, name: str, master_uri: str) -> None:
        self.name = name
        self.limits = Limits()
        self.hosts = HostNames(host_names(), master=parse_uri(master_uri)[0])
        self.master = MasterClient(master_uri, name, timeout=60.0, hosts=self.hosts)
        self.definitions = KnownDefinitions()
        self.said = PeerLog("rosproto.rospy")
