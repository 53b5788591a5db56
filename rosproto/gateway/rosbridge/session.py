"""`RosbridgeSession`: carries out the messages of one client, in order.

`protocol.py` reads the messages. Topics and authentication are handled here, calls and goals in
`calls_and_goals.py` and `advertised_by_client.py`. Work that may take time (calls of the master) runs in a
thread of the pool while the client's next message waits. Refusals and failures are answered with a sentence;
no message raises here.
"""

from __future__ import annotations

import asyncio
import threading
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

from rosproto.codec import Message
from rosproto.errors import RosError
from rosproto.gateway.access import Refused, insist
from rosproto.gateway.client_channel import ClientChannel
from rosproto.gateway.client_publications import ClientPublication
from rosproto.gateway.rosbridge import operations
from rosproto.gateway.rosbridge.advertised_by_client import AdvertisedActions, AdvertisedServices
from rosproto.gateway.rosbridge.calls_and_goals import ActionGoals, ServiceCalls
from rosproto.gateway.rosbridge.fields import Id
from rosproto.gateway.rosbridge.operations import Payload, Request, op_of
from rosproto.gateway.rosbridge.protocol import Protocol
from rosproto.gateway.rosbridge.server_state import ServerState
from rosproto.gateway.rosbridge.subscription import TopicSubscription
from rosproto.gateway.topic_type import insist_type, topic_type
from rosproto.gateway.values import definition_name, from_values
from rosproto.gateway.velocity_watchdog import is_velocity
from rosproto.time import Time

UNAUTHENTICATED_BYTES = 4 << 10  # longest message before authentication
MAX_PAUSE = 0.1  # seconds after a long message was read
NOT_AUTHENTICATED = 1008  # close code: policy violation (RFC 6455, 7.4.1)
AUTHENTICATE = "authenticate"
AUTHENTICATION = "rosauth/Authentication"
NOT_CHECKED = (
    "credentials of rosauth are not checked here (--authenticate); who connects shows a token, as ?token=..."
    " in the URL or as Authorization: Bearer ..."
)


