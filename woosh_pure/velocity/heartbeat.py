"""Whether velocities still reach the robot in time: the node that listens is asked now and then.

For a drive that does without measured velocities. A link alone tells nothing for many seconds: TCP keeps what
the network does not deliver, and delivers it later. The question is `getPid` of wiki.ros.org/ROS/Slave_API,
which every node answers at once.
"""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING

from rosproto.errors import ConnectionLost, MasterError, RemoteProtocolError, RosError
from rosproto.logs import get_logger
from rosproto.node import NodeClient
from rosproto.transport import parse_uri
from woosh_pure.connection.other_drivers import is_refused
from woosh_pure.interface.table import ROBOT_NODES
from woosh_pure.velocity import boottime

if TYPE_CHECKING:
    import rosproto
    from woosh_pure.stopping.keeper import Flag

__all__ = ["LATE", "Heartbeat"]

LATE = 1.0
"""Seconds without an answer after which what is sent counts as late."""
_PERIOD = 0.25
logger = get_logger("woosh_pure.velocity")


class Heartbeat:
    """Asks the node behind a publisher's link, in a thread of its own, until `over` is set.

    Args:
        node: In whose name to ask.
        publisher: Of the velocity topic; somebody is connected.
        over: Ends it.
    """

    def __init__(self, node: rosproto.Node, publisher: rosproto.Publisher, over: Flag) -> None:
        self._node = node
        self._publisher = publisher
        self._over = over
        self._answered: float | None = None

    def start(self) -> None:
        """Ask for the first time, at most two seconds, and go on in the background.

        A node that cannot be asked at all (a firewall) is no reason not to drive: that is logged, and `late`
        stays false.
        """
        try:
            listener = min(self._publisher.subscribers, key=lambda name: name not in ROBOT_NODES)
            uri = self._node.master.lookup_node(listener, timeout=LATE)
            with NodeClient(uri, self._node.name, hosts=self._node.hosts) as client:
                self._ask(client)
        except (RosError, ValueError) as error:
            logger.warning(
                "! %s: who listens cannot be asked (%s): nothing ends this drive when the network delivers "
                "late; watch the robot",
                self._publisher.topic,
                error,
            )
            return
        threading.Thread(target=self._run, args=(uri,), name="woosh:heartbeat", daemon=True).start()

    @property
    def late(self) -> bool:
        """Whether the last answered question is too long ago."""
        return self._answered is not None and boottime.seconds() - self._answered > LATE

    def _run(self, uri: str) -> None:
        with NodeClient(uri, self._node.name, hosts=self._node.hosts) as client:
            while not self._over.wait(_PERIOD):
                try:
                    self._ask(client)
                except RosError:
                    continue

    def _ask(self, client: NodeClient) -> None:
        """One question. What counts is when an answered one was asked: a late answer is no answer."""
        asked = boottime.seconds()
        try:
            client.get_pid(timeout=LATE)
        except (MasterError, RemoteProtocolError):
            pass  # an odd answer, but one
        except ConnectionLost as error:
            if not is_refused(error) or self._node.hosts.is_guess(parse_uri(client.uri)[0]):
                raise  # refused: the robot's computer has answered; that the node is gone tells its link
        self._answered = asked
