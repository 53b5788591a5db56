"""`node.params`: the parameter server as a mapping, with a local cache of subscribed keys.

Source: wiki.ros.org/ROS/Parameter Server API, wiki.ros.org/Parameter Server; rospy client.py get_param and
rosmaster paramserver.py where they are silent.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from typing import Any, TypeVar, overload

from rosproto.errors import MasterError, RosError
from rosproto.logs import get_logger
from rosproto.names import join
from rosproto.node.graph.master_client import MasterClient
from rosproto.node.graph.registrations import RegistrationCall, Registrations
from rosproto.node.options import callback_or_none
from rosproto.node.parameter_cache import ABSENT, ParameterCache, ParameterChange, canonical_key

logger = get_logger("rosproto.node")
T = TypeVar("T")
Callback = Callable[[str, Any], None]


class UnknownParameter(MasterError, KeyError):
    """The parameter is not set.

    Attributes:
        key: Resolved key.
    """

    def __init__(self, key: str, *, method: str = "getParam", uri: str = "") -> None:
        super().__init__(method, -1, f"parameter {key} is not set", uri=uri)
        self.key = key

    def __str__(self) -> str:
        return f"parameter {self.key} is not set on the master {self.uri}; node.params.names() lists what is"


class ParameterSubscription:
    """One `Parameters.subscribe`; its value follows the parameter server without asking it.

    Attributes:
        key: Resolved key.
    """

    def __init__(self, params: Parameters, key: str, callback: Callback | None) -> None:
        self._params = params
        self._callback = callback
        self.key = key

    @property
    def value(self) -> Any:
        """The current value; None if the parameter is not set. Do not modify it in place."""
        try:
            value = self._params._cache.get(self.key)
        except KeyError:
            return None  # closed
        return None if value is ABSENT else value

    def __enter__(self) -> ParameterSubscription:
        return self

    def __exit__(self, *exc_info: object) -> None:
        self.close()

    def close(self) -> None:
        """End the callbacks; the last subscription of a key in this node is unregistered."""
        self._params._unsubscribe(self)


class ParameterRegistration:
    """Registration of one subscribed key at the master (`registration.Registration`)."""

    kind = "parameter"

    def __init__(self, params: Parameters, key: str) -> None:
        self._params = params
        self._again = False
        self.name = key

    def registration_call(self) -> RegistrationCall:
        self._params._cache.begin(self.name)
        return RegistrationCall("subscribeParam", (self._params._own_uri(), self.name), self._subscribed)

    def _subscribed(self, value: object) -> None:
        changes = self._params._cache.start(self.name, value)
        if self._again:  # the first value is not a change
            self._params._tell(changes)
        self._again = True

    def unregister(self, master: MasterClient) -> int:
        return master.unsubscribe_param(self.name, self._params._own_uri())


class Parameters:
    """Parameters of the graph, as a mapping from key to value.

    Values are bool, int (32 bits), float, str, bytes, and lists and dicts of these; a dict is a namespace.
    A key may be global ("/a/b"), relative to the node's namespace ("b"), or private ("~b"). Every method
    asks the master, except `cached` and the result of `subscribe`.

        node.params["/speed"] = 0.5
        node.params.get("~rate", 10)
        "/speed" in node.params

    All methods raise MasterError, ConnectionLost or RosTimeout when the master refuses, is away, or is slow.
    """

    def __init__(
        self,
        master: MasterClient,
        registrations: Registrations,
        *,
        own_uri: Callable[[], str],
        resolve_name: Callable[[str], str],
    ) -> None:
        self._master = master
        self._registrations = registrations
        self._own_uri = own_uri
        self._resolve_name = resolve_name
        self._cache = ParameterCache()
        self._lock = threading.Lock()
        self._subscribing = threading.Lock()
        self._subscriptions: dict[str, tuple[ParameterRegistration, list[ParameterSubscription]]] = {}
        self._untold: deque[list[ParameterChange]] = deque()
        self._telling = threading.Lock()

    def __repr__(self) -> str:
        return f"<Parameters of {self._master.caller_id} at {self._master.uri}>"

    def __getitem__(self, key: str) -> Any:
        """Value of a parameter; a namespace gives a dict.

        Raises:
            UnknownParameter: It is not set (a KeyError, and a MasterError).
        """
        resolved = self._resolve(key)
        try:
            return self._master.get_param(resolved)
        except MasterError as error:
            if error.code != -1:
                raise
            raise UnknownParameter(resolved, uri=self._master.uri) from None

    @overload
    def get(self, key: str) -> Any | None: ...
    @overload
    def get(self, key: str, default: T) -> Any | T: ...
    def get(self, key: str, default: object = None) -> Any:
        """Value of a parameter, or `default` when it is not set."""
        try:
            return self[key]
        except UnknownParameter:
            return default

    def __setitem__(self, key: str, value: object) -> None:
        self.set(key, value)

    def set(self, key: str, value: object) -> None:
        """Set a parameter; a dict replaces the whole namespace.

        Raises:
            ValueError: The value, or something in it, cannot be stored as a parameter; the text names it.
        """
        resolved, plain = self._resolve(key), plain_value(value, key)
        if resolved == "/" and not isinstance(plain, dict):
            raise ValueError(f"the root namespace must be a dict, not a {type(value).__name__}")
        self._master.set_param(resolved, plain)
        # The master does not tell the node that did it (rosmaster paramserver.py).
        self._tell(self._cache.apply(resolved, plain))

    def __delitem__(self, key: str) -> None:
        self.delete(key)

    def delete(self, key: str) -> None:
        """Delete a parameter or a namespace.

        Raises:
            UnknownParameter: It is not set.
        """
        resolved = self._resolve(key)
        try:
            self._master.delete_param(resolved)
        except MasterError as error:
            if error.code != -1:
                raise
            raise UnknownParameter(resolved, method="deleteParam", uri=self._master.uri) from None
        self._tell(self._cache.apply(resolved, ABSENT))

    def __contains__(self, key: object) -> bool:
        return isinstance(key, str) and self.has(key)

    def has(self, key: str) -> bool:
        """True when the parameter, or a namespace of that name, is set."""
        return bool(self._master.has_param(self._resolve(key)))

    def search(self, key: str) -> str | None:
        """The nearest parameter of that name: in the node's own namespace, then upwards to the root.

        Args:
            key: Relative name ("robot_description"); a global one is looked at as it is.

        Returns:
            The full key found, or None.
        """
        if key.startswith("~"):
            raise ValueError(f"{key!r}: a private name belongs to one namespace and cannot be searched for")
        try:
            found = self._master.search_param(key)
        except MasterError as error:
            if error.code != -1:
                raise
            return None
        return str(found) or None

    def names(self) -> list[str]:
        """All keys of the parameter server, sorted."""
        return sorted(map(str, self._master.get_param_names()))

    def __iter__(self) -> Iterator[str]:
        return iter(self.names())

    def __len__(self) -> int:
        return len(self.names())

    def keys(self) -> list[str]:
        """As `names`."""
        return self.names()

    def subscribe(self, key: str, callback: Callback | None = None) -> ParameterSubscription:
        """Follow a parameter or a namespace; the `.value` of the subscription is kept up to date.

        After a restart of the master the subscription is made again and compared with what was known.

        Args:
            key: The parameter or namespace; it need not exist yet.
            callback: Called as `callback(key, value)` for every change from now on, in their order and never
                two at a time: with the key that changed (the subscribed one or one below) and its new value,
                None when it was deleted. Its thread is the slave API's, or that of a `set` in this node.
                ROS cannot tell an empty dict from a deleted parameter.

        Returns:
            The subscription; close it to end.
        """
        callback_or_none(callback, f"the callback of parameter {key}")
        resolved = self._resolve(key)
        subscription = ParameterSubscription(self, resolved, callback)
        with self._subscribing:  # nobody gets a subscription before its first value is there
            with self._lock:
                entry = self._subscriptions.get(resolved)
                if entry is not None:
                    entry[1].append(subscription)
                    return subscription
                registration = ParameterRegistration(self, resolved)
                self._subscriptions[resolved] = (registration, [subscription])
            try:
                self._registrations.add(registration)
            except BaseException:
                with self._lock:
                    self._subscriptions.pop(resolved, None)
                self._cache.forget(resolved)
                raise
        return subscription

    def _unsubscribe(self, subscription: ParameterSubscription) -> None:
        with self._lock:
            registration, others = self._subscriptions.get(subscription.key, (None, []))
            if registration is None or subscription not in others:
                return
            others.remove(subscription)
            if others:
                return
            del self._subscriptions[subscription.key]
        self._cache.forget(subscription.key)
        self._registrations.remove(registration)

    def cached(self, key: str, default: object = None) -> Any:
        """Value of a parameter without asking the master twice: the first call subscribes it."""
        resolved = self._resolve(key)
        try:
            value = self._cache.get(resolved)
        except KeyError:
            self.subscribe(resolved)
            value = self._cache.get(resolved)
        return default if value is ABSENT else value

    def _resolve(self, key: str) -> str:
        if key.startswith("/") and not key.strip("/"):
            return "/"
        return canonical_key(self._resolve_name(key))

    def on_update(self, key: str, value: object, trusted: bool = True) -> bool:
        """The slave API's paramUpdate: True when the key is subscribed.

        An update that did not come from the master's address is only a hint to ask the master.
        """
        key = canonical_key(key)
        if not self._concerns(key):
            return False
        if not trusted:
            try:
                value = self._master.get_param(key)
            except MasterError:
                value = ABSENT
            except RosError as error:
                logger.warning(
                    "! parameter %s: an update did not come from the master, which cannot be asked: %s",
                    key,
                    error,
                )
                return True
        self._tell(self._cache.apply(key, value))
        return True

    def _concerns(self, key: str) -> bool:
        below = key.rstrip("/") + "/"
        subscribed = self._cache.keys()
        return any(k == key or key.startswith(k.rstrip("/") + "/") or k.startswith(below) for k in subscribed)

    def _tell(self, changes: list[ParameterChange]) -> None:
        """Call the callbacks, in order, one thread at a time, no lock held that a callback could need."""
        if changes:
            self._untold.append(changes)
        while self._untold and self._telling.acquire(blocking=False):
            try:
                while self._untold:
                    for change in self._untold.popleft():
                        self._call_back(change)
            finally:
                self._telling.release()

    def _call_back(self, change: ParameterChange) -> None:
        with self._lock:
            subscriptions = list(self._subscriptions.get(change.subscribed, (None, ()))[1])
        value = None if change.value is ABSENT else change.value
        for subscription in subscriptions:
            if subscription._callback is None:
                continue
            try:
                subscription._callback(change.key, value)
            except Exception:
                logger.exception("callback of parameter %s", change.subscribed)


def leaves(key: str, value: object) -> Iterator[tuple[str, object]]:
    """The parameters of a value: those of a dict one by one, so that setting them keeps what else is there.

    As rosparam does it: a name with a leading slash is global, and an empty dict has no parameters.

    Raises:
        ValueError: A name is not a string.
    """
    if not isinstance(value, dict):
        yield key, value
        return
    for name, item in value.items():
        if not isinstance(name, str) or not name or name.startswith("~"):
            raise ValueError(
                f"parameter {key}: {name!r} is not a key; keys are strings: quote a number or yes and no, "
                "and write the node's name for ~"
            )
        yield from leaves(join(key, name), item)


def plain_value(value: object, key: str, *, in_list: bool = False) -> object:
    """`value` as XML-RPC can carry it: numpy scalars and arrays, tuples and mappings made plain.

    Args:
        value: Any value.
        key: The parameter, for the text of an error.
        in_list: A dict in a list is a value, not a namespace, and may have any strings as keys.

    Raises:
        ValueError: Something in it cannot be stored as a parameter.
    """
    if isinstance(value, (bool, float, str, bytes)):
        return value
    if isinstance(value, int):
        if not -(1 << 31) <= value < 1 << 31:
            raise ValueError(f"parameter {key}: {value} does not fit in 32 bits; use a float or a string")
        return int(value)
    if isinstance(value, Mapping):
        return {
            _plain_key(k, key, in_list): plain_value(v, f"{key.rstrip('/')}/{k}", in_list=in_list)
            for k, v in value.items()
        }
    if isinstance(value, (list, tuple)):
        return [plain_value(item, f"{key}[{index}]", in_list=True) for index, item in enumerate(value)]
    if hasattr(value, "tolist"):  # a numpy scalar or array
        return plain_value(value.tolist(), key, in_list=in_list)
    raise ValueError(f"parameter {key}: a {type(value).__name__} cannot be stored as a parameter")


def _plain_key(name: object, key: str, in_list: bool) -> str:
    if not isinstance(name, str) or not (in_list or (name and "/" not in name)):
        raise ValueError(
            f"parameter {key}: {name!r} is not a key; keys are strings without '/', nest dicts instead"
        )
    return name
