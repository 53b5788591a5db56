"""One client: an SDK server of his own, and what he sees, follows and publishes through it.

A server for each client costs a fraction of a millisecond and a port of this computer, and gives what one for
all cannot: what is refused is told to him who asked; and each client has his own queue, bounded in bytes.

Who finds the port before the door has connected, or on a system where it stays open (`seal`), is not taken
for the viewer: the door shows a secret first, and who asks for anything without it ends the session.

Threads: the SDK calls the listener in its own, which must not wait: what asks the master goes to `Jobs`.
Messages come in the node's threads (`_Follower.offer`). The door tells from its thread whether the client
reads.
"""

from __future__ import annotations

import hmac
import json
import secrets
import threading
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from rosproto.errors import RosError
from rosproto.gateway.foxglove import handshake as head
from rosproto.gateway.foxglove.channels import Channels, Shown
from rosproto.gateway.foxglove.graph import GraphView, connection_graph
from rosproto.gateway.foxglove.listening_port import sealed
from rosproto.gateway.foxglove.parameters import FollowedParameters, shown
from rosproto.gateway.foxglove.publish import ENCODINGS, Advert, NotOpen, Refused
from rosproto.gateway.foxglove.sdk import sdk
from rosproto.gateway.foxglove.serial_executor import Jobs
from rosproto.gateway.foxglove.services import CallCount, sdk_service
from rosproto.gateway.outbox import Outbox
from rosproto.logs import get_logger

if TYPE_CHECKING:
    from rosproto.gateway.foxglove.shared import House
    from rosproto.gateway.message_event import Sample, TopicDescription

__all__ = ["Session"]

_log = get_logger("rosproto.gateway")

BACKLOG = 1024  # messages in the SDK's queue; the door sees to it that few are there
BATCH = 1 << 20  # bytes handed to the SDK at once, of what has waited
PAUSE = 0.01  # seconds between two such batches
TOLD_AGAIN = 5.0  # seconds in which the same refusal is told once
INTRODUCED = 0xFFFFFFFF  # number of the channel that the door advertises, and takes back at once


