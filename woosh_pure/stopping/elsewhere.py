"""Zeros and cancels from another node, for a moment: for when our own is about to be shut down.

When another node takes our name, a master tells those who listen to us that we are gone; they have then ended
the links before our own zeros and cancels were read. A fresh node, under a name that nobody has, reaches
them. (Tasks are cancelled by a service, for which names do not matter.)
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from rosproto.errors import RosError
from woosh_pure.connection.connection import Connection

__all__ = ["LastWord", "say_elsewhere"]

_LISTEN = 2.0  # seconds for somebody to listen
_FLUSH = _ARRIVE = 0.5  # seconds


@dataclass(frozen=True)
class LastWord:
    """What is to be said on one topic.

    Attributes:
        topic: Its name.
        message: The message.
        times: How often.
    """

    topic: str
    message: Any
    times: int = 1


def say_elsewhere(connection: Connection, words: Iterable[LastWord]) -> list[str]:
    """Say it from another node; never raises.

    Returns:
        What could not be said, in words.
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
                        problems.append(f"{word.topic}: the robot has not acknowledged it yet")
                except RosError as error:
                    problems.append(str(error))
    except (RosError, OSError, RuntimeError) as error:
        problems.append(str(error))
    return problems
