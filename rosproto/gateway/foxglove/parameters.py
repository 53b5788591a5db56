"""Parameters for viewers: reads, sets and follows single values by their full names."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Iterator

from rosproto.errors import MasterError, RosError
from rosproto.gateway.foxglove.server_state import ServerState
from rosproto.logs import get_logger
from rosproto.node.parameters import ParameterSubscription

_log = get_logger("rosproto.gateway")

ASK_SECONDS = 3.0
MOST = 10_000  # parameters sent to a client at a time
DEEPEST = 64


def leaves(name: str, value: object, depth: int = 0) -> Iterator[tuple[str, object]]:
    """The parameters below a namespace, with their full names; an empty namespace counts as a value."""
    if isinstance(value, dict) and value and depth < DEEPEST:
        for key, one in value.items():
            yield from leaves(f"{name.rstrip('/')}/{key}", one, depth + 1)
    else:
        yield name, value


class ViewerParameters:
    """The parameters of the robot, for one viewer.

    Args:
        state: Shared by all sessions.
        tell: Called with changed parameters, (name, value); in a thread of the node.
    """

    def __init__(self, state: ServerState, tell: Callable[[list[tuple[str, object]]], object]) -> None:
        self._node, self._access, self._limits = state.node, state.access, state.limits
        self._tell = tell
        self._lock = threading.Lock()
        self._followed: dict[str, ParameterSubscription] = {}
        self._closed = False

    def get(self, names: Iterable[str]) -> dict[str, object]:
        """The values of these parameters, or of all; without those that are not set or not readable.

        Raises:
            RosError: The master does not answer.
        """
        wanted = [_named(name) for name in names][:MOST]
        if not wanted:
            tree = self._node.master.get_param("/", timeout=ASK_SECONDS)
            pairs = leaves("/", tree) if isinstance(tree, dict) and tree else iter(())
        else:
            answers = self._node.master.several(
                [("getParam", (name,)) for name in wanted], timeout=ASK_SECONDS
            )
            pairs = (
                leaf
                for name, value in zip(wanted, answers, strict=True)
                if not isinstance(value, MasterError)
                for leaf in leaves(name, value)
            )
        found: dict[str, object] = {}
        for name, value in pairs:
            if len(found) >= MOST:
                break
            if self._access.may_read("parameter", name) is None:
                found[name] = value
        return found

    def set(self, name: str, value: object) -> str | None:
        """Set a parameter, or delete it with None. Return None, or a sentence if it failed."""
        name = _named(name)
        if len(name) > self._limits.text_length:
            return "the name of a parameter is too long"
        refusal = self._access.may_write("parameter", name)
        if refusal is not None:
            return refusal.text
        try:
            if value is None:
                self._node.params.delete(name)
            else:
                self._node.params.set(name, value)
        except (RosError, ValueError) as problem:
            return f"parameter {name} is not set: {problem}"
        return None

    def follow(self, names: Iterable[str]) -> str | None:
        """Follow more parameters; calls the master. Return None, or a sentence if some failed."""
        problem = None
        most = self._limits.subscriptions_per_client
        for name in names:
            with self._lock:
                if self._closed or name in self._followed:
                    continue
                if len(self._followed) >= most:
                    return f"{most} parameters are followed, which is the limit for a client"
            refusal = self._access.may_read("parameter", name)
            if refusal is not None:
                problem = refusal.text
                continue
            try:
                made = self._node.params.subscribe(name, self._changed)
            except (RosError, ValueError) as error:
                problem = f"parameter {name[:200]} is not followed: {error}"
                continue
            with self._lock:
                kept = not self._closed and self._followed.setdefault(name, made) is made
            if not kept:
                made.close()
            elif made.value is not None:  # it may have changed since the client read it
                self._changed(name, made.value)
        return problem

    def leave(self, names: Iterable[str] = ()) -> None:
        """Stop following these parameters; without names, all."""
        with self._lock:
            left = tuple(names) or tuple(self._followed)
            over = [self._followed.pop(name) for name in left if name in self._followed]
        for one in over:
            try:
                one.close()
            except RosError as problem:
                _log.info("! foxglove: parameter %s could not be left: %s", one.key, problem)

    def _changed(self, key: str, value: object) -> None:
        pairs = [
            (name, one)
            for name, one in leaves(key, value)
            if self._access.may_read("parameter", name) is None
        ]
        if pairs and not self._closed:
            self._tell(pairs[:MOST])

    def close(self) -> None:
        """Stop following all."""
        with self._lock:
            self._closed = True
        self.leave()


def _named(name: str) -> str:
    return name if name.startswith("/") else f"/{name}"
