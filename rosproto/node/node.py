"""`Node`, the public API of one participant in a ROS 1 graph; `parts.py` puts together what is behind it."""

from __future__ import annotations

import logging
import os
from collections.abc import Callable, Iterable, Mapping
from contextlib import AbstractContextManager
from typing import TYPE_CHECKING, Any

from rosproto import names
from rosproto.codec import AnyMsg
from rosproto.deprecation import former_attribute
from rosproto.errors import LocalProtocolError
from rosproto.node import options, shutdown
from rosproto.node.context import Context
from rosproto.node.definitions.known_definitions import KnownDefinitions
from rosproto.node.definitions.topic_type import ANY
from rosproto.node.definitions.type_argument import ServiceTypeGiven, TypeGiven, resolve_type
from rosproto.node.events import Event
from rosproto.node.graph.master_client import MasterClient
from rosproto.node.incoming.local_nodes import LocalNodes
from rosproto.node.incoming.subscriber import Subscriber
from rosproto.node.outgoing.publisher import Publisher
from rosproto.node.parameters import Parameters
from rosproto.node.parts import GraphSettings, NodeParts
from rosproto.node.services import probe as service_probe
from rosproto.node.services.client import ServiceClient
from rosproto.node.services.server import ServiceServer
from rosproto.node.stats import ConnectedLink, NodeStats
from rosproto.protocol.wire_limits import Limits
from rosproto.sentence import say
from rosproto.transport.deadline import Deadline, wait_event
from rosproto.transport.os_errors import system_errors
from rosproto.transport.shared_threads import hold_shared_threads
from rosproto.transport.uri import master_uri_of

if TYPE_CHECKING:
    from rosproto.node.rosout import Rosout


