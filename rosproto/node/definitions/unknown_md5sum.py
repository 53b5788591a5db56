"""The definition behind a subscriber's md5sum that nobody here knows, asked of others who publish that topic.

A rospy subscriber sends its definition, a roscpp one does not. But on a chassis the action servers have a
client of their own (`/ros_interface` publishes their goal topics), and a publisher tells its definition to
everybody: the one whose md5sum is the subscriber's is the one that is missing.

A publisher is asked for its type, md5sum and definition, without receiving a message. The wildcard md5sum
is what rostopic sends; the publisher answers with its header, and we leave. Nothing is registered at the
master.

Source: wiki.ros.org/ROS/TCPROS, wiki.ros.org/ROS/Slave_API (requestTopic).
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import TYPE_CHECKING

from rosproto.codec import Message
from rosproto.errors import ConnectionLost, RosError
from rosproto.logs import get_logger
from rosproto.node.definitions.type_argument import ANY
from rosproto.node.graph.slave_client import NodeClient
from rosproto.protocol.handshake import PublisherReply, check_publisher_header, subscriber_header
from rosproto.transport.connecting import connect
from rosproto.transport.deadline import Deadline
from rosproto.transport.tcpros_io import read_header, write_header

if TYPE_CHECKING:
    from rosproto.node.graph.caller_identity import Caller

_log = get_logger("rosproto.node")


def probe_topic(caller: Caller, topic: str, publisher: str, deadline: Deadline) -> PublisherReply:
    """What one publisher says about a topic.

    Args:
        caller: In whose name to ask.
        topic: Resolved name.
        publisher: Name of the publishing node.
        deadline: For all steps together.

    Raises:
        MasterError: The master does not know the node, or it does not publish the topic (any more).
        ConnectionLost, RosTimeout: It cannot be reached.
        RemoteProtocolError: Its answer is no header of a publisher.
    """
    uri = caller.master.lookup_node(publisher, timeout=deadline.remaining())
    with NodeClient(uri, caller.name, limits=caller.limits, hosts=caller.hosts) as peer:
        answer = peer.request_topic(topic, timeout=deadline.remaining())
    if len(answer) < 3 or answer[0] != "TCPROS" or not isinstance(answer[2], int):
        raise ConnectionLost(
            f"{topic}: {publisher} offers no TCPROS connection (answered {str(answer)[:100]})", peer=uri
        )
    sock = connect(str(answer[1]), answer[2], deadline, hosts=caller.hosts)
    try:
        wanted = subscriber_header(topic=topic, type_name=ANY, md5sum=ANY, callerid=caller.name)
        write_header(sock, wanted, deadline)
        header = read_header(sock, caller.limits, deadline)
    finally:
        sock.close()
    return check_publisher_header(header, topic=topic, type_name=ANY, md5sum=ANY, peer=publisher)


FETCH_SECONDS = 3.0  # the subscriber waits for our answer meanwhile
MOST_ASKED = 8
AGAIN_AFTER = 10.0  # seconds; a stranger who connects again and again must not make us busy
MOST_REMEMBERED = 200


Learn = Callable[["type[Message]", str, str], "type[Message] | None"]
"""`Revisions.learn`: the class of a type by md5sum and full definition; None when they do not agree."""


class DefinitionLookup:
    """What was asked of other publishers, for one node; safe from any thread."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._asked: dict[tuple[str, str], float] = {}

    def fetch(
        self, caller: Caller, learn: Learn, topic: str, ours: type[Message], md5sum: str
    ) -> type[Message] | None:
        """The class of `ours`' type with that md5sum, by another publisher's word; None when nobody has it.

        `learn` makes a class of a definition that was found (`Revisions.learn`).

        Waits at most `FETCH_SECONDS`; a question without an answer is not repeated for `AGAIN_AFTER` seconds.
        """
        if not self._may_ask(topic, md5sum):
            return None
        deadline = Deadline(FETCH_SECONDS)
        try:
            publishers = caller.master.get_system_state(timeout=deadline.remaining()).publishers.get(
                topic, []
            )
        except (RosError, OSError) as error:
            _log.debug("! %s: nobody can be asked for a definition: %s", topic, error)
            return None
        for publisher in [name for name in publishers if name != caller.name][:MOST_ASKED]:
            try:
                reply = probe_topic(caller, topic, publisher, deadline)
            except (RosError, OSError) as error:
                _log.debug("! %s: %s does not tell its definition: %s", topic, publisher, error)
                continue
            if reply.md5sum == md5sum and reply.type_name == ours._type:
                found = learn(ours, md5sum, reply.message_definition)
                if found is not None:
                    _log.info("= %s: the definition %s was learned from %s", topic, md5sum, publisher)
                    return found
        return None

    def _may_ask(self, topic: str, md5sum: str) -> bool:
        now = time.monotonic()
        with self._lock:
            if now - self._asked.get((topic, md5sum), -AGAIN_AFTER) < AGAIN_AFTER:
                return False
            if len(self._asked) >= MOST_REMEMBERED:
                recent = {key: when for key, when in self._asked.items() if now - when < AGAIN_AFTER}
                if len(recent) >= MOST_REMEMBERED:
                    return False
                self._asked = recent
            self._asked[topic, md5sum] = now
            return True
