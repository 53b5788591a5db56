"""Our node at the master of one chassis: made on first use, closed by `close`. Safe from any thread.

`say_elsewhere` sends last zeros and cancels from a new node when ours was shut down.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import rosproto
from rosproto.errors import ConnectionLost, RosError
from rosproto.sentence import say
from rosproto.watchdog import WatchedNode, watched_node_of

_MAKING = 3.0  # seconds; what a signal handler has interrupted is made only afterwards


class Connection:
    """Where the chassis is, and our node there.

    Args:
        master_uri: Where its master is.
        name: Prefix of our node's name.
        host: Our own address; None finds it.
        timeout: Seconds for connecting and for services, where a call does not say otherwise.
        msg_path: Folders with further definitions.
        resolve: Host name -> address.
        before_close: Called with the reason before the node closes, while it still works.

    Attributes:
        making: Held while something is made that stays until `close`: one thing at a time. It may take long.
    """

    def __init__(
        self,
        master_uri: str,
        *,
        name: str,
        host: str | None,
        timeout: float,
        msg_path: Sequence[str | os.PathLike[str]] = (),
        resolve: Mapping[str, str] | None = None,
        before_close: Callable[[str], None],
    ) -> None:
        self.master_uri = master_uri
        self.timeout = timeout
        self.name, self._host = name, host
        self._msg_path = msg_path
        self._resolve = resolve
        self._before_close = before_close
        self.making = threading.RLock()
        self._node: rosproto.Node | None = None
        self._closed = False

    def open_node(self) -> rosproto.Node:
        """Our node, connected with the first call.

        Its name is unique: the master shuts down the older of two nodes with one name.

        Raises:
            ConnectionLost: This Chassis is closed, or the master cannot be reached.
        """
        made = self._node
        if made is not None and not self._closed:
            return made  # without the lock: `stop` must not wait for a verb that is connecting
        with self.making:
            self.require_open()
            if self._node is None:
                node = self.new_node()
                if self._closed:  # meanwhile
                    node.close()
                    self.require_open()
                node.before_close(self._before_close)
                self._node = node
            return self._node

    def new_node(self) -> rosproto.Node:
        """A node of ours, under a name that no other has."""
        return rosproto.Node(
            self.name,
            master_uri=self.master_uri,
            host=self._host,
            anonymous=True,
            timeout=self.timeout,
            msg_path=self._msg_path,
            resolve=self._resolve,
        )

    @property
    def watched_node(self) -> WatchedNode:
        """Where a watchdog stands beside our node."""
        return watched_node_of(self.open_node(), self._msg_path)

    @property
    def state(self) -> str:
        """The state of the connection in words."""
        if self._closed:
            return "closed"
        return "not connected yet" if self._node is None else "connected"

    def require_open(self) -> None:
        """Refuse everything after `close`.

        Raises:
            ConnectionLost: This Chassis is closed.
        """
        if self._closed:
            raise ConnectionLost(say("this Chassis is closed; open a new one for {uri}", uri=self.master_uri))

    def note_close(self) -> None:
        """From now on no node is made; waits a moment for one that is being made, which is closed at once."""
        self._closed = True
        if self.making.acquire(timeout=_MAKING):
            self.making.release()

    def close(self) -> None:
        """Close the node; goals and drives must have ended before. May be called again."""
        self.note_close()
        if self._node is not None:
            self._node.close()


_LISTEN = 2.0  # seconds for somebody to listen
_FLUSH = _ARRIVE = 0.5  # seconds


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


def say_elsewhere(connection: Connection, words: Iterable[FinalMessage]) -> list[str]:
    """Send zeros and cancels from a temporary node after our own was shut down; never raises.

    When another node takes our name, the master tells our subscribers that we are gone, and they close the
    links before they read our zeros and cancels. A new node with a unique name reaches them. (Tasks are
    cancelled by a service, for which names do not matter.)

    Returns:
        A sentence for each message that was not sent.
    """
    problems: list[str] = []
    try:
        with connection.new_node() as node:
            # All of them first: they connect at the same time.
            said = [
                (word, node.publisher(word.topic, type(word.message), queue_size=word.times, linger=False))
                for word in words
            ]
            for word, publisher in said:
                try:
                    publisher.wait_for_connection(timeout=_LISTEN)
                    for _ in range(word.times):
                        publisher.publish(word.message)
                except RosError as error:
                    problems.append(str(error))
            for word, publisher in said:
                try:
                    publisher.flush(_FLUSH)
                    if publisher.wait_arrived(_ARRIVE) is False:
                        problems.append(
                            say("{topic}: the robot has not acknowledged it yet", topic=word.topic)
                        )
                except RosError as error:
                    problems.append(str(error))
    except (RosError, OSError, RuntimeError) as error:
        problems.append(str(error))
    return problems
