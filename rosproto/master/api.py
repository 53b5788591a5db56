"""The Master API and Parameter Server API as one dispatch function, without sockets.

Registry and parameters share one lock. Every notification is passed to `post` with the lock held, so that
notifications leave in the order of the calls that caused them.

Replies have rosmaster's shapes, status codes and texts. Invalid arguments are treated as in rosmaster
(`apivalidate` in master_api.py): status -1 with a default value of the right type. Only an unknown method is
a Fault.

Source: wiki.ros.org/ROS/Master_API.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Sequence
from typing import NamedTuple

from rosproto.logs import PeerLog, get_logger
from rosproto.master import validation as v
from rosproto.master.notifications import Notification
from rosproto.master.parameters import Displaced, ParameterTree, subscription_key
from rosproto.master.registry import ERROR, FAILURE, SUCCESS, Answer, Registry

_log = get_logger("rosproto.master")

Handler = Callable[..., Answer]


class UnknownMethod(LookupError):
    """There is no such method; the server replies with a Fault."""


class _Method(NamedTuple):
    handler: Handler
    checks: tuple[v.Check, ...]
    default: object  # value of the triple when the status is an error
    prepare: Callable[..., object] | None = None  # called without the lock; returns a further argument


METHODS: dict[str, _Method] = {}


def _method(
    default: object, *checks: v.Check, prepare: Callable[..., object] | None = None
) -> Callable[[Handler], Handler]:
    """Publish a function `name(self, caller_id, ...)` as an API method of that name.

    Args:
        default: Value of the triple when the status is an error.
        checks: One for each argument.
        prepare: Does what takes long for large arguments, `prepare(self, ...)`, without the lock; the handler
            gets its result as a further argument.
    """

    def add(handler: Handler) -> Handler:
        METHODS[handler.__name__] = _Method(handler, checks, default, prepare)
        return handler

    return add


class MasterApi:
    """All methods of a master.

    Args:
        post: Receives every notification; must not block.
        stop: Called when a peer calls `shutdown`; must not block.
        may_stop: Whether a peer ("host:port") may do that.
        registry: The graph; by default an empty one.
        parameters: The parameter tree; by default an empty one. It must read `registry.param_subscribers`.

    Attributes:
        uri: Our own XML-RPC URI; set by the server once it knows its port.
        lock: Held around every access to `registry` and `parameters`.
    """

    def __init__(
        self,
        post: Callable[[Notification], None],
        *,
        stop: Callable[[str], None] = lambda reason: None,
        may_stop: Callable[[str], bool] = lambda peer: True,
        registry: Registry | None = None,
        parameters: ParameterTree | None = None,
    ) -> None:
        self.uri = ""
        self.lock = threading.Lock()
        self.registry = Registry() if registry is None else registry
        self.parameters = (
            ParameterTree(self.registry.param_subscribers.providers) if parameters is None else parameters
        )
        self._post = post
        self._stop = stop
        self._may_stop = may_stop
        self._peer_log = PeerLog("rosproto.master")

    def dispatch(self, method: str, params: Sequence[object], peer: str = "") -> list[object]:
        """Answer one call with the triple [status, text, value].

        Args:
            method: Name of the method.
            params: Its arguments as received, caller_id first.
            peer: Address of the caller, for `shutdown`.

        Raises:
            UnknownMethod: There is no such method.
        """
        if method == "shutdown":
            return self._shutdown(params, peer)
        found = METHODS.get(method)
        if found is None:
            raise UnknownMethod(f'method "{method}" is not supported')
        problem = _arity_problem(params, 1 + len(found.checks))
        if problem:
            return [ERROR, problem, found.default]
        caller_id = str(params[0])
        try:
            arguments = [check(p, caller_id) for check, p in zip(found.checks, params[1:], strict=True)]
            if found.prepare is not None:
                arguments.append(found.prepare(self, *arguments))
            with self.lock:
                answer = found.handler(self, caller_id, *arguments)
                for note in answer.notifications:
                    self._post(note)
        except v.InvalidArgument as problem_found:
            return [ERROR, str(problem_found) or "error", found.default]
        _log.debug("< %s by %s (%s) = %d %s", method, caller_id, peer, answer.code, answer.text)
        return answer.triple

    def methods(self) -> list[str]:
        """Names for system.listMethods."""
        return sorted([*METHODS, "shutdown"])

    def _shutdown(self, params: Sequence[object], peer: str) -> list[object]:
        problem = _arity_problem(params, 2)
        if problem:
            return [ERROR, problem, 0]
        if not self._may_stop(peer):
            text = "! refused shutdown of the master by %s (%s): %s"
            self._peer_log.warning("", text, params[0], peer, params[1])
            return [ERROR, f"shutdown of the master is not allowed from {peer}", 0]
        self._stop(f"external shutdown request from [{params[0]}] at {peer}: {params[1]}")
        return [SUCCESS, "shutdown", 0]

    # -- the master itself -------------------------------------------------------------------------------

    @_method("")
    def getUri(self, caller_id: str) -> Answer:
        """Our XML-RPC URI."""
        return Answer(SUCCESS, "", self.uri)

    @_method(-1)
    def getPid(self, caller_id: str) -> Answer:
        """Process id of the master."""
        return Answer(SUCCESS, "", os.getpid())

    # -- parameters --------------------------------------------------------------------------------------

    def _displaced(self, key: str) -> Displaced:
        return self.parameters.displaced(key)

    @_method(0, v.resolved_key, prepare=_displaced)
    def deleteParam(self, caller_id: str, key: str, displaced: Displaced) -> Answer:
        """Remove a value or namespace."""
        try:
            notes = self.parameters.delete(key, displaced=displaced)
        except KeyError:
            return Answer(ERROR, f"parameter [{key}] is not set", 0)
        return Answer(SUCCESS, f"parameter {key} deleted", 0, tuple(notes))

    def _weight(self, key: str, value: object) -> tuple[int, Displaced]:
        try:
            return self.parameters.weigh(key, value), self.parameters.displaced(key)
        except ValueError as error:
            raise v.InvalidArgument(f"ERROR: parameter [value] {error}") from None

    @_method(0, v.resolved_key, v.value, prepare=_weight)
    def setParam(self, caller_id: str, key: str, value: object, weighed: tuple[int, Displaced]) -> Answer:
        """Store a value; a struct replaces the namespace."""
        weight, displaced = weighed
        try:
            notes = self.parameters.set(key, value, caller_id, weight=weight, displaced=displaced)
        except TypeError as error:
            return Answer(ERROR, f"Error: invalid arguments: {error}", 0)
        except ValueError as error:
            return Answer(ERROR, f"ERROR: parameter [value] {error}", 0)
        return Answer(SUCCESS, f"parameter {key} set", 0, tuple(notes))

    @_method(0, v.resolved_key)
    def getParam(self, caller_id: str, key: str) -> Answer:
        """A value, or a namespace as a struct."""
        try:
            return Answer(SUCCESS, f"Parameter [{key}]", self.parameters.get(key))
        except KeyError:
            return Answer(ERROR, f"Parameter [{key}] is not set", 0)

    @_method(0, v.key)
    def searchParam(self, caller_id: str, key: str) -> Answer:
        """The key found by searching upwards from the caller's name."""
        try:
            found = self.parameters.search(caller_id, key)
        except ValueError as error:
            return Answer(FAILURE, f"Internal failure: {error}", 0)
        if found is None:
            return Answer(ERROR, f"Cannot find parameter [{key}] in an upwards search", "")
        return Answer(SUCCESS, f"Found [{found}]", found)

    @_method(0, v.api_uri("caller_api"), v.resolved_key)
    def subscribeParam(self, caller_id: str, caller_api: str, key: str) -> Answer:
        """The value (`{}` if unset); subscribe to paramUpdate calls."""
        answer = _named(caller_id) or self.registry.subscribe_param(
            caller_id, subscription_key(key), caller_api
        )
        if answer.code != SUCCESS:
            return answer
        value = self.parameters.get(key) if self.parameters.has(key) else {}
        return answer._replace(text=f"Subscribed to parameter [{key}]", value=value)

    @_method(0, v.api_uri("caller_api"), v.resolved_key)
    def unsubscribeParam(self, caller_id: str, caller_api: str, key: str) -> Answer:
        """End the paramUpdate calls; replies 1 also without a subscription, as rosmaster does."""
        self.registry.unsubscribe_param(caller_id, subscription_key(key), caller_api)
        return Answer(SUCCESS, f"Unsubscribe to parameter [{key}]", 1)

    @_method(False, v.resolved_key)
    def hasParam(self, caller_id: str, key: str) -> Answer:
        """Whether a value or namespace exists."""
        return Answer(SUCCESS, key, self.parameters.has(key))

    def _names(self) -> list[str]:
        return self.parameters.names()

    @_method([], prepare=_names)
    def getParamNames(self, caller_id: str, names: list[str]) -> Answer:
        """Keys of all values."""
        return Answer(SUCCESS, "Parameter names", names)

    # -- services ----------------------------------------------------------------------------------------

    @_method(0, v.resource("service"), v.api_uri("service_api"), v.api_uri("caller_api"))
    def registerService(self, caller_id: str, service: str, service_api: str, caller_api: str) -> Answer:
        """Register as the provider of a service."""
        return _named(caller_id) or self.registry.register_service(
            caller_id, service, service_api, caller_api
        )

    @_method(0, v.resource("service"), v.api_uri("service_api"))
    def unregisterService(self, caller_id: str, service: str, service_api: str) -> Answer:
        """Unregister as the provider."""
        return self.registry.unregister_service(caller_id, service, service_api)

    @_method("", v.resource("service"))
    def lookupService(self, caller_id: str, service: str) -> Answer:
        """rosrpc URI of a service."""
        return self.registry.lookup_service(service)

    # -- topics ------------------------------------------------------------------------------------------

    @_method([], v.resource("topic"), v.type_name, v.api_uri("caller_api"))
    def registerSubscriber(self, caller_id: str, topic: str, topic_type: str, caller_api: str) -> Answer:
        """The publishers of a topic; subscribe to publisherUpdate calls."""
        return _named(caller_id, []) or self.registry.register_subscriber(
            caller_id, topic, topic_type, caller_api
        )

    @_method(0, v.resource("topic"), v.api_uri("caller_api"))
    def unregisterSubscriber(self, caller_id: str, topic: str, caller_api: str) -> Answer:
        """End the publisherUpdate calls."""
        return self.registry.unregister_subscriber(caller_id, topic, caller_api)

    @_method([], v.resource("topic"), v.type_name, v.api_uri("caller_api"))
    def registerPublisher(self, caller_id: str, topic: str, topic_type: str, caller_api: str) -> Answer:
        """Register as a publisher; subscribers are notified."""
        return _named(caller_id, []) or self.registry.register_publisher(
            caller_id, topic, topic_type, caller_api
        )

    @_method(0, v.resource("topic"), v.api_uri("caller_api"))
    def unregisterPublisher(self, caller_id: str, topic: str, caller_api: str) -> Answer:
        """Unregister as a publisher; subscribers are notified."""
        return self.registry.unregister_publisher(caller_id, topic, caller_api)

    # -- the graph ---------------------------------------------------------------------------------------

    @_method("", v.graph_name("node"))
    def lookupNode(self, caller_id: str, node: str) -> Answer:
        """XML-RPC URI of a node."""
        return self.registry.lookup_node(node)

    @_method(0, v.subgraph)
    def getPublishedTopics(self, caller_id: str, subgraph: str) -> Answer:
        """[topic, type] of the topics published below a namespace."""
        return self.registry.published_topics(subgraph)

    @_method([])
    def getTopicTypes(self, caller_id: str) -> Answer:
        """[topic, type] of every topic with a known type."""
        return self.registry.topic_types()

    @_method([[], [], []])
    def getSystemState(self, caller_id: str) -> Answer:
        """[publishers, subscribers, services]."""
        return self.registry.system_state()


def _arity_problem(params: Sequence[object], expected: int) -> str:
    """rosmaster's text for missing, superfluous or anonymous arguments; "" if there is no problem."""
    if not params:
        return "missing required caller_id parameter"
    if len(params) != expected:
        return "Error: bad call arity"
    if not v.is_text(params[0]):
        return "caller_id must be a string"
    return "" if len(params[0]) <= v.MAX_LENGTH else f"caller_id is longer than {v.MAX_LENGTH} characters"


def _named(caller_id: str, default: object = 0) -> Answer | None:
    """Refuse to register a node under a name that cannot be looked up (rosmaster accepts any string)."""
    if caller_id.strip("/ ") and ":" not in caller_id and " " not in caller_id:
        return None
    return Answer(ERROR, f"ERROR: caller_id [{caller_id}] is not a node name", default)