class RosbridgeSession:
    """One client.

    Args:
        state: Shared by all sessions.
        channel: Sends to the client.
    """

    def __init__(self, state: ServerState, channel: ClientChannel) -> None:
        self.channel = channel
        self._state = state
        self._limits = state.limits
        self._protocol = Protocol(state.limits, state.json)
        self._subscriptions: dict[str, TopicSubscription] = {}
        self._subscribing = threading.Lock()
        self._publications: dict[str, ClientPublication] = {}
        self._advertised: dict[str, set[Id]] = {}
        self._credentials_came = False
        self._authenticated = not state.authenticate
        self._received = 0.0  # when the message that is carried out now came
        if state.authenticate:
            channel.later(state.limits.handshake_seconds, self._authentication_timed_out)
        self._calls = ServiceCalls(state, self._protocol, channel)
        self._services = AdvertisedServices(state, self._protocol, channel)
        self._actions = AdvertisedActions(state, self._protocol, channel)
        self._goals = ActionGoals(state, self._protocol, channel)
        self._perform: dict[type, Callable[[Any], None]] = {
            operations.Subscribe: self._subscribe,
            operations.Unsubscribe: self._unsubscribe,
            operations.Advertise: self._advertise,
            operations.Unadvertise: self._unadvertise,
            operations.Publish: self._publish,
            operations.CallService: self._calls.call,
            operations.AdvertiseService: self._services.advertise,
            operations.UnadvertiseService: self._services.unadvertise,
            operations.ServiceResponse: self._services.answer,
            operations.SendActionGoal: self._goals.send,
            operations.CancelActionGoal: self._goals.cancel,
            operations.AdvertiseAction: self._actions.advertise,
            operations.UnadvertiseAction: self._actions.unadvertise,
            operations.ActionFeedback: self._actions.feedback,
            operations.ActionResult: self._actions.answer,
            operations.Auth: self._check_credentials,
        }

    @property
    def subscriptions(self) -> tuple[TopicSubscription, ...]:
        """The subscriptions of the client."""
        return tuple(self._subscriptions.values())

    # -- in -------------------------------------------------------------------------------------------------

    async def received(self, data: Payload) -> None:
        """Carry out one message; in the server's loop."""
        self._received = time.monotonic()
        await self._carry_out_all(self._protocol.receive(data, self._received, at_once=True), long=False)

    @property
    def max_message_bytes(self) -> int:
        """Longest next message in bytes."""
        limit = self._state.max_message_bytes
        return limit if self._authenticated else min(UNAUTHENTICATED_BYTES, limit)

    async def _carry_out_all(self, asked: list[Request], *, long: bool) -> None:
        """Carry out the requests of one message, in order.

        Args:
            asked: The requests.
            long: The message was long, so it may also take time to carry out.
        """
        for request in asked:
            if self.channel.ending is not None or self.channel.lost:
                return
            if isinstance(request, operations.LongMessage):
                async with self._state.long_messages:
                    if self.channel.lost:
                        return
                    await self._carry_out_all(await self._read_long(request), long=True)
            elif not self._authenticated:
                await self._state.pool.run(partial(self._authenticate, request))
            elif isinstance(request, operations.Reply):
                self.channel.answer(request.payloads)
            elif isinstance(request, operations.Close):
                self.channel.close(request.code, request.reason)
            elif not long and self._is_quick(request):
                self._carry_out(request)
            else:
                if isinstance(request, (operations.CallService, operations.SendActionGoal)):
                    request = replace(request, long=long)
                await self._state.pool.run(partial(self._carry_out, request))

    async def _read_long(self, message: operations.LongMessage) -> list[Request]:
        """Read a long message, then pause for as long, so that other clients are served."""
        async with self._state.reading:
            began = time.monotonic()
            try:
                return await self._state.pool.run(message.read)
            finally:
                await asyncio.sleep(min(time.monotonic() - began, MAX_PAUSE))

    def _is_quick(self, request: Request) -> bool:
        """Whether a request is carried out without waiting."""
        if isinstance(request, operations.Publish):
            return request.topic in self._publications
        quick = (operations.ServiceResponse, operations.SetLevel, operations.Auth, operations.CallService)
        return isinstance(request, (*quick, operations.SendActionGoal, operations.ActionResult))

    def _carry_out(self, request: operations.Operation) -> None:
        perform = self._perform.get(type(request))
        if perform is None:
            return  # handled by the protocol
        op = op_of(type(request))
        try:
            perform(request)
        except (Refused, RosError, ValueError) as error:
            self._report(f"{op}: {error}", request.id)
            self._state.peer_log.info(op, "! rosbridge: %s to %s: %s", op, self.channel.peer, error)
        except Exception as error:
            self._report(f"{op}: an error of the gateway ({type(error).__name__})")
            self._state.peer_log.error(
                "session", "! rosbridge: %s of %s", request, self.channel.peer, exc_info=error
            )

    def _report(self, text: str, id: Id = None) -> None:
        self.channel.answer(self._protocol.status("error", text, id))

    # -- subscriptions --------------------------------------------------------------------------------------

    def _subscribe(self, asked: operations.Subscribe) -> None:
        name = self._state.node.resolve_name(asked.topic)
        insist(self._state.access.may_read("topic", name))
        subscription = self._subscriptions.get(asked.topic)
        if subscription is not None:
            if subscription.count >= self._limits.subscriptions_per_client:
                raise Refused(f"{asked.topic} is subscribed {subscription.count} times already")
            subscription.add(asked)
            return
        if len(self._subscriptions) >= self._limits.subscriptions_per_client:
            raise Refused(f"{len(self._subscriptions)} topics are subscribed: the limit for a client")
        if asked.type:
            insist_type(self._state.node, name, definition_name(asked.type))
        subscription = TopicSubscription(
            asked.topic, self.channel, self._protocol.split, self._undecodable, self._other_type
        )
        subscription.add(asked)
        self._subscriptions[asked.topic] = subscription
        try:
            subscription.opened(self._state.shared_subscriptions.open(name, subscription))
        except BaseException:
            self._forget(subscription)
            raise

    def _other_type(self, subscription: TopicSubscription, type_name: str) -> None:
        """A topic that appeared later has not the client's type: end the subscription, in another thread."""
        self._report(
            f"subscribe: {subscription.topic} is of type {type_name[:200]}, not {subscription.type_name};"
            " the subscription is ended"
        )
        self._forget(subscription)
        self._state.pool.spawn(subscription.leave)

    def _forget(self, subscription: TopicSubscription) -> None:
        with self._subscribing:
            if self._subscriptions.get(subscription.topic) is subscription:
                del self._subscriptions[subscription.topic]

    def _undecodable(self, topic: str, error: RosError) -> None:
        self._report(f"subscribe: {topic} cannot be decoded: {error}")

    def _unsubscribe(self, asked: operations.Unsubscribe) -> None:
        subscription = self._subscriptions.get(asked.topic)
        if subscription is not None and subscription.remove(asked.id):
            self._forget(subscription)
            subscription.close()

    # -- publications ---------------------------------------------------------------------------------------

    def _advertise(self, asked: operations.Advertise) -> None:
        self._open(asked.topic, definition_name(asked.type), latch=asked.latch, queue_size=asked.queue_size)
        ids = self._advertised.setdefault(asked.topic, set())
        if len(ids) < self._limits.advertised_per_client:
            ids.add(asked.id)

    def _open(self, topic: str, type_name: str, *, latch: bool, queue_size: int) -> ClientPublication:
        name = self._state.node.resolve_name(topic)
        if not self._state.tf.opens(name):
            insist(self._state.access.may_write("topic", name, type_name))
        known = self._publications.get(topic)
        if known is not None:
            if (advertised := known.message_class._type) != type_name:
                raise Refused(f"{topic} is already advertised as {advertised}, not {type_name}")
            return known
        if len(self._publications) >= self._limits.advertised_per_client:
            raise Refused(f"{len(self._publications)} topics are advertised: the limit for a client")
        message: type[Message] = self._state.message_class(type_name)
        opened = self._state.publications.open(self, name, message, latch=latch, queue_size=queue_size)
        self._publications[topic] = opened
        return opened

    def _unadvertise(self, asked: operations.Unadvertise) -> None:
        ids = self._advertised.get(asked.topic, set())
        ids.discard(asked.id)
        if asked.id is not None and ids:
            return
        self._advertised.pop(asked.topic, None)
        publication = self._publications.pop(asked.topic, None)
        if publication is not None:
            publication.close()

    def _publish(self, asked: operations.Publish) -> None:
        publication = self._publications.get(asked.topic)
        if publication is None:
            name = self._state.node.resolve_name(asked.topic)
            if not self._state.tf.opens(name):
                insist(self._state.access.may_write("topic", name))
            type_name = topic_type(self._state.node, name)
            if type_name is None:
                raise Refused(f"the type of {asked.topic} is unknown: advertise it first")
            publication = self._open(asked.topic, type_name, latch=asked.latch, queue_size=asked.queue_size)
        if self.channel.gone and is_velocity(publication.message_class):
            return  # a velocity that waited while its client left
        now = self._state.node.clock.now()
        self._state.tf.publishes(self, publication.topic, asked.msg)
        publication.publish(from_values(publication.message_class, asked.msg, now=now), self._received)

    # -- authentication -------------------------------------------------------------------------------------

    def _authenticate(self, request: Request) -> None:
        """Handle the first message: credentials that are accepted, or the connection is closed."""
        try:
            if not isinstance(request, operations.Auth):
                raise Refused("send auth before anything else")
            self._check_credentials(request)
        except (Refused, RosError) as problem:
            self._state.peer_log.warning(
                "auth", "! rosbridge: %s is not authenticated: %s", self.channel.peer, problem
            )
            self.channel.close(NOT_AUTHENTICATED, f"not authenticated: {problem}")

    def _authentication_timed_out(self) -> None:
        if not self._credentials_came:
            self.channel.close(NOT_AUTHENTICATED, "not authenticated: no credentials came in time")

    def _check_credentials(self, asked: operations.Auth) -> None:
        """Have the service check credentials; waits for its answer.

        As in rosbridge_suite with its parameter ~authenticate, the first message of a client must be an
        `auth`, whose fields the service `authenticate` (rosauth/Authentication) checks. Unlike there, the
        connection also ends if the service cannot be called, or no credentials arrive in time.

        Raises:
            Refused: They are not accepted, or not required.
            RosError: The service cannot be called.
        """
        self._credentials_came = True
        if self._authenticated:
            known = "the client has authenticated already"
            raise Refused(known if self._state.authenticate else NOT_CHECKED)
        service = self._state.service_class(AUTHENTICATION)
        try:
            request = service.Request(
                mac=asked.mac,
                client=asked.client,
                dest=asked.dest,
                rand=asked.rand,
                t=Time(asked.t),
                level=asked.level,
                end=Time(asked.end),
            )
        except (TypeError, ValueError, OverflowError) as problem:
            raise Refused(f"t and end must be times in seconds: {problem}") from None
        seconds = self._limits.call_seconds
        with self._state.waiting(), self._state.node.service_client(AUTHENTICATE, service) as client:
            if not client.call(request, timeout=seconds).authenticated:
                raise Refused("the credentials are not accepted")
        self._authenticated = True

    # -- the end --------------------------------------------------------------------------------------------

    def ended(self) -> None:
        """The client has gone: send zero where it drove, then close everything that it had opened."""
        self._state.publications.velocity_watchdog.gone(self)
        for publication in list(self._publications.values()):
            publication.close()
        for subscription in list(self._subscriptions.values()):
            subscription.close()
        self._state.tf.gone(self)
        self._services.close()
        self._actions.close()
        self._goals.close()
        self._calls.close()
        self._publications.clear()
        self._subscriptions.clear()
