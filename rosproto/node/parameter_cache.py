"""The values of subscribed parameters, kept up to date by the master's paramUpdate calls: no I/O.

Source: wiki.ros.org/ROS/Slave_API (paramUpdate), wiki.ros.org/ROS/Parameter Server API (subscribeParam),
rosmaster paramserver.py `compute_param_updates` for what the pages leave open:

* an update names the subscribed key or something below it, often with a trailing slash;
* a deleted parameter arrives as `{}`: an empty namespace and no parameter cannot be told apart;
* the node that set a value is not told about it, or only sometimes: equal values are therefore no change.

An update may overtake the answer of the subscribeParam call that asked for it. The answer is the older of the
two, so what arrived meanwhile is kept aside and laid over it (`begin`, `start`).
"""

from __future__ import annotations

import threading
from collections.abc import Iterable
from typing import Any, NamedTuple

# Deeper keys than this are no parameters of anybody; the bound keeps recursive comparison safe.
MOST_PARTS = 128


class Absent:
    """Type of `ABSENT`: the parameter is not set."""

    __slots__ = ()

    def __repr__(self) -> str:
        return "ABSENT"


ABSENT = Absent()


class ParameterChange(NamedTuple):
    """One subscription saw one change.

    Attributes:
        subscribed: The subscribed key.
        key: The key that changed: the subscribed one or one below it.
        value: Its new value; `ABSENT` when it is gone.
    """

    subscribed: str
    key: str
    value: Any


def canonical_key(key: str) -> str:
    """`/a//b/` -> `/a/b`; the root is `/`."""
    return "/" + "/".join(_parts(key))


def _parts(key: str) -> list[str]:
    return [part for part in key.split("/") if part]


def same_value(a: Any, b: Any) -> bool:
    """Equality as the parameter server sees it: True, 1 and 1.0 are three values, NaN equals itself."""
    if type(a) is not type(b):
        return False
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(same_value(a[key], b[key]) for key in a)
    if isinstance(a, (list, tuple)):
        return len(a) == len(b) and all(map(same_value, a, b))
    return bool(a == b or (a != a and b != b))


def _below(value: Any, path: Iterable[str]) -> Any:
    """What `value` holds at `path`, or ABSENT."""
    for part in path:
        if not isinstance(value, dict) or part not in value:
            return ABSENT
        value = value[part]
    return value


def _replaced(tree: Any, path: list[str], value: Any) -> Any:
    """A copy of `tree` with `value` at `path` (removed when ABSENT); `tree` itself is left alone."""
    if not path:
        return value
    branch = dict(tree) if isinstance(tree, dict) else {}
    inner = _replaced(branch.get(path[0], ABSENT), path[1:], value)
    if inner is ABSENT:
        branch.pop(path[0], None)
    else:
        branch[path[0]] = inner
    return branch or ABSENT


def _or_absent(value: Any) -> Any:
    return ABSENT if isinstance(value, dict) and not value else value


class ParameterCache:
    """Subscribed keys and their values; every method may be called from any thread."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._values: dict[str, Any] = {}
        self._early: dict[str, list[tuple[str, Any]]] = {}  # updates that overtook the answer

    def __contains__(self, key: str) -> bool:
        with self._lock:
            return key in self._values

    def keys(self) -> list[str]:
        """The subscribed keys."""
        with self._lock:
            return list(self._values)

    def begin(self, key: str) -> None:
        """Call before subscribeParam is sent: updates of `key` count from here."""
        with self._lock:
            self._values.setdefault(key, ABSENT)
            self._early[key] = []

    def start(self, key: str, value: Any) -> list[ParameterChange]:
        """Take the answer of subscribeParam; what overtook it is laid over it.

        Returns:
            The change against what was known before: none or one.
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

    def get(self, key: str) -> Any:
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

    def apply(self, key: str, value: Any) -> list[ParameterChange]:
        """Take an update from the master, or a value this node has set itself.

        Args:
            key: Changed key, with or without a trailing slash.
            value: Its value; `{}` or ABSENT when it was deleted.

        Returns:
            One change per subscription whose value is now another.
        """
        parts = _parts(key)
        if len(parts) > MOST_PARTS:
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
    def _change(subscribed: str, known: Any, key: str, value: Any) -> ParameterChange | None:
        mine, theirs = _parts(subscribed), _parts(key)
        if theirs[: len(mine)] == mine:
            new, old, changed = value, _below(known, theirs[len(mine) :]), key
        elif mine[: len(theirs)] == theirs:
            new, old, changed = _or_absent(_below(value, mine[len(theirs) :])), known, subscribed
        else:
            return None
        return None if same_value(old, new) else ParameterChange(subscribed, changed, new)

    @staticmethod
    def _laid_over(subscribed: str, known: Any, key: str, value: Any) -> Any:
        mine, theirs = _parts(subscribed), _parts(key)
        if theirs[: len(mine)] == mine:
            return _replaced(known, theirs[len(mine) :], value)
        if mine[: len(theirs)] == theirs:
            return _or_absent(_below(value, mine[len(theirs) :]))
        return known
