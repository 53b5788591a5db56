"""The names of one node: what a name given to it means, and a warning for one that not everybody takes."""

from __future__ import annotations

from collections.abc import Mapping

from rosproto import names
from rosproto.logs import get_logger

_log = get_logger("rosproto.node")

MOST_WARNINGS = 100  # names of a program that makes up a new one each time


class Naming:
    """Resolves names for one node.

    Args:
        node_name: The node's own, global.
        remappings: Names and what they stand for, as written on a command line.

    Raises:
        ValueError: One side of a remapping is a name that no master takes.
    """

    def __init__(self, node_name: str, remappings: Mapping[str, str]) -> None:
        self._node_name = node_name
        self._remappings = names.resolve_remappings(remappings, node_name)
        self._warned: set[str] = set()

    def resolve(self, name: str) -> str:
        """The global name, remapped; one that is not legal, though some use it, is warned of once.

        Raises:
            ValueError: No master takes it.
        """
        resolved = names.resolve(name, self._node_name, self._remappings)
        new = resolved not in self._warned and len(self._warned) < MOST_WARNINGS
        if new and not names.is_legal_name(resolved):
            self._warned.add(resolved)
            _log.warning("! %s is not a legal ROS name; roscpp and some tools refuse it", resolved)
        return resolved
