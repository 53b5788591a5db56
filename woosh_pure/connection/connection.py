"""Our node at the master of one chassis: made on first use, closed by `close`. Safe from any thread.

`say_elsewhere` sends last zeros and cancels from a new node when ours was shut down.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import rosproto
from rosproto.errors import ConnectionLost, RosError
from rosproto.logs import get_logger
from rosproto.sentence import say
from rosproto.transport import Deadline
from rosproto.watchdog import WatchedNode, watched_node_of

if TYPE_CHECKING:
    from woosh_pure.robot_api.http import ApiAddress

logger = get_logger("woosh_pure.connection")
_MAKING = 3.0  # seconds; work that a signal handler has interrupted continues only afterwards


class Connection:
    """The address of the chassis, and our node at its master.

    Args:
        master_uri: Its master.
        new_node: Makes a node there. Its name is unique: the master shuts down the older of two namesakes.
        timeout: Default time limit for connecting and for services, s.
        msg_path: Folders with further definitions.

    Attributes:
        before_close: Called with the reason before the node closes, while it still works.
        making: Lock, held while something is made that lives until `close`. That may take long.
        robot_api: Where a robot is that has only the Robot API; None of one with ROS 1.
    """

    def __init__(
        self,
        master_uri: str,
        new_node: Callable[[], rosproto.Node],
        *,
        timeout: float,
        msg_path: Sequence[str | os.PathLike[str]] = (),
        robot_api: ApiAddress | None = None,
    ) -> None:
        self.robot_api = robot_api
        self.master_uri, self.new_node, self.timeout = master_uri, new_node, timeout
        self._msg_path = msg_path
        self.before_close: Callable[[str], object] = lambda reason: None
        self.making = threading.RLock()
        self._node: rosproto.Node | None = None
        self._closed = False

    def open_node(self) -> rosproto.Node:
        """Our node, connected with the first call.

        Raises:
            ConnectionLost: This Chassis is closed, or the master cannot be reached.
        """
        made = self._node
        if made is not None and not self._closed:
            return made  # no lock: `stop` must not wait for a verb that is connecting
        with self.making:
            self.require_open()
            if self._node is None:
                node = self.new_node()
                if self._closed:  # meanwhile
                    node.close()
                    self.require_open()
                node.before_close(self.before_close)
                self._node = node
            return self._node

    @property
    def watched_node(self) -> WatchedNode:
        """Our node, as a watchdog needs it."""
        return watched_node_of(self.open_node(), self._msg_path)

    @property
    def state(self) -> str:
        """The state of the connection in words."""
        if self._closed:
            return "closed"
        return "not connected yet" if self._node is None else "connected"

    def require_open(self) -> None:
        """Check that `close` was not called.

        Raises:
            ConnectionLost: This Chassis is closed.
        """
        if self._closed:
            raise ConnectionLost(say("this Chassis is closed; open a new one for {uri}", uri=self.master_uri))

    def note_close(self) -> None:
        """Prevent nodes from being made; wait briefly for one that is being made, and close it."""
        self._closed = True
        if self.making.acquire(timeout=_MAKING):
            self.making.release()

    def close(self) -> None:
        """Close the node; goals and drives must have ended before. May be called again."""
        self.note_close()
        if self._node is not None:
            self._node.close()


_LISTEN = 2.0  # seconds for a subscriber to connect
_FLUSH = _ARRIVE = 0.5  # seconds
_OWN_OVER = 8.0  # seconds for our own node to say its last words
_READ = 0.5  # seconds for the robot to read, before the master tells it that the node is gone


@dataclass(frozen=True)
class FinalMessage:
    """A message to send from another node.

    Attributes:
        topic: Its name.
        message: The message.
        times: How often.
    """

    topic: str
    message: Any
    times: int = 1


def say_elsewhere(
    connection: Connection, words: Iterable[FinalMessage], own_over: threading.Event
) -> list[str]:
    """Send zeros and cancels from a temporary node while our own is shut down; never raises.

    When another node takes our name, the master tells our subscribers that we are gone, and they close the
    links before they read our zeros and cancels. A new node with a unique name reaches them. (Tasks are
    cancelled by a service, for which names do not matter.)

    They are sent at once, and again when our own node has ended: the robot may read a last velocity of its
    link after the zeros of this one.

    Args:
        connection: Makes the node.
        words: The messages.
        own_over: Set when our own node sends nothing more.

    Returns:
        A sentence for each message that was not sent.
    """
    problems: list[str] = []
    try:
        with connection.new_node() as node:
            # Made first, so that all connect at the same time.
            said = [
                (word, node.publisher(word.topic, type(word.message), queue_size=word.times, linger=False))
                for word in words
            ]
            for word, publisher in said:
                _say(word, publisher)
            own_over.wait(_OWN_OVER)
            problems = [problem for word, publisher in said if (problem := _say(word, publisher))]
            for _, publisher in said:
                publisher.close(wait=_READ)
    except (RosError, OSError, RuntimeError) as error:
        problems.append(str(error))
    return problems


def _say(word: FinalMessage, publisher: rosproto.Publisher) -> str:
    """Send a message until it has arrived, for a bounded time; return a sentence if it has not.

    The link may be lost and made again meanwhile: lists of publishers from the master may come in any order.
    """
    deadline = Deadline(_LISTEN)
    while True:
        try:
            publisher.wait_for_connection(timeout=deadline.remaining() or 0.0)
            for _ in range(word.times):
                publisher.publish(word.message)
        except RosError as error:
            return str(error)
        if has_arrived(publisher) is not False:
            return ""
        if deadline.expired:
            return say("{topic}: the robot has not acknowledged it yet", topic=word.topic)


def has_arrived(publisher: rosproto.Publisher) -> bool | None:
    """Wait until sent messages have arrived on the robot; None where the system does not report that.

    Called before the publisher is unregistered: the robot then ends the link and reads no more, and zeros
    that a lossy network retransmits would be too late.
    """
    try:
        publisher.flush(_FLUSH)
        arrived = publisher.wait_arrived(_ARRIVE)
        links = publisher.stats()  # a link that was closed meanwhile has delivered nothing
        return arrived if links and all(link.connected for link in links) else False
    except RosError as error:
        logger.debug("! %s: not flushed: %s", publisher.topic, error)
        return False