class Session:
    """One client of a server.

    Args:
        house: What all sessions share.
        peer: Address of the client.
        hang_up: Ends its connection.

    Attributes:
        port: Of its SDK server.
        introduction: What the door sends there first.
        alone: Whether nobody else reaches that port any more.
        sent, sent_bytes: Messages handed on.
    """

    def __init__(self, house: House, peer: str, hang_up: Callable[[], None]) -> None:
        fg = sdk()
        self.house, self.peer = house, peer
        self.since = time.time()
        self.sent = self.sent_bytes = self.published = 0
        self._hang_up = hang_up
        self._closed = False
        self._client: int | None = None
        self._secret = secrets.token_hex(32)
        self.introduction = head.frame(
            json.dumps(
                {
                    "op": "advertise",
                    "channels": [
                        {"id": INTRODUCED, "topic": self._secret, "encoding": "json", "schemaName": ""}
                    ],
                }
            )
        ) + head.frame(json.dumps({"op": "unadvertise", "channelIds": [INTRODUCED]}))
        self.alone = self._admitted = False
        self._lock = threading.Lock()
        self._sending = threading.Lock()
        self._clogged = False
        self._outbox: Outbox[tuple[Shown, bytes, int]] = Outbox(house.limits)
        self._flushing = False
        self._reading, self._writing = Jobs(house.pool), Jobs(house.pool)
        self._wanted: dict[int, int] = {}
        self._subscriptions = 0
        self._adverts: dict[int, Advert] = {}
        self._not_open: dict[int, str] = {}
        self._services: dict[str, Any] = {}
        self._calls = CallCount(house.limits.calls_per_client)
        self._graph_wanted = False
        self._told: dict[str, float] = {}
        self._context = fg.Context()
        self.server: Any = fg.start_server(
            name=house.name,
            host="127.0.0.1",
            port=0,
            capabilities=house.capabilities(),
            supported_encodings=list(ENCODINGS),
            server_listener=_listener(self),
            asset_handler=house.assets.fetch if house.assets else None,
            context=self._context,
            session_id=house.session_id,
            message_backlog_size=BACKLOG,
        )
        self.port: int = self.server.port
        self.followed = FollowedParameters(
            house.node, house.access, house.limits.subscriptions_per_client, self._parameters_changed
        )
        self.channels = Channels(self._context, house)

    # -- what is to be seen ---------------------------------------------------------------------------------

    def show(self, view: GraphView) -> None:
        """Offer the topics and services of a view, to nobody but the client; takes its time."""
        if self._closed or not self._admitted:
            return
        self.channels.show(view)
        self.show_services(view)
        self._reading.add(self._follow)
        if self._graph_wanted:
            self.server.publish_connection_graph(connection_graph(view, self.house.access))

    def show_services(self, view: GraphView) -> None:
        """Offer those whose type is known, and no others."""
        if self._closed or not self._admitted:
            return
        present = self.house.services.present(view)
        with self._lock:
            over = [name for name, kind in self._services.items() if present.get(name) is not kind]
            new = {name: kind for name, kind in present.items() if self._services.get(name) is not kind}
            self._services = dict(present)
        if over:
            self.server.remove_services(over)
        if new:
            house = self.house
            self.server.add_services(
                [
                    sdk_service(
                        name, kind, house.node, house.access, house.limits, self._calls, self._is_ours
                    )
                    for name, kind in new.items()
                ]
            )

    def renew(self, topic: str) -> None:
        """A topic has another definition than was told: offer it anew."""
        if self._admitted and not self._closed:
            self.channels.renew(topic)
            self._reading.add(self._follow)

    def begin_anew(self) -> None:
        """The robot is another run: everything offered is taken back, and the client told to forget."""
        if not self._closed:
            self.channels.clear()
            self.server.clear_session(self.house.session_id)

    def status(self, text: str, level: str = "Warning", id: str | None = None) -> None:
        """Tell the client; the same text once in a while only."""
        now = time.monotonic()
        with self._lock:
            if self._closed or now - self._told.get(text, -TOLD_AGAIN) < TOLD_AGAIN:
                return
            if len(self._told) > 100:
                self._told.clear()
            self._told[text] = now
        self.server.publish_status(text, getattr(sdk().StatusLevel, level), id)

    def take_back_status(self, id: str) -> None:
        """What was told under this id is over."""
        if not self._closed:
            with self._lock:
                self._told.clear()
            self.server.remove_status([id])

    def admit(self, port: int) -> None:
        """The door is connected, from this port: nobody else is let in; then it gets something to see."""
        self.alone = sealed(self.port, port)
        self._admitted = True
        self.show(self.house.view)

    def arrived(self) -> None:
        """The client is connected: what it missed before."""
        self.house.welcome(self)

    def time(self, nanoseconds: int) -> None:
        """The simulation's time."""
        if not self._closed:
            self.server.broadcast_time(nanoseconds)

    # -- topics that are followed ---------------------------------------------------------------------------

    def subscribed(self, client: int, channel: int) -> None:
        """The SDK: the client wants a channel."""
        if not self._is_ours(client):
            return
        with self._lock:
            self._subscriptions += 1
            self._wanted[channel] = self._subscriptions
        self._reading.add(self._follow)

    def unsubscribed(self, client: int, channel: int) -> None:
        """The SDK: he wants it no more, or it is gone."""
        with self._lock:
            self._wanted.pop(channel, None)
        self._reading.add(self._follow)

    def _is_ours(self, client: int) -> bool:
        """The client of this port that knew the secret is the one from the door; there is to be no other."""
        with self._lock:
            if self._client == client:
                return True
        _log.warning("! foxglove: somebody else has reached the port of %s: both are cut off", self.peer)
        self.stop()
        self._hang_up()
        return False

    def _follow(self) -> None:
        """Follow what is wanted, leave what is not; one at a time."""
        with self._lock:
            wanted = dict(self._wanted) if not self._closed else {}
        for topic, problem in self.channels.follow(wanted, self._follower):
            self.status(f"{topic} is not followed: {problem}")

    def _follower(self, channel: Shown) -> _Follower:
        return _Follower(self, channel)

    def send(self, channel: Shown, sample: Sample) -> None:
        """A message for the client; in a thread of the node, which must not wait."""
        data: bytes = sample.once("bytes", lambda: bytes(sample.data))
        stamp = sample.stamp.to_nsec()
        with self._sending:
            if self._clogged or len(self._outbox):
                self._outbox.put(channel.topic, len(data), (channel, data, stamp))
            else:
                self._log(channel, data, stamp)

    def _log(self, channel: Shown, data: bytes, stamp: int) -> None:
        if channel.closed or self._closed:
            return
        channel.channel.log(data, log_time=stamp)
        self.sent += 1
        self.sent_bytes += len(data)

    def clogged(self) -> None:
        """The door: the client does not read what it is sent."""
        self._clogged = True

    def drained(self) -> None:
        """The door: it has read it. In its thread, where some more is handed on."""
        self._clogged = False
        self._flush()

    def _flush(self) -> None:
        handed = 0
        with self._sending:
            while not self._clogged and handed < BATCH:
                waiting = self._outbox.take()
                if waiting is None:
                    return
                if not waiting[0].closed:
                    self._log(*waiting)
                handed += len(waiting[1])
        if not self._clogged:
            self.house.later(PAUSE, self._flush)

    def differs(self, channel: Shown, description: TopicDescription) -> None:
        """A publisher has sent another definition than was told."""
        self.house.heard(channel.topic, description)

    # -- what the client does -------------------------------------------------------------------------------

    def advertised(self, client: int, channel: Any) -> None:
        """The SDK: the client publishes a topic."""
        if hmac.compare_digest(str(channel.topic).encode(), self._secret.encode()):
            with self._lock:
                self._client = client if self._client is None else self._client
        elif self._is_ours(client):
            self._writing.add(lambda: self._advertise(channel))

    def _advertise(self, channel: Any) -> None:
        if self._closed:
            return
        try:
            if len(self._adverts) + len(self._not_open) >= self.house.limits.advertised_per_client:
                most = self.house.limits.advertised_per_client
                raise Refused(f"{most} topics are published: no more for this client")
            self._leave_advert(channel.id)
            self._adverts[channel.id] = self.house.client_topics.advertise(self, channel)
        except NotOpen as problem:
            self._not_open[channel.id] = str(problem)
        except (Refused, RosError) as problem:
            self.house.refusals += 1
            self.status(str(problem))

    def message(self, client: int, channel: int, data: bytes) -> None:
        """The SDK: the client publishes a message."""
        if self._is_ours(client):
            self._writing.add(lambda: self._publish(channel, data), droppable=True)

    def _publish(self, channel: int, data: bytes) -> None:
        advert = self._adverts.get(channel)
        if self._closed:
            return
        if advert is None:
            refusal = self._not_open.get(channel)  # else told so when it was advertised
            if refusal is not None:
                self.house.refusals += 1
                self.status(refusal)
            return
        try:
            self.house.client_topics.publish(advert, data)
            self.published += 1
        except (Refused, RosError) as problem:
            self.status(str(problem))

    def unadvertised(self, client: int, channel: int) -> None:
        """The SDK: the client publishes it no more, or is gone."""
        if client == self._client:
            self._writing.add(lambda: self._leave_advert(channel))

    def _leave_advert(self, channel: int) -> None:
        self._not_open.pop(channel, None)
        advert = self._adverts.pop(channel, None)
        if advert is not None:
            advert.close()

    def get_parameters(self, client: int, names: list[str]) -> list[Any]:
        """The SDK: the client asks for values. It waits for the answer, some seconds at most."""
        if not self._is_ours(client):
            return []
        try:
            found = self.house.parameters.get(names)
        except RosError as problem:
            text = f"parameters cannot be told: {problem}"
            self._reading.add(lambda: self.status(text))
            return []
        return [shown(name, value) for name, value in found.items()]

    def set_parameters(self, client: int, parameters: list[Any]) -> list[Any]:
        """The SDK: the client sets values; what it gets back is how they are then."""
        if not self._is_ours(client):
            return []
        for parameter in parameters[: self.house.limits.subscriptions_per_client]:
            problem = self.house.parameters.set(parameter.name, parameter.get_value())
            if problem is not None:
                self.house.refusals += 1
                self._reading.add(lambda text=problem: self.status(text))  # type: ignore[misc]
        names = [parameter.name for parameter in parameters]
        try:
            found = self.house.parameters.get(names) if names else {}
        except RosError:
            return []
        return [shown(name, found.get(name)) for name in names]

    def follow_parameters(self, names: list[str]) -> None:
        """The SDK: the client wants to know when these change."""

        def follow() -> None:
            problem = self.followed.follow(names)
            if problem is not None:
                self.status(problem)

        self._reading.add(follow)

    def leave_parameters(self, names: list[str]) -> None:
        """The SDK: no more."""
        self._reading.add(lambda: self.followed.leave(names))

    def _parameters_changed(self, parameters: list[Any]) -> None:
        if not self._closed:
            self.server.publish_parameter_values(parameters)

    def want_graph(self, wanted: bool) -> None:
        """The SDK: the client wants to see who talks to whom, or does not any more."""
        self._graph_wanted = wanted
        if wanted:
            self._reading.add(self._show_graph)

    def _show_graph(self) -> None:
        if self._graph_wanted and not self._closed:
            self.server.publish_connection_graph(connection_graph(self.house.view, self.house.access))

    # -- the end --------------------------------------------------------------------------------------------

    @property
    def topics(self) -> tuple[str, ...]:
        """What the client follows now."""
        return self.channels.followed

    @property
    def dropped(self) -> dict[str, int]:
        """Messages that were not sent to it because it did not read, by topic."""
        return {str(key): count for key, count in self._outbox.dropped.items()}

    def stop(self) -> None:
        """End the connection; what was followed is left by `close`."""
        with self._lock:
            if self._closed:
                return
            self._closed = True
        self.server.stop()

    def close(self) -> None:
        """End it: zeros where it drove, then everything is left. May take as long as the master does."""
        self.stop()
        self.house.guard.gone(self)
        self._reading.close()
        self._writing.close()
        self._outbox.close()
        for channel in tuple(self._adverts):
            self._leave_advert(channel)
        self.channels.close()
        self.followed.close()
        self.house.gone(self)

    def __repr__(self) -> str:
        return f"<Session of {self.peer}, {len(self.topics)} topics>"


