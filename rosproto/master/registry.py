"""The graph of a master: publishers, subscribers, services. Without sockets, threads or clocks.

Every method returns an `Answer`: the status triple of the Master API (wiki.ros.org/ROS/Master_API) and the
resulting notifications. Texts and status codes are rosmaster's (rosmaster/registrations.py and master_api.py
of ros_comm), because tools print them and people search for them. The caller validates names and URIs
(`validation.py`).

Intended differences from rosmaster:

- A node that registers under a new URI loses all earlier registrations, and the subscribers of its topics are
  notified. rosmaster notifies nobody, and their links to the dead publisher remain.
- A node that was shut down because of its name cannot take the name back by a parameter subscription. roscpp,
  asked to end, writes a log line, which reads a cached parameter, which subscribes under the old URI;
  rosmaster then ends the new node as well.
- A node whose only service was taken over by another node is removed. rosmaster keeps it for ever.
- The number of registrations and of remembered types of vanished topics is limited.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import NamedTuple

from rosproto.master.notifications import Notification, PublisherUpdate, Shutdown

ANY_TYPE = "*"
FAILURE, SUCCESS, ERROR = 0, 1, -1

# getTopicTypes keeps returning the types of topics without nodes, as rosmaster does
# (`rostopic type` of a topic that was just closed), up to this number.
MAX_RETIRED_TYPES = 10_000
MAX_EVICTED = 1_000  # nodes remembered as shut down


class Answer(NamedTuple):
    """A status triple and the resulting notifications.

    Attributes:
        code: 1 success, 0 failure, -1 caller's error.
        text: For people.
        value: Depends on the method; a documented default if `code` is not 1.
        notifications: To be sent, in this order.
    """

    code: int
    text: str
    value: object
    notifications: tuple[Notification, ...] = ()

    @property
    def triple(self) -> list[object]:
        """The reply as it is sent."""
        return [self.code, self.text, self.value]


@dataclass(slots=True, eq=False)
class _Node:
    """One registered name: its URI and its registrations, (kind, key), in their order."""

    name: str
    uri: str
    held: dict[tuple[Registrations, str], None] = field(default_factory=dict)

    def keys(self, kind: Registrations) -> frozenset[str]:
        return frozenset(key for held_kind, key in self.held if held_kind is kind)


class Registrations:
    """Registrations of one kind: key (topic, service or parameter) -> nodes, in order of registration.

    Attributes:
        providers: key -> {(node name, node URI): None}; keys without nodes are absent.
    """

    __slots__ = ("providers",)

    def __init__(self) -> None:
        self.providers: dict[str, dict[tuple[str, str], None]] = {}

    def add(self, key: str, name: str, uri: str) -> None:
        self.providers.setdefault(key, {})[name, uri] = None

    def remove(self, key: str, name: str, uri: str) -> bool:
        """Remove one registration; True if there was one."""
        entries = self.providers.get(key)
        if entries is None or (name, uri) not in entries:
            return False
        del entries[name, uri]
        if not entries:
            del self.providers[key]
        return True

    def uris(self, key: str) -> tuple[str, ...]:
        return tuple(uri for _, uri in self.providers.get(key, ()))

    def state(self) -> list[list[object]]:
        """Rows of getSystemState: [key, [node name, ...]]."""
        return [[key, [name for name, _ in entries]] for key, entries in self.providers.items()]


class Registry:
    """The graph. Not thread-safe: the caller holds a lock around every method.

    Args:
        capacity: Most registrations of all kinds together; more are refused with status 0.
    """

    def __init__(self, *, capacity: int = 200_000) -> None:
        self.capacity = capacity
        self.publishers = Registrations()
        self.subscribers = Registrations()
        self.services = Registrations()
        self.param_subscribers = Registrations()
        self._service_uris: dict[str, tuple[str, str]] = {}  # service -> (node name, rosrpc URI)
        self._types: dict[str, str] = {}
        self._retired: dict[str, None] = {}  # topics with a type and without nodes, oldest first
        self._nodes: dict[str, _Node] = {}
        self._at: dict[str, dict[str, None]] = {}  # host:port -> node names there
        self._evicted: dict[tuple[str, str], None] = {}  # (node name, URI) that were shut down, oldest first
        self._count = 0

    # -- topics ------------------------------------------------------------------------------------------

    def register_publisher(self, name: str, topic: str, type_name: str, uri: str) -> Answer:
        """Add a publisher; the value is the list of subscriber URIs, each of which is notified."""
        if self._full(name, self.publishers, topic, uri):
            return self._refusal([])
        notes = self._register(self.publishers, topic, name, uri)
        # '*' must not overwrite a known type, but a publisher's concrete type replaces an older one.
        if type_name != ANY_TYPE or topic not in self._types:
            self._types[topic] = type_name
        notes += self._publisher_updates([topic])
        text = f"Registered [{name}] as publisher of [{topic}]"
        return Answer(SUCCESS, text, list(self.subscribers.uris(topic)), tuple(notes))

    def unregister_publisher(self, name: str, topic: str, uri: str) -> Answer:
        """Remove a publisher; the value is 1 if it was one, and its subscribers are notified."""
        answer = self._unregister(self.publishers, topic, name, uri)
        if not answer.value:
            return answer
        self._keep_types([topic])
        return answer._replace(notifications=tuple(self._publisher_updates([topic])))

    def register_subscriber(self, name: str, topic: str, type_name: str, uri: str) -> Answer:
        """Add a subscriber; the value is the list of publisher URIs."""
        if self._full(name, self.subscribers, topic, uri):
            return self._refusal([])
        notes = self._register(self.subscribers, topic, name, uri)
        if type_name != ANY_TYPE:
            self._types.setdefault(topic, type_name)
        return Answer(SUCCESS, f"Subscribed to [{topic}]", list(self.publishers.uris(topic)), tuple(notes))

    def unregister_subscriber(self, name: str, topic: str, uri: str) -> Answer:
        """Remove a subscriber; the value is 1 if it was one."""
        answer = self._unregister(self.subscribers, topic, name, uri)
        self._keep_types([topic])
        return answer

    # -- services ----------------------------------------------------------------------------------------

    def register_service(self, name: str, service: str, service_uri: str, uri: str) -> Answer:
        """Make this node the only provider of a service; a previous provider is replaced."""
        if self._full(name, self.services, service, uri):
            return self._refusal(0)
        notes = self._register(self.services, service, name, uri)
        for former in [entry for entry in self.services.providers[service] if entry != (name, uri)]:
            self._drop(self.services, service, *former)
        self._service_uris[service] = (name, service_uri)
        return Answer(SUCCESS, f"Registered [{name}] as provider of [{service}]", 1, tuple(notes))

    def unregister_service(self, name: str, service: str, service_uri: str) -> Answer:
        """Remove a service; ignored (value 0) unless `service_uri` is this node's current one."""
        node = self._nodes.get(name)
        if node is None:
            return Answer(SUCCESS, f"[{name}] is not a registered node", 0)
        if self._service_uris.get(service) != (name, service_uri):
            text = f"[{service_uri}] is no longer the current service api handle for [{service}]"
            return Answer(SUCCESS, text, 0)
        del self._service_uris[service]
        self._drop(self.services, service, name, node.uri)
        return Answer(SUCCESS, f"Unregistered [{name}] as provider of [{service}]", 1)

    def lookup_service(self, service: str) -> Answer:
        """The rosrpc URI of a service; "" (status -1) if it has no provider."""
        found = self._service_uris.get(service)
        if found is None:
            return Answer(ERROR, "no provider", "")
        return Answer(SUCCESS, f"rosrpc URI: [{found[1]}]", found[1])

    # -- parameter subscriptions (values live in `parameters.py`) --------------------------------------------

    def subscribe_param(self, name: str, key: str, uri: str) -> Answer:
        """Add a subscription of `key` (in the form of `parameters.subscription_key`)."""
        if self._full(name, self.param_subscribers, key, uri):
            return self._refusal(0)
        if (name, uri) in self._evicted and name in self._nodes:
            return Answer(SUCCESS, "", 0)  # it is shutting down, see above: reply, but do not add it
        notes = self._register(self.param_subscribers, key, name, uri)
        return Answer(SUCCESS, "", 0, tuple(notes))

    def unsubscribe_param(self, name: str, key: str, uri: str) -> Answer:
        """Remove a subscription; the value is 1 if there was one."""
        return self._unregister(self.param_subscribers, key, name, uri)

    # -- questions ---------------------------------------------------------------------------------------

    def lookup_node(self, name: str) -> Answer:
        """XML-RPC URI of a node; "" (status -1) if unknown."""
        node = self._nodes.get(name)
        if node is None:
            return Answer(ERROR, f"unknown node [{name}]", "")
        return Answer(SUCCESS, "node api", node.uri)

    def published_topics(self, subgraph: str) -> Answer:
        """[topic, type] of every topic with a publisher, below `subgraph` ("" for all)."""
        if subgraph and not subgraph.endswith("/"):
            subgraph += "/"
        rows = [[t, self._types[t]] for t in self.publishers.providers if t.startswith(subgraph)]
        return Answer(SUCCESS, "current topics", rows)

    def topic_types(self) -> Answer:
        """[topic, type] of every topic whose type was ever registered, also without publishers now."""
        return Answer(SUCCESS, "current system state", [list(row) for row in self._types.items()])

    def system_state(self) -> Answer:
        """[publishers, subscribers, services], each with rows [name, [node, ...]]."""
        kinds = (self.publishers, self.subscribers, self.services)
        return Answer(SUCCESS, "current system state", [kind.state() for kind in kinds])

    def names_at(self, uri: str) -> list[str]:
        """Names of the nodes registered with this URI (compared by host and port; wire.md, fact 28)."""
        return list(self._at.get(_endpoint(uri), ()))

    def __len__(self) -> int:
        """Number of registrations of all kinds."""
        return self._count

    # -- inside ------------------------------------------------------------------------------------------

    def _full(self, name: str, kind: Registrations, key: str, uri: str) -> bool:
        return self._count >= self.capacity and (name, uri) not in kind.providers.get(key, ())

    def _refusal(self, value: object) -> Answer:
        return Answer(FAILURE, f"the master holds {self._count} registrations and takes no more", value)

    def _register(self, kind: Registrations, key: str, name: str, uri: str) -> list[Notification]:
        """Add one registration; return the notifications if the name was registered elsewhere before."""
        node = self._nodes.get(name)
        notes: list[Notification] = []
        if node is None or node.uri != uri:
            if node is not None:
                notes = self._remove_predecessor(node)
            node = self._nodes[name] = _Node(name, uri)
            self._at.setdefault(_endpoint(uri), {})[name] = None
        self._evicted.pop((name, uri), None)
        if (kind, key) not in node.held:
            node.held[kind, key] = None
            self._count += 1
        kind.add(key, name, uri)
        if kind is self.publishers or kind is self.subscribers:
            self._retired.pop(key, None)
        return notes

    def _remove_predecessor(self, node: _Node) -> list[Notification]:
        """Remove a node whose name is taken over: shut it down, notify its subscribers."""
        published, subscribed = node.keys(self.publishers), node.keys(self.subscribers)
        reason = f"[{node.name}] Reason: new node registered with same name"
        notes: list[Notification] = [Shutdown(node.uri, node.name, reason, published, subscribed)]
        for kind, key in list(node.held):
            if kind is self.services:
                self._service_uris.pop(key, None)
            self._drop(kind, key, node.name, node.uri)
        self._keep_types(published | subscribed)
        self._evicted[node.name, node.uri] = None
        if len(self._evicted) > MAX_EVICTED:
            del self._evicted[next(iter(self._evicted))]
        return notes + self._publisher_updates(sorted(published))

    def _unregister(self, kind: Registrations, key: str, name: str, uri: str) -> Answer:
        if name not in self._nodes:
            return Answer(SUCCESS, f"[{name}] is not a registered node", 0)
        if not self._drop(kind, key, name, uri):
            return Answer(SUCCESS, f"[{name}] is not a known provider of [{key}]", 0)
        return Answer(SUCCESS, f"Unregistered [{name}] as provider of [{key}]", 1)

    def _drop(self, kind: Registrations, key: str, name: str, uri: str) -> bool:
        """Remove one registration, and the node with its last one."""
        if not kind.remove(key, name, uri):
            return False
        self._count -= 1
        node = self._nodes[name]
        del node.held[kind, key]
        if not node.held:
            del self._nodes[name]
            endpoint = _endpoint(node.uri)
            del self._at[endpoint][name]
            if not self._at[endpoint]:
                del self._at[endpoint]
        return True

    def _publisher_updates(self, topics: Iterable[str]) -> list[Notification]:
        notes: list[Notification] = []
        for topic in topics:
            publishers = self.publishers.uris(topic)
            # A process with several node names subscribes once per name; it is notified once.
            for uri in dict.fromkeys(self.subscribers.uris(topic)):
                notes.append(PublisherUpdate(uri, topic, publishers))
        return notes

    def _keep_types(self, topics: Iterable[str]) -> None:
        """Remember the types of topics without nodes, and forget the oldest beyond the limit."""
        for topic in topics:
            used = topic in self.publishers.providers or topic in self.subscribers.providers
            if topic in self._types and not used:
                self._retired[topic] = None
        while len(self._retired) > MAX_RETIRED_TYPES:
            oldest = next(iter(self._retired))
            del self._retired[oldest], self._types[oldest]


def _endpoint(uri: str) -> str:
    """Host and port of a URI, for comparing: `http://Robot:1/` and `http://robot:1` are the same."""
    return uri.partition("://")[2].partition("/")[0].lower()
