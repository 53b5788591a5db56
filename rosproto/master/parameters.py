"""The parameter server's tree, without sockets or threads (wiki.ros.org/Parameter%20Server).

A key is a path in a tree of dicts: `/a/b` is entry "b" of the dict at `/a`. Reading a namespace gives the
dict below it; writing a dict replaces everything below. Dict keys that contain "/" are kept, as in rosmaster:
they are returned in the dict and cannot be reached by name.

The tree is copied on write along the written path, so a value that was returned never changes: it can be
encoded outside any lock, without a deep copy.

Notifications follow rosmaster's `compute_param_updates` (paramserver.py), keys with a trailing slash and `{}`
for "deleted" included. One addition: subscribers below a namespace that is replaced by a plain value are
notified of the deletion.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from rosproto.master.notifications import ParamUpdate

Subscribers = Mapping[str, Mapping[tuple[str, str], None]]

_INT_MIN, _INT_MAX = -(1 << 31), (1 << 31) - 1
_ENTRY_BYTES = 64  # approximate memory of one value or dict entry


def subscription_key(key: str) -> str:
    """The form of `key` in subscriptions and updates: with a trailing slash."""
    return "/" + "".join(f"{part}/" for part in key.split("/") if part)


class Displaced(NamedTuple):
    """A value that another one replaces, and its approximate size in bytes."""

    value: object
    size: int


class ParameterTree:
    """Values and their subscribers. The caller holds a lock around every method that does not say otherwise.

    Args:
        subscribers: Live view: subscription key -> {(node name, node URI): None}.
        max_bytes: Approximate size of all values together.
        max_depth: Nesting of the tree; deeper values could not be sent within `Limits.xml_depth`.
    """

    def __init__(
        self, subscribers: Subscribers | None = None, *, max_bytes: int = 256 << 20, max_depth: int = 60
    ) -> None:
        self.max_bytes = max_bytes
        self.max_depth = max_depth
        self._subscribers: Subscribers = {} if subscribers is None else subscribers
        self._root: dict[str, object] = {}
        self._bytes = _ENTRY_BYTES

    def get(self, key: str) -> object:
        """Value or subtree at a resolved key.

        Raises:
            KeyError: Nothing is set there.
        """
        value: object = self._root
        for part in _parts(key):
            if not isinstance(value, dict):
                raise KeyError(key)
            value = value[part]
        return value

    def has(self, key: str) -> bool:
        """Whether `get` would succeed."""
        try:
            self.get(key)
        except KeyError:
            return False
        return True

    def weigh(self, key: str, value: object) -> int:
        """The approximate size of a value in bytes; needs no lock, and takes long for a large one.

        Raises:
            ValueError: The value cannot be returned later (nil, int beyond 32 bits), or is nested too deeply.
        """
        depth = len(_parts(key))
        if depth > self.max_depth:
            raise ValueError("is nested too deeply")
        return _checked_size(value, self.max_depth - depth)

    def displaced(self, key: str) -> Displaced:
        """What `set` or `delete` would take away; needs no lock, and takes long for a large value."""
        value: object = self._root
        for part in _parts(key):
            if not isinstance(value, dict):
                break
            if part not in value:
                return _NOTHING
            value = value[part]
        return _NOTHING if value is self._root else Displaced(value, _checked_size(value))

    def set(
        self,
        key: str,
        value: object,
        caller_id: str | None = None,
        *,
        weight: int | None = None,
        displaced: Displaced | None = None,
    ) -> list[ParamUpdate]:
        """Store a value; a dict replaces the whole subtree.

        Args:
            key: Resolved key; "/" replaces the whole tree and needs a dict.
            value: Any value that XML-RPC can return; owned by the tree from now on.
            caller_id: The node that sets it; it is not notified about this key and those above.
            weight: The result of `weigh`, if it was called before.
            displaced: The same for `displaced`. If another value is there by now, it is weighed here.

        Raises:
            TypeError: The root is set to something else than a dict.
            ValueError: The value cannot be returned later (nil, int beyond 32 bits), is nested too deeply, or
                the tree is full.
        """
        parts = _parts(key)
        if weight is None:
            weight = self.weigh(key, value)
        below = self.has(key) and isinstance(self.get(key), dict)
        if parts:
            root, growth = _replaced(self._root, parts, value, weight, displaced or _NOTHING)
        elif isinstance(value, dict):
            root, growth = value, weight - self._bytes
        else:
            raise TypeError("cannot set root of parameter tree to non-dictionary")
        if growth > 0 and self._bytes + growth > self.max_bytes:
            raise ValueError(f"holds {growth} bytes, but the parameter server is full ({self.max_bytes})")
        self._root = root
        self._bytes += growth
        return self._updates(key, value, caller_id, below=below)

    def delete(self, key: str, *, displaced: Displaced | None = None) -> list[ParamUpdate]:
        """Remove a value or subtree; all subscribers are notified, the caller included.

        Args:
            key: Resolved key.
            displaced: As for `set`.

        Raises:
            KeyError: Nothing is set there, or it is the root.
        """
        parts = _parts(key)
        if not parts or not self.has(key):
            raise KeyError(key)
        self._root, growth = _replaced(self._root, parts, _DELETED, 0, displaced or _NOTHING)
        self._bytes += growth
        return self._updates(key, {}, None, below=True)

    def search(self, namespace: str, key: str) -> str | None:
        """Find `key` upwards from `namespace`, usually a node name.

        Only the first part of `key` has to exist: searching "robot_description/arm" finds the nearest
        "robot_description" and returns the key below it, set or not.

        Raises:
            ValueError: `key` is empty or private, or `namespace` is not global.
        """
        if not key or key.startswith("~"):
            raise ValueError("invalid key")
        if not namespace.startswith("/"):
            raise ValueError("namespace must be global")
        if key.startswith("/"):
            return key if self.has(key) else None
        first = key.split("/")[0]
        spaces = _parts(namespace)[: self.max_depth]
        for depth in range(len(spaces), -1, -1):
            base = "".join(f"/{part}" for part in spaces[:depth])
            if self.has(f"{base}/{first}"):
                return f"{base}/{key}"
        return None

    def names(self) -> list[str]:
        """Keys of all values that are not namespaces; needs no lock."""
        return list(_leaves("/", self._root))

    def _updates(self, key: str, value: object, ignore: str | None, *, below: bool) -> list[ParamUpdate]:
        """Updates for `key` changing to `value` (`{}`: deleted); `below`: also for the keys below it."""
        if not self._subscribers:
            return []
        changed = subscription_key(key)
        updates = [
            ParamUpdate(uri, changed, value)
            for above in _ancestor_keys(changed)
            for name, uri in self._subscribers.get(above, ())
            if name != ignore
        ]
        if below or isinstance(value, dict):
            for subscribed, nodes in self._subscribers.items():
                if subscribed != changed and subscribed.startswith(changed):
                    new = _below(value, subscribed[len(changed) :])
                    updates += [ParamUpdate(uri, subscribed, new) for _, uri in nodes]
        return updates


_DELETED = object()
_NOTHING = Displaced(_DELETED, 0)


def _parts(key: str) -> list[str]:
    return [part for part in key.split("/") if part]


def _ancestor_keys(subscribed: str) -> Iterator[str]:
    """Subscription keys of a key and all above it: `/a/b/`, `/a/`, `/`."""
    yield subscribed
    while subscribed != "/":
        subscribed = subscribed[: subscribed.rindex("/", 0, -1) + 1]
        yield subscribed


def _below(value: object, path: str) -> object:
    """The part of a new value at a relative path; `{}`, which means deleted, if there is none."""
    for part in _parts(path):
        if not isinstance(value, dict) or part not in value:
            return {}
        value = value[part]
    return value


def _leaves(prefix: str, tree: dict[str, object]) -> Iterator[str]:
    for name, value in tree.items():
        if isinstance(value, dict):
            yield from _leaves(f"{prefix}{name}/", value)
        else:
            yield prefix + name


def _replaced(
    tree: dict[str, object], parts: list[str], value: object, weight: int, displaced: Displaced
) -> tuple[dict[str, object], int]:
    """A copy of `tree` with one entry changed or removed, and the growth in bytes.

    A plain value on the path becomes a namespace, as in rosmaster. Recursion is bounded by the tree's depth.
    """

    def size_of(item: object) -> int:
        return displaced.size if item is displaced.value else _checked_size(item)

    head, rest = parts[0], parts[1:]
    copy = dict(tree)
    growth = 0 if head in tree else _ENTRY_BYTES + len(head)
    if rest:
        child = tree.get(head)
        if not isinstance(child, dict):
            growth += _ENTRY_BYTES - (size_of(child) if head in tree else 0)
            child = {}
        copy[head], more = _replaced(child, rest, value, weight, displaced)
        return copy, growth + more
    former = size_of(tree[head]) if head in tree else 0
    if value is _DELETED:
        del copy[head]
        return copy, -former - _ENTRY_BYTES - len(head)
    copy[head] = value
    return copy, growth + weight - former


def _checked_size(value: object, depth: int = 1 << 30) -> int:
    """Approximate size of a value in bytes; also checks it.

    Raises:
        ValueError: It is nested deeper than `depth`, or could not be returned over XML-RPC.
    """
    total = 0
    todo = [(value, depth)]
    while todo:
        item, left = todo.pop()
        total += _ENTRY_BYTES
        if isinstance(item, (dict, list, tuple)):
            if left <= 0:
                raise ValueError("is nested too deeply")
            if isinstance(item, dict):
                total += sum(_ENTRY_BYTES + len(name) for name in item)
                item = item.values()
            todo += [(inner, left - 1) for inner in item]
        else:
            total += _weigh_plain(item)
    return total


def _weigh_plain(item: object) -> int:
    if item is None:
        raise ValueError("holds nil, which XML-RPC cannot carry back")
    # rosmaster stores such a number, and then every getParam of it is a Fault.
    if isinstance(item, int) and not _INT_MIN <= item <= _INT_MAX:
        raise ValueError(f"holds {item}, but XML-RPC integers have 32 bits; use a string or a double")
    return len(item) if isinstance(item, (str, bytes, bytearray)) else 0
