"""`Node`, the public API of one participant in a ROS 1 graph; `parts.py` puts together what is behind it."""

from __future__ import annotations

import logging
import os
from collections.abc import Callable, Iterable, Mapping
from contextlib import AbstractContextManager
from types import TracebackType
from typing import TYPE_CHECKING, Any

from rosproto import names
from rosproto.codec import AnyMsg
from rosproto.errors import LocalProtocolError
from rosproto.node import options, shutdown
from rosproto.node.context import Context
from rosproto.node.definitions.known_definitions import KnownDefinitions
from rosproto.node.definitions.topic_type import ANY
from rosproto.node.definitions.type_argument import TypeGiven, resolve_type
from rosproto.node.events import Event
from rosproto.node.graph.master_client import MasterClient
from rosproto.node.graph.startup import GraphSettings
from rosproto.node.incoming.local_nodes import LocalNodes
from rosproto.node.incoming.subscriber import Subscriber
from rosproto.node.naming import NodeNaming
from rosproto.node.outgoing.publisher import Publisher
from rosproto.node.parameters import Parameters
from rosproto.node.parts import NodeParts
from rosproto.node.services import probe as service_probe
from rosproto.node.services.client import ServiceClient
from rosproto.node.services.server import ServiceServer
from rosproto.node.stats import NodeStats
from rosproto.protocol.wire_limits import Limits
from rosproto.transport.deadline import Deadline, wait_event
from rosproto.transport.os_errors import system_errors

if TYPE_CHECKING:
    from rosproto.node.rosout import Rosout


