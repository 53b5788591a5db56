"""Values of subscribed parameters, updated by the master's paramUpdate calls; no I/O.

Source: wiki.ros.org/ROS/Slave_API (paramUpdate), wiki.ros.org/ROS/Parameter Server API (subscribeParam),
rosmaster paramserver.py `compute_param_updates` for details:

* an update names the subscribed key or a key below it, often with a trailing slash;
* a deleted parameter arrives as `{}`, the same as an empty namespace;
* the node that set a value gets an update only sometimes, so equal values are not a change.

An update may arrive before the answer of its subscribeParam call. The answer is the older of the two, so
updates that arrive meanwhile are kept and applied to it (`begin`, `start`).
"""

from __future__ import annotations

import threading
from collections.abc import Iterable
from typing import NamedTuple

# Deeper keys are ignored, to bound the recursive comparison.
MAX_PARTS = 128


ABSENT: object = object()
"""The parameter is not set."""


class ParameterChange(NamedTuple):
    """A change of the value of one subscription.

    Attributes:
        subscribed: The subscribed key.
        key: The key that changed: the subscribed one or one below it.
        value: Its new value; `ABSENT` when it was deleted.
    """

    subscribed: str
    key: str
    value: object


def canonical_key(key: str) -> str:
    """`/a//b/` -> `/a/b`; the root is `/`."""
    return "/" + "/".join(_parts(key))


def _parts(key: str) -> list[str]:
    return [part for part in key.split("/") if part]


def same_value(a: object, b: object) -> bool:
    """Equality of type and value, as for the parameter server: True, 1 and 1.0 differ, NaN equals itself."""
    if type(a) is not type(b):
        return False
    if isinstance(a, dict) and isinstance(b, dict):
        return a.keys() == b.keys() and all(same_value(a[key], b[key]) for key in a)
    if isinstance(a, (list, tuple)) and isinstance(b, (list, tuple)):
        return len(a) == len(b) and all(map(same_value, a, b))
    return bool(a == b or (a != a and b != b))


def _below(value: object, path: Iterable[str]) -> object:
    """The part of `value` at `path`, or ABSENT."""
    for part in path:
        if not isinstance(value, dict) or part not in value:
            return ABSENT
        value = value[part]
    return value


def _replaced(tree: object, path: list[str], value: object) -> object:
    """A copy of `tree` with `value` at `path` (removed when ABSENT)."""
    if not path:
        return value
    branch = dict(tree) if isinstance(tree, dict) else {}
    inner = _replaced(branch.get(path[0], ABSENT), path[1:], value)
    if inner is ABSENT:
        branch.pop(path[0], None)
    else:
        branch[path[0]] = inner
    return branch or ABSENT


def _or_absent(value: object) -> object:
    return ABSENT if isinstance(value, dict) and not value else value


class ParameterCache:
    """Subscribed keys and their values; every method may be called from any thread."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._values: dict[str, object] = {}
        self._early: dict[str, list[tuple[str, object]]] = {}  # updates that came before the answer

    def keys(self) -> list[str]:
        """The subscribed keys."""
        with self._lock:
            return list(self._values)

    def begin(self, key: str) -> None:
        """Collect updates of `key` from now on; call before subscribeParam is sent."""
        with self._lock:
            self._values.setdefault(key, ABSENT)
            self._early[key] = []

    def start(self, key: str, value: object) -> list[ParameterChange]:
        """Take the answer of subscribeParam, and apply the updates that came before it.

        Returns:
            The change of the known value: none or one.
        """
        with self._lock:
            if key not in self._values:
                return []  # unsubscribed meanwhile
            known, value = self._values[key], _or_absent(value)
            for changed, new in self._early.pop(key, ()):
                value = self._laid_over(key, value, changed, new)
            self._values[key] = value
            return [] if same_value(known, value) else [ParameterChange(key, key, value)]

    def forget(self, key: str) -> None:
        """Drop a subscription and its value."""
        with self._lock:
            self._values.pop(key, None)
            self._early.pop(key, None)

    def get(self, key: str) -> object:
        """Value of a subscribed key, or of one below a subscribed key; ABSENT when it is not set.

        Raises:
            KeyError: Neither `key` nor a namespace above it is subscribed.
        """
        parts = _parts(key)
        with self._lock:
            for depth in range(len(parts), -1, -1):
                subscribed = "/" + "/".join(parts[:depth])
                if subscribed in self._values:
                    return _below(self._values[subscribed], parts[depth:])
        raise KeyError(key)

    def apply(self, key: str, value: object) -> list[ParameterChange]:
        """Take an update from the master, or a value that this node has set.

        Args:
            key: Changed key, with or without a trailing slash.
            value: Its value; `{}` or ABSENT when it was deleted.

        Returns:
            One change for each subscription whose value has changed.
        """
        parts = _parts(key)
        if len(parts) > MAX_PARTS:
            return []
        key, value = "/" + "/".join(parts), _or_absent(value)
        changes = []
        with self._lock:
            for subscribed, known in self._values.items():
                change = self._change(subscribed, known, key, value)
                if change is not None:
                    changes.append(change)
                if subscribed in self._early:
                    self._early[subscribed].append((key, value))
            for change in changes:
                known = self._values[change.subscribed]
                self._values[change.subscribed] = self._laid_over(change.subscribed, known, key, value)
        return changes

    @staticmethod
    def _change(subscribed: str, known: object, key: str, value: object) -> ParameterChange | None:
        mine, theirs = _parts(subscribed), _parts(key)
        if theirs[: len(mine)] == mine:
            new, old, changed = value, _below(known, theirs[len(mine) :]), key
        elif mine[: len(theirs)] == theirs:
            new, old, changed = _or_absent(_below(value, mine[len(theirs) :])), known, subscribed
        else:
            return None
        return None if same_value(old, new) else ParameterChange(subscribed, changed, new)

    @staticmethod
    def _laid_over(subscribed: str, known: object, key: str, value: object) -> object:
        mine, theirs = _parts(subscribed), _parts(key)
        if theirs[: len(mine)] == mine:
            return _replaced(known, theirs[len(mine) :], value)
        if mine[: len(theirs)] == theirs:
            return _or_absent(_below(value, mine[len(theirs) :]))
        return known
