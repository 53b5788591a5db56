"""Interprets the arguments of `Node`, and the names that a program gives it."""

from __future__ import annotations

import logging
import os
from collections.abc import Callable, Iterable, Mapping

from rosproto import names
from rosproto.coercion import require_callback
from rosproto.logs import get_logger
from rosproto.msg.user_folder import environment_paths
from rosproto.sentence import both, led, say
from rosproto.transport.own_address import host_from_environment
from rosproto.transport.robot_host_names import VARIABLE, parse_host_names

_log = get_logger("rosproto.node")


def node_name(name: str, namespace: str, anonymous: bool) -> str:
    """The global name of a node; `anonymous` adds a unique suffix.

    What the program names itself must be legal. The namespace is the robot's, and need only be usable.

    Raises:
        ValueError: `name` is not a node name, or no master accepts the namespace.
    """
    space = names.canonicalize(f"/{namespace}")
    if not names.is_usable_name(space) or space.startswith("/~"):
        expected = "expected something like '/robot_1': letters, digits, `_` or `/`"
        source = "it comes from the argument namespace, or from the variable ROS_NAMESPACE"
        raise ValueError(both(say("namespace {name!r} is not a ROS name", name=namespace), expected, source))
    if not name or name.startswith("~") or not names.is_legal_name(name) or not name.strip("/"):
        form = "expected something like '/laptop': an ASCII letter or `/`, then letters, digits, `_` or `/`"
        raise ValueError(both(say("{name!r} is not a node name", name=name), form))
    resolved = names.resolve(name, names.join(space, "x"))
    if not names.is_legal_name(resolved):
        _log.warning("! %s", _not_legal(resolved))
    if anonymous:
        space, _, base = resolved.rpartition("/")
        return f"{space}/{names.anonymous_name(base)}"
    return resolved


def message_path(
    given: Iterable[str | os.PathLike[str]], *, use_environment: bool
) -> list[str | os.PathLike[str]]:
    """The given folders and, with `use_environment`, the others of $ROSPROTO_MSG_PATH."""
    folders = list(given)
    return (
        folders + [path for path in environment_paths() if path not in folders]
        if use_environment
        else folders
    )


def host_names() -> dict[str, str]:
    """Host names of $ROSPROTO_RESOLVE: "NAME=IP,NAME=IP".

    Raises:
        ValueError: It has another format.
    """
    try:
        return parse_host_names([os.environ.get(VARIABLE, "")])
    except ValueError as error:
        raise ValueError(led(VARIABLE, str(error))) from None


def from_environment(
    master_uri: str | None, host: str | None, namespace: str
) -> tuple[str | None, str | None, str]:
    """Master, host and namespace; ROS's environment variables replace those not given."""
    environment = os.environ
    if namespace == "/":
        namespace = environment.get("ROS_NAMESPACE", "") or "/"
    return (
        master_uri or environment.get("ROS_MASTER_URI", "") or "http://localhost:11311/",
        host or host_from_environment(environment),
        namespace,
    )


def callback_or_none(callback: Callable[..., object] | None, what: str) -> None:
    """`require_callback` of one that may be left out."""
    if callback is not None:
        require_callback(callback, what)


def queue_length(size: int) -> int:
    """Check and return a queue_size.

    Raises:
        ValueError: It is not an integer of at least 1.
    """
    if not isinstance(size, int) or isinstance(size, bool) or size < 1:
        text = "queue_size must be a number of messages, at least 1, not {value!r}"
        raise ValueError(say(text, value=size))
    return size


def _not_legal(name: str) -> str:
    return f"{name} is not a legal ROS name; roscpp and some tools refuse it"


MAX_WARNINGS = 100  # the bound for programs that generate names


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
        new = resolved not in self._warned and len(self._warned) < MAX_WARNINGS
        if new and not names.is_legal_name(resolved):
            self._warned.add(resolved)
            _log.warning("! %s", _not_legal(resolved))
        return resolved

    @property
    def logger(self) -> logging.Logger:
        """The logger with the node's name; `rosout.py` publishes its records."""
        return logging.getLogger("ros" + self._node_name.replace("/", "."))