class Node:
    """A node: publishes, subscribes, calls and provides services, under one name at one master.

    Close it, or use it in a `with` block. Any number of nodes may live in one process, also of different
    masters. When the master restarts, or this computer's address changes, everything is registered again by
    itself. A node that is still open when the program ends is taken off the master then, by a function that
    the first node registers with `atexit`.

    Args:
        name: "/laptop", or "laptop" in `namespace`. Must be unique at the master: a second node of the same
            name shuts the first one down.
        master_uri: "http://10.0.0.7:11311/". None is only allowed with `use_environment`.
        host: Address or name under which others reach this computer, and which is listened on. None: the
            address that routes to the master, followed when it changes.
        port: Port of the slave API, 0 for a free one.
        tcpros_port: Port of the TCPROS server, 0 for a free one.
        namespace: For relative names.
        anonymous: Make the name unique by appending host, process and a random number.
        remappings: Name -> other name, as on a ROS command line (`names.parse_arguments`).
        limits: Bounds for what peers may ask.
        rosout: Publish /rosout, and provide ~get_loggers and ~set_logger_level.
        use_environment: Take what is not given from ROS_MASTER_URI, ROS_HOSTNAME, ROS_IP, ROS_NAMESPACE.
        timeout: Seconds to find the master.
        allow: Addresses that may connect to this node; None for all.
        allow_shutdown: Obey `rosnode kill`.
        intraprocess: Exchange messages with nodes of this process without sockets; a `LocalNodes`: with those
            alone that were given the same one.
        msg_path: Folders with .msg, .srv and .action files in ROS layout: types of your own, which come first
            when a type is given by its name, and further revisions of known ones, for peers that have those.
            What `learned_paths` gives comes last, after the bundled types.
        on_event: Called with each `Event`, in a thread of the library.
        resolve: Host name -> address, for names that this computer does not know: a robot often announces its
            nodes by its own. A name that is not given and cannot be resolved is taken for the master's host;
            the log tells.
        follow_clock: Subscribe /clock where `/use_sim_time` says so. False leaves the clock to the program.
        close_at_exit: Close the node when the program ends and has not done so.
        on_shutdown_request: Called with the reason, in a thread of its own, when the master or a tool ends
            this node; it is to close it. None: that is done at once.

    Raises:
        ConnectionLost, RosTimeout: No master answers; the text says where, and what to check.
        ValueError: A name or URI is not legal.
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
    ) -> None:
        if use_environment:
            master_uri, host, namespace = options.from_environment(master_uri, host, namespace)
        if not master_uri:
            raise ValueError(
                'which master? Give master_uri="http://host:11311", or use_environment and ROS_MASTER_URI'
            )
        given = {**(options.host_names() if use_environment else {}), **(resolve or {})}
        name = options.node_name(name, namespace, anonymous)
        naming = NodeNaming(name, remappings or {})
        context = Context(
            name,
            master_uri=master_uri,
            host=host,
            limits=limits or Limits(),
            revisions=KnownDefinitions(options.message_path(msg_path, use_environment=use_environment)),
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
        """Open what the node itself publishes, subscribes and provides; then watch the master."""
        parts, lifecycle = self._parts, self._parts.context.lifecycle
        parts.note_local()
        lifecycle.closers.append(self.clock.close)
        self.clock.attach(lifecycle.closing, self.subscriber if follow_clock and settings.simulated else None)
        if rosout:
            from rosproto.node.rosout import LoggerServices, Rosout

            with parts.context.registrations.together():
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

    def registering(self) -> AbstractContextManager[None]:
        """Open many topics and services with one request to the master: `with node.registering(): ...`.

        What this thread opens within the block (publishers, subscribers, service servers, action clients and
        servers) is there at once, and registered when the block ends: until then nobody else finds it. A
        master without `system.multicall` is told one by one. When the block raises, what it has opened is
        closed.

        Raises:
            MasterError: At the end, the master refused one; that one is closed, the others stand.
            RegistrationsRefused: It refused several; `refused` says why, for each.
            ConnectionLost, RosTimeout: The master is away; all of it is closed.
        """
        self._check_open()
        return self._parts.context.registrations.together()

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
            latch: A subscriber that comes later gets the last message.
            queue_size: Most messages that wait for one slow subscriber; the oldest is dropped.
            on_connect: Called with the caller id of each new subscriber, in a thread of the library; perhaps
                before this has returned.
            on_disconnect: The same for each subscriber that has left, not when this publisher is closed.
            header: Called for each new subscriber; what it returns is said to it besides the usual fields
                of a connection header, or in their place.
            linger: When the program is killed, the system goes on delivering what it sent, for minutes when
                the network is away. False has that thrown away: for commands that do harm when they come
                late. After an orderly end (`close`) it is delivered in both cases.

        Raises:
            LocalProtocolError: No definite type, another type than before, or the node is closed.
            MasterError, ConnectionLost, RosTimeout: It could not be registered.
        """
        self._check_open()
        options.callback_or_none(on_connect, f"on_connect of {topic}")
        options.callback_or_none(on_disconnect, f"on_disconnect of {topic}")
        options.callback_or_none(header, f"header of {topic}")
        type_ = resolve_type(type, self.revisions)
        if type is None or type == ANY:
            raise LocalProtocolError(
                f"{topic}: a publisher needs a definite type; give the class or name of what it publishes"
            )
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
        inline: bool = False,
    ) -> Subscriber:
        """Subscribe a topic; registered at the master when this returns.

        Args:
            topic: Global, relative or "~private" name.
            type: A message class or "package/Type"; None takes the publisher's own definition, `AnyMsg` is
                any type, raw.
            callback: Called with each message; see `Subscriber` for the thread. The first call may come as
                soon as the topic is registered, before this has returned. Without it, iterate or use `next`.
            queue_size: Most messages that wait for the program; the oldest is dropped. 1 is the newest.
            raw: Give `AnyMsg` with the encoded bytes, do not decode.
            tcp_nodelay: Ask publishers to send each message at once. It removes stalls of 40 ms with peers
                that use Nagle's algorithm (rospy, roscpp), and costs them more than half their rate in bursts
                (measured), therefore off. Our own publishers send at once in any case.
            unreliable: Take datagrams (UDPROS) from publishers that offer them, as roscpp does: what the
                network loses is lost, and nothing comes late. For states and sensors over Wi-Fi. As with
                `tcp_nodelay`, the first subscriber of a topic in a node decides for those that share it.
            on_error: Called with each error of a link (lost, refused), in a thread of the library.
            inline: Call `callback` in the thread that received the message even when it is slow; the
                connection is not read meanwhile (what rospy does). Callbacks for two publishers may then
                run at the same time.

        Raises:
            LocalProtocolError: Another type than before, or the node is closed.
            MasterError, ConnectionLost, RosTimeout: It could not be registered.
        """
        self._check_open()
        options.callback_or_none(callback, f"the callback of {topic}")
        options.callback_or_none(on_error, f"on_error of {topic}")
        return self._parts.topics.open_subscriber(
            self.resolve_name(topic),
            resolve_type(type, self.revisions),
            callback=callback,
            queue_size=options.queue_length(queue_size),
            raw=raw or type is AnyMsg,
            tcp_nodelay=tcp_nodelay,
            unreliable=unreliable,
            on_error=on_error,
            inline=inline,
        )

    def wait_for_message(self, topic: str, type: TypeGiven = None, *, timeout: float | None = 10.0) -> Any:
        """Subscribe, take one message, unsubscribe.

        Raises:
            RosTimeout: None came, or the master did not answer; the text tells how things stand with each
                publisher.
            ConnectionLost, MasterError: It could not be registered.
        """
        deadline = Deadline(timeout)
        self._check_open()
        with self._parts.topics.open_subscriber(
            self.resolve_name(topic), resolve_type(type, self.revisions), queue_size=1, deadline=deadline
        ) as subscriber:
            left = deadline.remaining()
            return subscriber.next(left if left is None else round(left, 2))

    # -- services and parameters ----------------------------------------------------------------------------

    def service_client(self, service: str, type: Any, *, persistent: bool = False) -> ServiceClient:
        """A client of a service; connects with the first call. See `ServiceClient`."""
        self._check_open()
        return self._parts.services.client(self.resolve_name(service), type, persistent=persistent)

    def service_server(self, service: str, type: Any, handler: Callable[[Any], Any]) -> ServiceServer:
        """Provide a service: `handler(request)` returns the response. See `ServiceServer`.

        The handler may be called as soon as the service is registered, before this has returned.
        """
        self._check_open()
        return self._parts.services.server(self.resolve_name(service), type, handler)

    def wait_for_service(self, service: str, *, timeout: float | None = 10.0) -> None:
        """Wait until a service is provided and its provider answers.

        Raises:
            RosTimeout: It was not in time.
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
        """Our address as the program gave it; None where it is found from the route to the master."""
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
        """The master, asked in this node's name."""
        return self._parts.context.master

    @property
    def namespace(self) -> str:
        """Namespace of the node, with a slash at the end."""
        return names.namespace(self.name)

    @property
    def closed(self) -> bool:
        """True from the beginning of `close`."""
        return self._parts.context.lifecycle.closed

    @property
    def close_reason(self) -> str:
        """Why the node was closed: "" by the program, else by whom (`rosnode kill`)."""
        return self._parts.context.lifecycle.close_reason

    @property
    def logger(self) -> logging.Logger:
        """A logger whose records also go to /rosout (with `rosout=True`)."""
        return self._parts.naming.logger

    @property
    def revisions(self) -> KnownDefinitions:
        """The definitions that the node knows; `OwnDefinitionsOnly` may be set before anything is opened."""
        return self._parts.context.revisions

    @revisions.setter
    def revisions(self, revisions: KnownDefinitions) -> None:
        self._parts.context.revisions = revisions

    def resolve_name(self, name: str) -> str:
        """The global name that `name` means here, remappings applied.

        A name that is not legal, but in use elsewhere (`/camera-1/image`), is taken with a warning.

        Raises:
            ValueError: No master takes it: it is empty, or has a space, `:` or control characters.
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

        Nothing can be sent any more then: see `before_close`.
        """
        self._parts.context.lifecycle.shutdown_callbacks.append(callback)

    def before_close(self, callback: Callable[[str], object]) -> None:
        """Have `callback(reason)` called before the node closes, while everything of it still works.

        For what must still be said: a last zero, the end of a goal. It is called by whatever closes the node
        in order: `close`, the end of the program, and a `shutdown` that the master or a peer asks for
        (`rosnode kill`); then `reason` says who asked, and why; else it is "". Callbacks are called one after
        the other, in the order of their registration, in the thread that closes; what one raises is logged.
        They must end by themselves within some seconds: the node waits for them, the end of the program ten
        seconds at most. In one of them `close` does nothing. A process that is killed calls nobody.
        """
        self._parts.context.lifecycle.before_close.append(callback)

    def add_closer(self, close: Callable[[], None]) -> None:
        """Have `close()` called while the node closes, before its links go: for what is built on the node.

        It has to end in bounded time, and may be called although it was called before. The newest is called
        first. See `before_close` for what must still be said to others.
        """
        self._parts.context.lifecycle.closers.append(close)

    def remove_closer(self, close: Callable[[], None]) -> None:
        """Do not call it any more; nothing when it is not there."""
        closers = self._parts.context.lifecycle.closers
        if close in closers:
            closers.remove(close)

    def watch_master(self, *, period: float, full_check_every: int) -> None:
        """Look after the master less often, or more.

        Args:
            period: Seconds between two looks at a master that answers; 1 at first.
            full_check_every: Looks between two comparisons of the whole graph; 5 at first.
        """
        monitor = self._parts.master_monitor
        monitor.period, monitor.full_check_every = period, full_check_every

    def look_at_master(self) -> None:
        """Look now whether the master still knows us: something is known to have changed."""
        self._parts.master_monitor.hurry()

    def __repr__(self) -> str:
        state = "closed" if self.closed else self.uri
        return f"<Node {self.name} at {self.master_uri}, {state}>"

    # -- closing --------------------------------------------------------------------------------------------

    def close(self) -> None:
        """Take everything off the master and end all links; bounded in time, may be called twice.

        What waits for slow subscribers is given half a second, then dropped.
        """
        self._parts.close("")

    def __enter__(self) -> Node:
        return self

    def __exit__(
        self,
        error_type: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()

    def _check_open(self) -> None:
        if self.closed:
            why = f" ({self.close_reason})" if self.close_reason else ""
            raise LocalProtocolError(f"node {self.name} is closed{why}; open another one")
