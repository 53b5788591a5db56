"""Parameters for viewers: reads, sets and follows single values by their full names."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from itertools import islice

from rosproto.errors import MasterError, RosError
from rosproto.gateway.foxglove.server_state import ServerState
from rosproto.gateway.parameter_access import HIDDEN, ParameterAccess
from rosproto.logs import get_logger
from rosproto.node.parameters import ParameterSubscription

_log = get_logger("rosproto.gateway")

ASK_SECONDS = 3.0
MAX_PARAMETERS = 10_000  # parameters sent to a client at a time
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
        self._rules = ParameterAccess(state.node, state.access)
        self._tell = tell
        self._lock = threading.Lock()
        self._followed: dict[str, ParameterSubscription] = {}
        self._closed = False

    def get(self, names: Iterable[str]) -> dict[str, object]:
        """The values of these parameters, or of all; without those that are not set or not readable.

        Raises:
            RosError: The master does not answer.
        """
        asked = list(names)[:MAX_PARAMETERS]
        wanted = self._keys(asked) if asked else ["/"]
        answers = self._node.master.batch([("getParam", (key,)) for key in wanted], timeout=ASK_SECONDS)
        if not asked and isinstance(answers[0], MasterError):
            raise answers[0]
        pairs = (
            leaf
            for key, value in zip(wanted, answers, strict=True)
            if not isinstance(value, MasterError)
            for leaf in self._visible(key, value)
        )
        return dict(islice(pairs, MAX_PARAMETERS))

    def _keys(self, names: Iterable[str]) -> list[str]:
        """The full names of parameters, without those that are not names."""
        keys = []
        for name in names:
            with suppress(ValueError):
                keys.append(self._rules.key(name))
        return keys

    def _visible(self, key: str, value: object) -> Iterator[tuple[str, object]]:
        shown = self._rules.visible(key, value)
        return iter(()) if shown is HIDDEN or (key == "/" and not shown) else leaves(key, shown)

    def set(self, name: str, value: object) -> str | None:
        """Set a parameter, or delete it with None. Return None, or a sentence if it failed."""
        if len(name) > self._limits.text_length:
            return "the name of a parameter is too long"
        try:
            key = self._rules.key(name)
            refusal = self._rules.may_write(key, value)
            if refusal is not None:
                return refusal.text
            if value is None:
                self._node.params.delete(key)
            else:
                self._node.params.set(key, value)
        except (RosError, ValueError) as problem:
            return f"parameter {name} is not set: {problem}"
        return None

    def follow(self, names: Iterable[str]) -> str | None:
        """Follow more parameters; calls the master. Return None, or a sentence if some failed."""
        problem = None
        limit = self._limits.subscriptions_per_client
        for name in names:
            try:
                key = self._rules.key(name)
                with self._lock:
                    if self._closed or key in self._followed:
                        continue
                    if len(self._followed) >= limit:
                        return f"{limit} parameters are subscribed to, which is the limit for a client"
                refusal = self._access.may_read("parameter", key)
                if refusal is not None:
                    problem = refusal.text
                    continue
                made = self._node.params.subscribe(key, self._changed)
            except (RosError, ValueError) as error:
                problem = f"parameter {name[:200]} is not subscribed to: {error}"
                continue
            with self._lock:
                kept = not self._closed and self._followed.setdefault(key, made) is made
            if not kept:
                made.close()
            elif made.value is not None:  # it may have changed since the client read it
                self._changed(key, made.value)
        return problem

    def leave(self, names: Iterable[str] = ()) -> None:
        """Stop following these parameters; without names, all."""
        named = tuple(names)
        left = self._keys(named)
        with self._lock:
            if not named:
                left = list(self._followed)
            over = [self._followed.pop(key) for key in left if key in self._followed]
        for one in over:
            try:
                one.close()
            except RosError as problem:
                _log.info("! foxglove: parameter %s could not be unsubscribed: %s", one.key, problem)

    def _changed(self, key: str, value: object) -> None:
        pairs = list(self._visible(key, value))
        if pairs and not self._closed:
            self._tell(pairs[:MAX_PARAMETERS])

    def close(self) -> None:
        """Stop following all."""
        with self._lock:
            self._closed = True
        self.leave()
