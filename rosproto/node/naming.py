"""Resolves the relative, private and remapped names of one node to global names."""

from __future__ import annotations

import logging
from collections.abc import Mapping

from rosproto import names
from rosproto.logs import get_logger

_log = get_logger("rosproto.node")

MOST_WARNINGS = 100  # the bound for programs that generate names


class NodeNaming:
    """Resolves names for one node.

    Args:
        node_name: Global name of the node.
        remappings: Name -> other name, as written on a command line.

    Raises:
        ValueError: One side of a remapping is a name that no master accepts.
    """

    def __init__(self, node_name: str, remappings: Mapping[str, str]) -> None:
        self._node_name = node_name
        self._remappings = names.resolve_remappings(remappings, node_name)
        self._warned: set[str] = set()

    def resolve(self, name: str) -> str:
        """The remapped global name; a name that is accepted but not legal is logged once.

        Raises:
            ValueError: No master accepts it.
        """
        resolved = names.resolve(name, self._node_name, self._remappings)
        new = resolved not in self._warned and len(self._warned) < MOST_WARNINGS
        if new and not names.is_legal_name(resolved):
            self._warned.add(resolved)
            _log.warning("! %s is not a legal ROS name; roscpp and some tools refuse it", resolved)
        return resolved

    @property
    def logger(self) -> logging.Logger:
        """The logger with the node's name; `rosout.py` publishes its records."""
        return logging.getLogger("ros" + self._node_name.replace("/", "."))