class Node:
    """A node: publishes, subscribes, calls and provides services, under one name at one master.

    Close it, or use it in a `with` block. A process may have any number of nodes, also at different masters.
    When the master restarts, or this computer's address changes, the node registers everything again. A node
    that is still open when the program ends is unregistered by an `atexit` function.

    Args:
        name: "/laptop", or "laptop" in `namespace`. Must be unique at the master: a second node of the same
            name shuts the first one down.
        master_uri: "http://10.0.0.7:11311/", or "10.0.0.7" for that. None is only allowed with
            `use_environment`.
        host: Address or name under which others reach this computer, and on which the node listens. None:
            the address that routes to the master; changes are followed.
        port: Port of the slave API, 0 for a free one.
        tcpros_port: Port of the TCPROS server, 0 for a free one.
        namespace: For relative names.
        anonymous: Make the name unique by appending host, process and a random number.
        remappings: Name -> other name, as on a ROS command line (`names.parse_arguments`).
        limits: Limits for requests of peers.
        rosout: Publish /rosout, and provide ~get_loggers and ~set_logger_level.
        use_environment: Defaults come from ROS_MASTER_URI, ROS_HOSTNAME, ROS_IP, ROS_NAMESPACE.
        timeout: Seconds to find the master.
        allow: Addresses that may connect to this node; None for all.
        allow_shutdown: Obey `rosnode kill`.
        intraprocess: Exchange messages with nodes of this process without sockets; with a `LocalNodes`, only
            with nodes that have the same one.
        msg_path: Folders with .msg, .srv and .action files in ROS layout: types of your own, which come first
            when a type is given by its name, and further revisions of known types, for peers that use them.
            The folders of `learned_paths` come last, after the bundled types.
        on_event: Called with each `Event`, in a thread of the library.
        resolve: Host name -> address, for names that this computer cannot resolve: robots often announce
            their nodes by host name. Other unresolvable names are replaced by the master's host; this is
            logged.
        follow_clock: Subscribe /clock if `/use_sim_time` is set. False leaves the clock to the program.
        close_at_exit: Close an open node when the program ends.
        on_shutdown_request: Called with the reason, in its own thread, when the master or a tool shuts down
            this node; it must close the node. None closes the node at once.
        any_name: Take `name` as it is, a global name that may be illegal (`/robot-1/my.node`), as rospy does.

    Raises:
        ConnectionLost, RosTimeout: The master does not answer; the text gives its address and what to check.
        ValueError: A name or URI is invalid.
    """

    def __init__(
        self,
        name: str,
        *,
        master_uri: str | None = None,
        host: str | None = None,
        port: int = 0,
        tcpros_port: int = 0,
        namespace: str = "/",
        anonymous: bool = False,
        remappings: Mapping[str, str] | None = None,
        limits: Limits | None = None,
        rosout: bool = True,
        use_environment: bool = False,
        timeout: float = 5.0,
        allow: Iterable[str] | None = None,
        allow_shutdown: bool = True,
        intraprocess: bool | LocalNodes = True,
        msg_path: Iterable[str | os.PathLike[str]] = (),
        on_event: Callable[[Event], object] | None = None,
        resolve: Mapping[str, str] | None = None,
        follow_clock: bool = True,
        close_at_exit: bool = True,
        on_shutdown_request: Callable[[str], object] | None = None,
        any_name: bool = False,
    ) -> None:
        if use_environment:
            master_uri, host, namespace = options.from_environment(master_uri, host, namespace)
        if not master_uri:
            raise ValueError(
                'which master? Give master_uri="http://host:11311", or use_environment and ROS_MASTER_URI'
            )
        master_uri = master_uri_of(master_uri)
        given = {**(options.host_names() if use_environment else {}), **(resolve or {})}
        if not any_name:
            name = options.node_name(name, namespace, anonymous)
        naming = options.NodeNaming(name, remappings or {})
        context = Context(
            name,
            master_uri=master_uri,
            host=host,
            limits=limits or Limits(),
            definitions=KnownDefinitions(options.message_path(msg_path, use_environment=use_environment)),
            hosts=given,
            intraprocess=intraprocess,
            on_event=on_event,
        )
        self._parts = parts = NodeParts(
            context,
            naming,
            port=port,
            tcpros_port=tcpros_port,
            allow=allow,
            allow_shutdown=allow_shutdown,
            on_shutdown_request=on_shutdown_request,
        )
        self.name = name
        self.limits = context.limits
        self.hosts = context.hosts
        self.clock = parts.clock
        self.master_uri = context.master.uri
        self._rosout: Rosout | None = None
        with system_errors(f"open the node {name}", self.master_uri):
            settings = parts.join(timeout)
        if close_at_exit:
            shutdown.close_at_exit(context.lifecycle, self.close)
        try:
            with system_errors(f"open the node {name}", self.master_uri):
                self._start(settings, rosout=rosout, follow_clock=follow_clock)
        except BaseException:
            self.close()
            raise

    def _start(self, settings: GraphSettings, *, rosout: bool, follow_clock: bool) -> None:
        """Open the node's own topics and services; then watch the master."""
        parts, lifecycle = self._parts, self._parts.context.lifecycle
        hold_shared_threads()  # `close` releases them
        parts.note_local()
        lifecycle.closers.append(self.clock.close)
        self.clock.attach(lifecycle.closing, self.subscriber if follow_clock and settings.simulated else None)
        if rosout:
            from rosproto.node.rosout import LoggerServices, Rosout

            with parts.context.registrations.batch():
                self._rosout = Rosout(
                    self.name,
                    parts.naming.logger,
                    self.clock,
                    lifecycle,
                    self.publisher,
                    parts.topics.publications if settings.rosout_topics else None,
                )
                LoggerServices(self.service_server)
        parts.master_monitor.start()

    # -- topics ---------------------------------------------------------------------------------------------

    def batch(self) -> AbstractContextManager[None]:
        """Open many topics and services with one request to the master: `with node.batch(): ...`.

        Publishers, subscribers, service servers, action clients and servers that this thread opens within the
        block exist at once and are registered when the block ends; other nodes cannot find them earlier. A
        master without `system.multicall` gets single requests. If the block raises, they are closed.

        Raises:
            MasterError: The master refused one of them; it is closed, the others stay open.
            RegistrationsRefused: The master refused several; `refused` has the reason for each.
            ConnectionLost, RosTimeout: The master does not answer; all of them are closed.
        """
        self._check_open()
        return self._parts.context.registrations.batch()

    def publisher(
        self,
        topic: str,
        type: TypeGiven,
        *,
        latch: bool = False,
        queue_size: int = 10,
        on_connect: Callable[[str], object] | None = None,
        on_disconnect: Callable[[str], object] | None = None,
        header: Callable[[], Mapping[str, str]] | None = None,
        linger: bool = True,
    ) -> Publisher:
        """Publish a topic; registered at the master when this returns.

        Args:
            topic: Global, relative or "~private" name.
            type: A message class or "package/Type"; `AnyMsg` (or another class of md5sum "*") for a relay
                that does not know what it sends (only subscribers of any type get it, as with rospy).
            latch: Whether later subscribers get the last message.
            queue_size: Queue length per subscriber; when full, the oldest message is dropped.
            on_connect: Called with the caller id of each new subscriber, in a thread of the library; possibly
                before this returns.
            on_disconnect: The same for each disconnected subscriber, not when this publisher is closed.
            header: Called for each new subscriber; returns fields that extend or replace those of the
                connection header.
            linger: Whether the system still delivers sent messages after the program is killed, for minutes
                during a network outage. False discards them: for commands that are dangerous when late.
                After `close` they are delivered in both cases.

        Raises:
            LocalProtocolError: No definite type, another type than before, or the node is closed.
            MasterError, ConnectionLost, RosTimeout: The registration failed.
        """
        self._check_open()
        options.callback_or_none(on_connect, f"on_connect of {topic}")
        options.callback_or_none(on_disconnect, f"on_disconnect of {topic}")
        options.callback_or_none(header, f"header of {topic}")
        type_ = resolve_type(type, self.definitions)
        if type is None or type == ANY:
            text = (
                "{topic}: a publisher needs a specific type; give the class or name of the type it publishes"
            )
            raise LocalProtocolError(say(text, topic=topic))
        return self._parts.topics.open_publisher(
            self.resolve_name(topic),
            type_,
            latch=latch,
            queue_size=options.queue_length(queue_size),
            on_connect=on_connect,
            on_disconnect=on_disconnect,
            header=header,
            linger=linger,
        )

    def subscriber(
        self,
        topic: str,
        type: TypeGiven = None,
        callback: Callable[[Any], object] | None = None,
        *,
        queue_size: int = 10,
        raw: bool = False,
        tcp_nodelay: bool = False,
        unreliable: bool = False,
        on_error: Callable[[Exception], object] | None = None,
        on_links: Callable[[frozenset[ConnectedLink]], object] | None = None,
        inline: bool = False,
    ) -> Subscriber:
        """Subscribe a topic; registered at the master when this returns.

        Args:
            topic: Global, relative or "~private" name.
            type: A message class or "package/Type"; None uses the publisher's definition, `AnyMsg` receives
                any type, raw.
            callback: Called with each message; see `Subscriber` for the thread. The first call may happen
                before this returns. Without a callback, iterate or use `next`.
            queue_size: Queue length; when full, the oldest message is dropped. 1 keeps only the newest.
            raw: Return `AnyMsg` with the encoded bytes instead of decoding.
            tcp_nodelay: Ask publishers to send each message at once. It removes stalls of 40 ms with peers
                that use Nagle's algorithm (rospy, roscpp), but halves their rate in bursts (measured), so it
                is off by default. Our own publishers always send at once.
            unreliable: Use datagrams (UDPROS) with publishers that offer them, as roscpp does: messages may
                be lost, but are never late. For states and sensors over Wi-Fi. As with `tcp_nodelay`, the
                first subscriber of a topic in a node decides for all that share it.
            on_error: Called with each error of a link (lost, refused), in a thread of the library.
            on_links: Called with the connections to publishers that are up, at once and when one was made or
                lost. One that was made again is another one: what was published meanwhile was missed. It is
                called before a message arrives over a new one, and while the topic is locked: take the value
                and return.
            inline: Call `callback` in the receiving thread even if it is slow; the connection is not read
                meanwhile (as in rospy). Callbacks for two publishers may then run at the same time.

        Raises:
            LocalProtocolError: Another type than before, or the node is closed.
            MasterError, ConnectionLost, RosTimeout: It could not be registered.
        """
        self._check_open()
        options.callback_or_none(callback, f"the callback of {topic}")
        options.callback_or_none(on_error, f"on_error of {topic}")
        options.callback_or_none(on_links, f"on_links of {topic}")
        return self._parts.topics.open_subscriber(
            self.resolve_name(topic),
            resolve_type(type, self.definitions),
            callback=callback,
            queue_size=options.queue_length(queue_size),
            raw=raw or type is AnyMsg,
            tcp_nodelay=tcp_nodelay,
            unreliable=unreliable,
            on_error=on_error,
            on_links=on_links,
            inline=inline,
        )

    def wait_for_message(self, topic: str, type: TypeGiven = None, *, timeout: float | None = 10.0) -> Any:
        """Subscribe, take one message, unsubscribe.

        Raises:
            RosTimeout: No message arrived, or the master did not answer; the text gives the state of each
                publisher.
            ConnectionLost, MasterError: The registration failed.
        """
        deadline = Deadline(timeout)
        self._check_open()
        with self._parts.topics.open_subscriber(
            self.resolve_name(topic), resolve_type(type, self.definitions), queue_size=1, deadline=deadline
        ) as subscriber:
            left = deadline.remaining()
            return subscriber.next(left if left is None else round(left, 2))

    # -- services and parameters ----------------------------------------------------------------------------

    def service_client(
        self, service: str, type: ServiceTypeGiven, *, persistent: bool = False
    ) -> ServiceClient:
        """A client of a service; connects on the first call. See `ServiceClient`."""
        self._check_open()
        return self._parts.services.client(self.resolve_name(service), type, persistent=persistent)

    def service_server(
        self, service: str, type: ServiceTypeGiven, handler: Callable[[Any], object]
    ) -> ServiceServer:
        """Provide a service: `handler(request)` returns the response. See `ServiceServer`.

        The handler may be called before this returns.
        """
        self._check_open()
        return self._parts.services.server(self.resolve_name(service), type, handler)

    def wait_for_service(self, service: str, *, timeout: float | None = 10.0) -> None:
        """Wait until a service is provided and its provider answers.

        Raises:
            RosTimeout: No provider answered in time.
        """
        context = self._parts.context
        service_probe.wait(context, self.resolve_name(service), timeout, stop=context.lifecycle.closing)

    @property
    def params(self) -> Parameters:
        """The parameter server as a mapping: `node.params["/key"]`."""
        return self._parts.parameters

    # -- facts ----------------------------------------------------------------------------------------------

    @property
    def uri(self) -> str:
        """XML-RPC URI of this node's slave API."""
        return self._parts.context.uri

    @property
    def host_given(self) -> str | None:
        """The `host` argument; None if the address is found from the route to the master."""
        return self._parts.context.listening.given

    @property
    def tcpros_address(self) -> tuple[str, int]:
        """Host and port where subscribers and clients of services connect."""
        address = self._parts.context.listening
        return address.host, address.endpoints.tcpros.port

    @property
    def rosrpc_uri(self) -> str:
        """URI under which services of this node are registered."""
        return self._parts.context.listening.endpoints.rosrpc_uri

    @property
    def master(self) -> MasterClient:
        """Client of the master API under this node's name."""
        return self._parts.context.master

    @property
    def namespace(self) -> str:
        """Namespace of the node, with a slash at the end."""
        return names.namespace(self.name)

    @property
    def closed(self) -> bool:
        """True from the start of `close`."""
        return self._parts.context.lifecycle.closed

    @property
    def close_reason(self) -> str:
        """Reason of the close; "" if the program closed the node."""
        return self._parts.context.lifecycle.close_reason

    @property
    def logger(self) -> logging.Logger:
        """A logger whose records also go to /rosout (with `rosout=True`)."""
        return self._parts.naming.logger

    @property
    def definitions(self) -> KnownDefinitions:
        """The definitions that the node knows; `OwnDefinitionsOnly` may be set before anything is opened."""
        return self._parts.context.definitions

    @definitions.setter
    def definitions(self, definitions: KnownDefinitions) -> None:
        self._parts.context.definitions = definitions

    def resolve_name(self, name: str) -> str:
        """Resolve a name to a global one, with remappings.

        An invalid name that is in common use (`/camera-1/image`) is accepted with a warning.

        Raises:
            ValueError: No master accepts it: it is empty, or has a space, `:` or control characters.
        """
        return self._parts.naming.resolve(name)

    def stats(self) -> NodeStats:
        """Bytes, messages, drops and reconnects of every link, services, and the state of the master link."""
        return self._parts.stats()

    def wait(self, timeout: float | None = None) -> bool:
        """Wait until the node is closed (by `rosnode kill`, or another thread); True when it is."""
        return wait_event(self._parts.context.lifecycle.ended, timeout)

    def on_shutdown(self, callback: Callable[[str], object]) -> None:
        """Have `callback(reason)` called when the node begins to close; "" when the program closes it.

        Nothing can be sent at that point: see `before_close`.
        """
        self._parts.context.lifecycle.shutdown_callbacks.append(callback)

    def before_close(self, callback: Callable[[str], object]) -> None:
        """Have `callback(reason)` called before the node closes, while it still works.

        For last messages, such as a zero velocity or a goal's cancellation. Called on `close`, at the end of
        the program, and on a `shutdown` request of the master or a peer (`rosnode kill`); `reason` is the
        request's sender and reason, else "". Callbacks run one after the other in order of registration, in
        the closing thread; exceptions are logged. They must return within some seconds: `close` waits for
        them, the end of the program at most ten seconds. In a callback, `close` does nothing. Callbacks do
        not run if the process is killed.
        """
        self._parts.context.lifecycle.before_close.append(callback)

    def add_closer(self, close: Callable[[], None]) -> None:
        """Have `close()` called while the node closes, before its links end: for objects that use the node.

        It must return in bounded time and may be called more than once. The newest is called first. To send
        last messages, use `before_close`.
        """
        self._parts.context.lifecycle.closers.append(close)

    def remove_closer(self, close: Callable[[], None]) -> None:
        """Remove a closer; does nothing if it is not registered."""
        closers = self._parts.context.lifecycle.closers
        if close in closers:
            closers.remove(close)

    def watch_master(self, *, period: float, full_check_every: int) -> None:
        """Set how often the master is checked.

        Args:
            period: Seconds between two checks while the master answers; 1 by default.
            full_check_every: Checks between two comparisons of the whole graph; 5 by default.
        """
        monitor = self._parts.master_monitor
        monitor.period, monitor.full_check_every = period, full_check_every

    def check_master_now(self) -> None:
        """Check at once whether this node is still registered at the master."""
        self._parts.master_monitor.check_now()

    registering = former_attribute("registering", "batch")
    revisions = former_attribute("revisions", "definitions")
    look_at_master = former_attribute("look_at_master", "check_master_now")

    def __repr__(self) -> str:
        state = "closed" if self.closed else self.uri
        return f"<Node {self.name} at {self.master_uri}, {state}>"

    # -- closing --------------------------------------------------------------------------------------------

    def close(self) -> None:
        """Unregister everything and end all links; bounded in time, may be called twice.

        Messages queued for slow subscribers are dropped after half a second.
        """
        self._parts.close("")

    def __enter__(self) -> Node:
        return self

    def __exit__(self, *exc_info: object) -> None:
        self.close()

    def _check_open(self) -> None:
        if self.closed:
            why = f" ({self.close_reason})" if self.close_reason else ""
            raise LocalProtocolError(f"node {self.name} is closed{why}; open another one")
