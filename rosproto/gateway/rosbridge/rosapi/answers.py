"""`Rosapi`: the table of the services of /rosapi; and `provide`, which registers them in ROS.

Requests and responses are JSON values by the fields of their definitions (msgdefs/rosapi). Every request
field is a string.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, NamedTuple

from rosproto.codec import Message, ServiceType, service_class
from rosproto.errors import MasterError, RosError, ServiceError
from rosproto.gateway.access import Access
from rosproto.gateway.rosbridge.rosapi.graph import RosapiError, VisibleGraph
from rosproto.gateway.rosbridge.rosapi.parameters import VisibleParameters
from rosproto.gateway.rosbridge.rosapi.types import Definitions
from rosproto.gateway.values import from_values
from rosproto.msg import bundled
from rosproto.node import Node
from rosproto.node.services.server import ServiceServer
from rosproto.transport.deadline import Deadline

NAMESPACE = "/rosapi"
CALL_SECONDS = 10.0
MAX_TEXT_CHARACTERS = 1 << 20  # characters of one field; enough for a robot_description

Values = dict[str, object]


class _Entry(NamedTuple):
    """One service: the name of its type, and the function that answers it.

    The function takes the request's fields by position, and then the deadline if it `waits`. It returns the
    response's only field, or a tuple of its fields.
    """

    type: str
    answer: Callable[..., Any]
    waits: bool = True


class Rosapi:
    """Answers the services of /rosapi within the rules of an `Access`. Thread-safe.

    `call` blocks until the master and other nodes reply: call it in a thread that may wait.

    Args:
        node: Calls the master and other nodes; it is listed as the provider of the services.
        access: What clients may see and write.
        timeout: Seconds for one call.

    Attributes:
        services: name -> type of those that are not denied: "/rosapi/topics" -> "rosapi/Topics".
    """

    def __init__(self, node: Node, access: Access, *, timeout: float = CALL_SECONDS) -> None:
        self._node = node
        self._timeout = timeout
        self._raw_types_turn = threading.Lock()
        self._definitions = Definitions(node, access)
        self.services: dict[str, str] = {}
        self._graph = VisibleGraph(node, access, self.services)
        self._table = self._entries(VisibleParameters(node, access))
        self.services.update(
            (service, f"rosapi/{entry.type}")
            for name, entry in self._table.items()
            if access.denied("service", service := f"{NAMESPACE}/{name}") is None
        )

    def answers(self, service: str) -> bool:
        """Whether this service is one of them; "rosapi/topics" means "/rosapi/topics"."""
        return f"{NAMESPACE}/{_local_name(service)}" in self.services

    def call(self, service: str, args: object = None) -> Values:
        """Answer one call.

        Args:
            service: Name of the service.
            args: The request: a dict by field, a list by position, or None. Missing fields are "".

        Returns:
            The fields of the response, as JSON values.

        Raises:
            RosapiError: It is refused or failed; the text is for the client.
        """
        if not self.answers(service):
            raise RosapiError(f"service {service} is not one of {NAMESPACE}")
        entry = self._table[_local_name(service)]
        fields = _fields(entry.type, args)
        deadline = (Deadline(self._timeout),) if entry.waits else ()
        try:
            answer = entry.answer(*fields.values(), *deadline)
        except RosapiError:
            raise
        except (RosError, ValueError) as error:
            raise RosapiError(f"{NAMESPACE}/{_local_name(service)}: {error}") from error
        names = [field.name for field in bundled().service(f"rosapi/{entry.type}").response.fields]
        return dict(zip(names, (answer,) if len(names) == 1 else answer, strict=True))

    def _entries(self, parameters: VisibleParameters) -> dict[str, _Entry]:
        graph, named, details = self._graph, self._named, self._definitions.service_details
        request, response = partial(details, half="request"), partial(details, half="response")
        return {
            "topics": _Entry("Topics", self._topics),
            "topics_for_type": _Entry("TopicsForType", graph.topics_for_type),
            "topics_and_raw_types": _Entry("TopicsAndRawTypes", self._raw_types),
            "topic_type": _Entry("TopicType", named(lambda topic, d: graph.topics(d).get(topic, ""))),
            "publishers": _Entry("Publishers", named(graph.publishers)),
            "subscribers": _Entry("Subscribers", named(graph.subscribers)),
            "services": _Entry("Services", graph.services),
            "services_for_type": _Entry("ServicesForType", graph.services_for_type),
            "service_type": _Entry("ServiceType", named(graph.service_type)),
            "service_providers": _Entry("ServiceProviders", graph.service_providers),
            "service_node": _Entry("ServiceNode", named(graph.service_node)),
            "service_host": _Entry("ServiceHost", named(graph.service_host)),
            "nodes": _Entry("Nodes", graph.nodes),
            "node_details": _Entry("NodeDetails", named(graph.node_details)),
            "action_servers": _Entry("GetActionServers", graph.action_servers),
            "message_details": _Entry("MessageDetails", self._definitions.message_details, waits=False),
            "service_request_details": _Entry("ServiceRequestDetails", request, waits=False),
            "service_response_details": _Entry("ServiceResponseDetails", response, waits=False),
            "get_param": _Entry("GetParam", parameters.get, waits=False),
            "set_param": _Entry("SetParam", parameters.set, waits=False),
            "has_param": _Entry("HasParam", parameters.has, waits=False),
            "search_param": _Entry("SearchParam", parameters.search, waits=False),
            "delete_param": _Entry("DeleteParam", parameters.delete, waits=False),
            "get_param_names": _Entry("GetParamNames", parameters.names, waits=False),
            "get_time": _Entry("GetTime", self._time, waits=False),
        }

    def _named(self, answer: Callable[[str, Deadline], object]) -> Callable[[str, Deadline], object]:
        """The answer for the resolved name, which is compared with the patterns."""
        return lambda name, deadline: answer(self._node.resolve_name(name) if name else name, deadline)

    def _topics(self, deadline: Deadline) -> tuple[object, ...]:
        topics = self._graph.topics(deadline)
        return list(topics), list(topics.values())

    def _raw_types(self, deadline: Deadline) -> tuple[object, ...]:
        # One at a time: sixty threads that make texts leave the server's loop a sixtieth of the interpreter.
        if not self._raw_types_turn.acquire(timeout=deadline.remaining() or 0.0):
            raise deadline.error("the answers to other clients")
        try:
            topics = self._graph.topics(deadline)
            texts = {
                kind: self._definitions.full_text(kind, deadline) for kind in set(topics.values()) if kind
            }
        finally:
            self._raw_types_turn.release()
        return list(topics), list(topics.values()), [texts.get(kind, "") for kind in topics.values()]

    def _time(self) -> Values:
        now = self._node.clock.now()
        return {"secs": now.secs, "nsecs": now.nsecs}


def _local_name(service: str) -> str:
    head, _, name = service.lstrip("/").partition("/")
    return name if f"/{head}" == NAMESPACE else ""


def _fields(type_name: str, args: object) -> dict[str, str]:
    """All fields of a request, as strings; missing ones are ""."""
    request = bundled().service(f"rosapi/{type_name}").request
    names = [field.name for field in request.fields]
    fields = dict.fromkeys(names, "")
    for name, value in _given(type_name, names, args).items():
        if name not in names:
            raise RosapiError(
                f"rosapi/{type_name} has no field {str(name)[:80]!r}; its request has {names or 'no fields'}"
            )
        if not isinstance(value, str):
            raise RosapiError(f"rosapi/{type_name}.{name}: expected a string, got a {type(value).__name__}")
        if len(value) > MAX_TEXT_CHARACTERS:
            raise RosapiError(
                f"rosapi/{type_name}.{name}: {len(value)} characters; expected at most {MAX_TEXT_CHARACTERS}"
            )
        fields[name] = value
    return fields


def _given(type_name: str, names: list[str], args: object) -> Mapping[str, object]:
    if args is None:
        return {}
    if isinstance(args, Mapping):
        return args
    if isinstance(args, (list, tuple)):
        return dict(zip(names, args))  # as in the original: too many are ignored  # noqa: B905
    raise RosapiError(
        f"rosapi/{type_name}: the arguments are a {type(args).__name__}, expected an object or a list"
    )


class ProvidedRosapi:
    """The registered services of /rosapi; close this, or the node, to unregister them."""

    def __init__(self, servers: list[ServiceServer]) -> None:
        self._servers = servers

    def __enter__(self) -> ProvidedRosapi:
        return self

    def __exit__(self, *exc_info: object) -> None:
        self.close()

    def close(self) -> None:
        """Unregister them; may be called again."""
        while self._servers:
            self._servers.pop().close()


def provide(node: Node, rosapi: Rosapi) -> ProvidedRosapi:
    """Register all services of /rosapi at the master, with the answers for web clients.

    Raises:
        MasterError, ConnectionLost, RosTimeout: A service could not be registered.
        ServiceError: Another node provides /rosapi; this one would take over its services.
    """
    try:
        node.master.lookup_service("/rosapi/topics")
    except MasterError as error:
        if error.code != -1:
            raise
    else:
        raise ServiceError(
            "/rosapi/topics", "another node already provides it; end that one, or leave /rosapi to it"
        )
    servers: list[ServiceServer] = []
    try:
        with node.batch():
            for name, type_name in rosapi.services.items():
                kind = service_class(type_name)
                servers.append(node.service_server(name, kind, partial(_answer, rosapi, name, kind)))
    except BaseException:
        for server in servers:
            server.close()
        raise
    return ProvidedRosapi(servers)


def _answer(rosapi: Rosapi, name: str, kind: type[ServiceType], request: Message) -> Message:
    values = rosapi.call(name, {field: getattr(request, field) for field in kind.Request.__slots__})
    return from_values(kind._response_class, values)
