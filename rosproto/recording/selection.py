"""Which topics to record: by name, by pattern, all, or those of a node, with exceptions."""

from __future__ import annotations

import re
from collections.abc import Iterable

__all__ = ["TopicSelection"]


class TopicSelection:
    """A choice of topics, made once and applied to every topic that appears.

    Args:
        topics: Global names, chosen whether or not somebody publishes them yet.
        patterns: Regular expressions for whole names (rosbag record -e).
        exclude: Regular expressions for whole names that `patterns`, `all` and `node` leave out.
        all: Every topic.
        node: Every topic that this node subscribes to.

    Raises:
        ValueError: Nothing is chosen, or a pattern is invalid.
    """

    def __init__(
        self,
        topics: Iterable[str] = (),
        *,
        patterns: Iterable[str] = (),
        exclude: Iterable[str] = (),
        all: bool = False,
        node: str | None = None,
    ) -> None:
        self.topics = tuple(dict.fromkeys(topics))
        self._patterns = [_compiled(pattern) for pattern in patterns]
        self._exclude = [_compiled(pattern) for pattern in exclude]
        self._all = all
        self.node = node
        if not (self.topics or self._patterns or all or node):
            raise ValueError("nothing to record: name topics, or give a pattern, a node, or all")

    @property
    def is_open(self) -> bool:
        """True when topics that appear later may be chosen, so that the master must be asked again."""
        return bool(self._all or self._patterns or self.node)

    def takes(self, topic: str, subscribers: Iterable[str] = ()) -> bool:
        """Whether a topic is chosen; `subscribers` are the nodes that subscribe to it."""
        if topic in self.topics:
            return True
        if any(pattern.fullmatch(topic) for pattern in self._exclude):
            return False
        if self._all or any(pattern.fullmatch(topic) for pattern in self._patterns):
            return True
        return self.node is not None and self.node in subscribers


def _compiled(pattern: str) -> re.Pattern[str]:
    try:
        return re.compile(pattern)
    except re.error as problem:
        raise ValueError(f"{pattern!r} is no regular expression: {problem}") from None
