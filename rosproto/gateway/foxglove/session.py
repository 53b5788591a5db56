"""One client: an SDK server of its own, and what the client sees, follows and publishes through it.

A server for each client costs a fraction of a millisecond and a port of this computer. In return a refusal is
told to the client that asked, and each client has its own queue, bounded in bytes.

A program that finds the port before the proxy has connected, or on a system where the port stays open
(`listening_port`), is not taken for the client: the proxy first sends a secret (`ClientIdentity`), and a
request from anybody who has not sent it ends the session.

Threads: the SDK calls `SdkListener` in its own, which must not wait, so whatever asks the master goes to a
`SerialExecutor`. Messages arrive in the node's threads. The proxy's thread says whether the client reads.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from rosproto.errors import RosError
from rosproto.gateway.foxglove.advertised_topics import AdvertisedTopics
from rosproto.gateway.foxglove.channels import Channels, OfferedChannel
from rosproto.gateway.foxglove.client_identity import ClientIdentity
from rosproto.gateway.foxglove.graph import GraphView, connection_graph
from rosproto.gateway.foxglove.listening_port import close_listening_port
from rosproto.gateway.foxglove.message_sender import ChannelReceiver, MessageSender
from rosproto.gateway.foxglove.parameters import FollowedParameters, sdk_parameter
from rosproto.gateway.foxglove.publish import ENCODINGS
from rosproto.gateway.foxglove.sdk import sdk
from rosproto.gateway.foxglove.sdk_listener import SdkListener
from rosproto.gateway.foxglove.serial_executor import SerialExecutor
from rosproto.gateway.foxglove.services import CallCount, sdk_service
from rosproto.logs import get_logger

if TYPE_CHECKING:
    from rosproto.gateway.foxglove.shared import Shared

__all__ = ["Session"]

_log = get_logger("rosproto.gateway")

BACKLOG = 1024  # messages in the SDK's queue; since sending pauses in time, few ever wait there
TOLD_AGAIN = 5.0  # seconds for which the same text is not told again


class Session:
    """One client of a server.

    Args:
        shared: What all sessions share.
        peer: Address of the client.
        hang_up: Ends its connection to the proxy.

    Attributes:
        port: Of its SDK server.
        introduction: What the proxy sends there first.
        alone: Whether nobody else can reach that port any more.
        sender: Hands the client its messages.
        publications: What the client publishes.
    """

    def __init__(self, shared: Shared, peer: str, hang_up: Callable[[], None]) -> None:
        fg = sdk()
        self.shared, self.peer = shared, peer
        self.since = time.time()
        self._hang_up = hang_up
        self._closed = False
        self._identity = ClientIdentity()
        self.introduction = self._identity.introduction
        self.alone = self._admitted = False
        self._lock = threading.Lock()
        self._executor = SerialExecutor(shared.pool)
        self.sender = MessageSender(shared.limits, shared.later)
        self.publications = AdvertisedTopics(shared, self, self.status, lambda: self._closed)
        self._wanted: dict[int, int] = {}
        self._subscriptions = 0
        self._services: dict[str, Any] = {}
        self._calls = CallCount(shared.limits.calls_per_client)
        self._graph_wanted = False
        self._told: dict[str, float] = {}
        self._context = fg.Context()
        self.server: Any = fg.start_server(
            name=shared.name,
            host="127.0.0.1",
            port=0,
            capabilities=shared.capabilities(),
            supported_encodings=list(ENCODINGS),
            server_listener=SdkListener(self),
            asset_handler=shared.assets.fetch if shared.assets else None,
            context=self._context,
            session_id=shared.session_id,
            message_backlog_size=BACKLOG,
        )
        self.port: int = self.server.port
        self.followed = FollowedParameters(
            shared.node, shared.access, shared.limits.subscriptions_per_client, self._parameters_changed
        )
        self.channels = Channels(self._context, shared)

    # -- what is offered ------------------------------------------------------------------------------------

    def show(self, view: GraphView) -> None:
        """Offer the topics and services of a view, once the client is known; may take a while."""
        if self._closed or not self._admitted:
            return
        self.channels.show(view)
        self.show_services(view)
        self._executor.submit(self._follow)
        if self._graph_wanted:
            self.server.publish_connection_graph(connection_graph(view, self.shared.access))

    def show_services(self, view: GraphView) -> None:
        """Offer exactly the services whose type is known."""
        if self._closed or not self._admitted:
            return
        present = self.shared.services.present(view)
        with self._lock:
            gone = [name for name, kind in self._services.items() if present.get(name) is not kind]
            new = {name: kind for name, kind in present.items() if self._services.get(name) is not kind}
            self._services = dict(present)
        if gone:
            self.server.remove_services(gone)
        if new:
            shared = self.shared
            self.server.add_services(
                [
                    sdk_service(
                        name, kind, shared.node, shared.access, shared.limits, self._calls, self._is_client
                    )
                    for name, kind in new.items()
                ]
            )

    def renew(self, topic: str) -> None:
        """A topic's definition is not the one that was told: offer it again."""
        if self._admitted and not self._closed:
            self.channels.renew(topic)
            self._executor.submit(self._follow)

    def forget_everything(self) -> None:
        """The master has restarted: take back everything offered, and have the client forget it."""
        if not self._closed:
            self.channels.clear()
            self.server.clear_session(self.shared.session_id)

    def status(self, text: str, level: str = "Warning", id: str | None = None) -> None:
        """Show the client a text; the same text only once in a while."""
        now = time.monotonic()
        with self._lock:
            if self._closed or now - self._told.get(text, -TOLD_AGAIN) < TOLD_AGAIN:
                return
            if len(self._told) > 100:
                self._told.clear()
            self._told[text] = now
        self.server.publish_status(text, getattr(sdk().StatusLevel, level), id)

    def remove_status(self, id: str) -> None:
        """The status with this id no longer holds."""
        if not self._closed:
            with self._lock:
                self._told.clear()
            self.server.remove_status([id])

    def upstream_connected(self, port: int) -> None:
        """The proxy has connected from this port: let nobody else in, then offer what there is."""
        self.alone = close_listening_port(self.port, port)
        self._admitted = True
        self.show(self.shared.view)

    def client_connected(self) -> None:
        """The client can hear now: tell it how things stand."""
        self.shared.welcome(self)

    def time(self, nanoseconds: int) -> None:
        """Tell the client the simulated time."""
        if not self._closed:
            self.server.broadcast_time(nanoseconds)

    # -- topics that are followed ---------------------------------------------------------------------------

    def subscribed(self, client: int, channel: int) -> None:
        """The client subscribes a channel."""
        if not self._is_client(client):
            return
        with self._lock:
            self._subscriptions += 1
            self._wanted[channel] = self._subscriptions
        self._executor.submit(self._follow)

    def unsubscribed(self, client: int, channel: int) -> None:
        """The client unsubscribes a channel, or the channel is gone."""
        with self._lock:
            self._wanted.pop(channel, None)
        self._executor.submit(self._follow)

    def _is_client(self, client: int) -> bool:
        """Whether this is the client from the proxy. If not, another program is there: end the session."""
        if self._identity.is_client(client):
            return True
        _log.warning("! foxglove: another program has reached the port of %s: both are cut off", self.peer)
        self.stop()
        self._hang_up()
        return False

    def _follow(self) -> None:
        """Follow what is wanted and leave the rest. Only the executor calls this."""
        with self._lock:
            wanted = dict(self._wanted) if not self._closed else {}
        for topic, problem in self.channels.follow(wanted, self._receiver):
            self.status(f"{topic} is not followed: {problem}")

    def _receiver(self, channel: OfferedChannel) -> ChannelReceiver:
        return ChannelReceiver(channel, self.sender.send, self.shared.schema_differs)

    def pause_sending(self) -> None:
        """The client does not read what it is sent."""
        self.sender.pause()

    def resume_sending(self) -> None:
        """The client has read it."""
        self.sender.resume()

    # -- what the client does -------------------------------------------------------------------------------

    def advertised(self, client: int, channel: Any) -> None:
        """The client publishes on a channel; or it is the proxy, which says who it is."""
        if not self._identity.introduced(client, str(channel.topic)) and self._is_client(client):
            self.publications.advertise(channel)

    def message(self, client: int, channel: int, data: bytes) -> None:
        """The client publishes a message."""
        if self._is_client(client):
            self.publications.publish(channel, data)

    def unadvertised(self, client: int, channel: int) -> None:
        """The client no longer publishes on a channel, or is gone."""
        if self._identity.is_client(client):
            self.publications.unadvertise(channel)

    def get_parameters(self, client: int, names: list[str]) -> list[Any]:
        """The client asks for values. The SDK waits for them, some seconds at most."""
        if not self._is_client(client):
            return []
        try:
            found = self.shared.parameters.get(names)
        except RosError as problem:
            text = f"parameters cannot be told: {problem}"
            self._executor.submit(lambda: self.status(text))
            return []
        return [sdk_parameter(name, value) for name, value in found.items()]

    def set_parameters(self, client: int, parameters: list[Any]) -> list[Any]:
        """The client sets values; returns the values that hold afterwards."""
        if not self._is_client(client):
            return []
        for parameter in parameters[: self.shared.limits.subscriptions_per_client]:
            problem = self.shared.parameters.set(parameter.name, parameter.get_value())
            if problem is not None:
                self.shared.refusals += 1
                self._executor.submit(lambda text=problem: self.status(text))  # type: ignore[misc]
        names = [parameter.name for parameter in parameters]
        try:
            found = self.shared.parameters.get(names) if names else {}
        except RosError:
            return []
        return [sdk_parameter(name, found.get(name)) for name in names]

    def follow_parameters(self, names: list[str]) -> None:
        """The client wants to know when these change."""

        def follow() -> None:
            problem = self.followed.follow(names)
            if problem is not None:
                self.status(problem)

        self._executor.submit(follow)

    def leave_parameters(self, names: list[str]) -> None:
        """The client no longer wants to know."""
        self._executor.submit(lambda: self.followed.leave(names))

    def _parameters_changed(self, parameters: list[Any]) -> None:
        if not self._closed:
            self.server.publish_parameter_values(parameters)

    def want_graph(self, wanted: bool) -> None:
        """Whether the client wants the connection graph."""
        self._graph_wanted = wanted
        if wanted:
            self._executor.submit(self._show_graph)

    def _show_graph(self) -> None:
        if self._graph_wanted and not self._closed:
            self.server.publish_connection_graph(connection_graph(self.shared.view, self.shared.access))

    # -- the end --------------------------------------------------------------------------------------------

    @property
    def topics(self) -> tuple[str, ...]:
        """The topics the client follows now."""
        return self.channels.followed

    def stop(self) -> None:
        """End the connection; `close` leaves what was followed and published."""
        with self._lock:
            if self._closed:
                return
            self._closed = True
        self.sender.stop()
        self.server.stop()

    def close(self) -> None:
        """End the session: zeros where the client drove, then leave everything. May wait for the master."""
        self.stop()
        self.shared.guard.gone(self)
        self._executor.close()
        self.publications.stop()
        self.sender.close()
        self.publications.close()
        self.channels.close()
        self.followed.close()
        self.shared.gone(self)

    def __repr__(self) -> str:
        return f"<Session of {self.peer}, {len(self.topics)} topics>"