class _Follower:
    """Takes the messages of one topic for one client."""

    def __init__(self, session: Session, channel: Shown) -> None:
        self._session = session
        self._channel = channel
        self._same: TopicDescription | None = None

    def offer(self, sample: Sample) -> None:
        """See `Receiver`."""
        description = sample.description
        if description is not self._same:
            told = self._channel.described
            if (description.md5sum, description.type_name) != (told.md5sum, told.type_name):
                self._session.differs(self._channel, description)
                return  # the client would read it wrongly; it gets it under the new channel
            self._same = description
        self._session.send(self._channel, sample)


def _listener(session: Session) -> Any:
    """What the SDK calls; never raises, never waits but for parameters."""

    class Listener:
        def on_subscribe(self, client: Any, channel: Any) -> None:
            session.subscribed(client.id, channel.id)

        def on_unsubscribe(self, client: Any, channel: Any) -> None:
            session.unsubscribed(client.id, channel.id)

        def on_client_advertise(self, client: Any, channel: Any) -> None:
            session.advertised(client.id, channel)

        def on_client_unadvertise(self, client: Any, client_channel_id: int) -> None:
            session.unadvertised(client.id, client_channel_id)

        def on_message_data(self, client: Any, client_channel_id: int, data: bytes) -> None:
            session.message(client.id, client_channel_id, data)

        def on_get_parameters(
            self, client: Any, param_names: list[str], request_id: str | None = None
        ) -> list[Any]:
            return session.get_parameters(client.id, param_names)

        def on_set_parameters(
            self, client: Any, parameters: list[Any], request_id: str | None = None
        ) -> list[Any]:
            return session.set_parameters(client.id, parameters)

        def on_parameters_subscribe(self, param_names: list[str]) -> None:
            session.follow_parameters(param_names)

        def on_parameters_unsubscribe(self, param_names: list[str]) -> None:
            session.leave_parameters(param_names)

        def on_connection_graph_subscribe(self) -> None:
            session.want_graph(True)

        def on_connection_graph_unsubscribe(self) -> None:
            session.want_graph(False)

    return Listener()
