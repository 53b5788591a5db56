"""Joins the master; then watches it and our own address, once a second, and puts things right again.

* The master restarted (another process, or it does not know our name): everything is registered again. No
  peer does this; rospy and roscpp are forgotten for ever (docs/wire.md, 59).
* The master is away: asked again after 0.1 to 0.5 s, so that it is noticed within 2 s when it is back.
* Our address towards the master changed (Wi-Fi, DHCP): the node listens on the new one and registers it.
* Now and then the whole graph is compared: a registration that got lost for any other reason is made again,
  and publishers that we were not told of are asked for. Behind a firewall that lets nobody in, which is where
  most laptops are, the master's `publisherUpdate` never arrives.
* Subscribers that got datagrams and are gone are forgotten.
* A link that cannot reach its publisher has the master asked too: the publisher may be elsewhere by now.
* The computer slept (a laptop's lid): every subscriber's link is made anew at once, and the graph compared.
  What the links bring from before the sleep is late, and many are dead without knowing.
* A `publisherUpdate` that did not come from the master's address is checked here by asking the master.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Collection, Sequence
from typing import NamedTuple, Protocol

from rosproto.errors import ConnectionLost, MasterError, RosError, RosTimeout
from rosproto.logs import get_logger
from rosproto.node.context import Context
from rosproto.node.events import Event, EventKind, without_frames
from rosproto.node.graph import api_client
from rosproto.node.graph.listening import Endpoints
from rosproto.node.graph.master_client import MasterClient, SystemState
from rosproto.node.graph.registrations import Registration
from rosproto.sentence import say
from rosproto.transport.backoff import Backoff
from rosproto.transport.deadline import Deadline, SleepDetector
from rosproto.transport.name_lookup import resolve
from rosproto.transport.os_errors import no_route
from rosproto.transport.own_address import choose_own_address
from rosproto.transport.uri import same_uri

_log = get_logger("rosproto.node")

PERIOD = 1.0  # seconds between two looks at a master that answers
CALL_TIMEOUT = 5.0
# An answer that takes longer is asked for once more on a new connection: the old one may be from an address
# that is no longer ours, or wait for the system to repeat what was lost.
PATIENCE = 2.0
FULL_CHECK_EVERY = 5  # looks
MOST_TO_VERIFY = 1000  # topics; more are not ours


class FollowedTopic(Protocol):
    """A subscribed topic, as far as its publishers are looked after here."""

    @property
    def name(self) -> str: ...

    def knows(self, publishers: Collection[str]) -> bool: ...

    def register(self, master: MasterClient) -> None: ...


class DatagramPeer(Protocol):
    """Somebody who gets datagrams, and whose end nobody tells."""

    @property
    def caller_id(self) -> str: ...

    @property
    def topic(self) -> str: ...

    def close(self) -> None: ...


class WatchedTopics(Protocol):
    """The topics of the node, as far as they are looked after here."""

    def subscription(self, name: str) -> FollowedTopic | None: ...

    def datagram_links(self) -> Sequence[DatagramPeer]: ...

    def links_changed_address(self) -> None: ...

    def woke_up(self) -> None: ...


class MasterMonitor:
    """One thread per node.

    Args:
        context: Of the node.
        topics: Its topics.
        listen: Opens its servers (`Listen`).
        moved: Told the old URI when they have been opened on another address.

    Attributes:
        period: Seconds between two looks at a master that answers.
        full_check_every: Looks between two comparisons of the whole graph.
    """

    def __init__(
        self,
        context: Context,
        topics: WatchedTopics,
        *,
        listen: Listen,
        moved: Callable[[str], None],
    ) -> None:
        self.period = PERIOD
        self.full_check_every = FULL_CHECK_EVERY
        self._context = context
        self._topics = topics
        self._listen, self._moved = listen, moved
        self._wake = threading.Condition()
        self._to_verify: dict[str, FollowedTopic] = {}
        self._hurry = False
        self._backoff = Backoff(first=0.1, factor=1.5, most=0.5, jitter=0.1)
        self._identity: object = None
        self._looks = 0
        self._sleep = SleepDetector()
        self._thread = threading.Thread(
            target=self._run, name=f"rosproto:master monitor {context.name}", daemon=True
        )

    def start(self) -> None:
        self._thread.start()

    def close(self, timeout: float) -> None:
        """End the thread (`context.closing` is set)."""
        with self._wake:
            self._wake.notify_all()
        if self._thread.ident is not None and threading.current_thread() is not self._thread:
            self._thread.join(timeout)

    @property
    def master_lost(self) -> bool:
        """True while the master does not answer."""
        return self._context.master_lost

    def verify(self, subscription: FollowedTopic) -> None:
        """Ask the master for the publishers of a topic, soon; many requests become one."""
        with self._wake:
            if len(self._to_verify) < MOST_TO_VERIFY:
                self._to_verify[subscription.name] = subscription
                self._hurry = True
                self._wake.notify_all()

    def hurry(self) -> None:
        """Look now: something is known to have changed."""
        with self._wake:
            self._hurry = True
            self._wake.notify_all()

    def _run(self) -> None:
        pause, took = self.period, 0.0
        while not self._context.closing.is_set():
            with self._wake:
                # Not "until something is to be verified": that stays so while the master is away.
                self._wake.wait_for(lambda: self._context.closing.is_set() or self._hurry, pause)
                self._hurry = False
            if self._context.closing.is_set():
                return
            try:
                self._notice_sleep(pause + took)  # a master that is slow to answer is no sleep
                begun = time.monotonic()
                pause = self._look()
                took = time.monotonic() - begun
            except Exception:
                _log.exception("! %s: the master monitor failed, and goes on", self._context.name)
                pause = self.period

    def _notice_sleep(self, meant: float) -> None:
        seconds = self._sleep.slept(meant)
        if seconds:
            _log.info(
                "= %s: this computer slept for %.0f s; all links are made anew", self._context.name, seconds
            )
            self._looks = self.full_check_every - 1
            self._topics.woke_up()

    def _look(self) -> float:
        """One round; returns the seconds until the next."""
        try:
            moved = self._follow_address()
            stands = self.check_registration() and not moved
            if not stands and not self._context.registrations.register_all():
                raise ConnectionLost(
                    "the master went away during registration", peer=self._context.master_uri
                )
            self._verify_some()
            if not self._context.registrations.register_pending():
                return self._backoff.next()
        except (ConnectionLost, RosTimeout) as error:
            self._master_lost(error)
            return self._backoff.next()
        except RosError as error:
            _log.warning("! master %s: %s", self._context.master_uri, error)
            return self.period
        self._master_answers(stands)
        return self.period

    def check_registration(self) -> bool:
        """False when the master has to be told everything again."""
        context = self._context
        before = context.registrations.confirmed()
        pid, uri, run_id = self._ask()
        identity = (pid, run_id)
        known, self._identity = self._identity, identity
        if self._context.master_lost or (known is not None and known != identity):
            return False
        if not self._still(before):
            return True
        if not isinstance(uri, str):
            return False
        if not same_uri(uri, context.uri):
            # Another node has our name: it was told to, and we were told to shut down. Do not fight over it.
            _log.debug("! %s is registered at %s, not at %s", context.name, uri, context.uri)
            return True
        self._looks += 1
        return self._looks % self.full_check_every != 0 or self.graph_has_all()

    def _ask(self) -> tuple[object, object, object]:
        """The master's process id, our URI as it knows it, its run id; one request where multicall works."""
        calls: list[tuple[str, tuple[object, ...]]] = [
            ("getPid", ()),
            ("lookupNode", (self._context.name,)),
            ("getParam", ("/run_id",)),
        ]
        master = self._context.master
        try:
            answers = master.several(calls, timeout=PATIENCE)
        except RosTimeout:
            answers = master.several(calls, timeout=CALL_TIMEOUT - PATIENCE)
        values = [None if isinstance(answer, MasterError) else answer for answer in answers]
        return values[0], values[1], values[2]

    def graph_has_all(self) -> bool:
        """Whether the master's graph has all that is registered."""
        context = self._context
        before = context.registrations.confirmed()
        datagram_links = self._topics.datagram_links()
        state = context.master.get_system_state(timeout=CALL_TIMEOUT)
        tables = {"publisher": state.publishers, "subscriber": state.subscribers, "service": state.services}
        self._note_unknown_publishers(state)
        self.forget_unsubscribed(datagram_links, state)
        return all(
            context.name in tables[registration.kind].get(registration.name, ())
            for registration in self._still(before)
            if registration.kind in tables
        )

    def _still(self, before: list[Registration]) -> list[Registration]:
        """Of these, what the master must know in an answer that was asked for after them: all but those taken
        back meanwhile. What was being made then is not among them.
        """
        now = {id(registration) for registration in self._context.registrations.confirmed()}
        return [registration for registration in before if id(registration) in now]

    def _note_unknown_publishers(self, state: SystemState) -> None:
        """Have topics verified whose publishers are others than those we know."""
        for registration in self._context.registrations.of_kind("subscriber"):
            subscription = self._topics.subscription(registration.name)
            publishers = state.publishers.get(registration.name, ())
            if subscription is not None and not subscription.knows(publishers):
                self.verify(subscription)

    @staticmethod
    def forget_unsubscribed(links: Sequence[DatagramPeer], state: SystemState) -> None:
        """Let go of those who got datagrams and do not subscribe any more: their end is seen nowhere else.

        A restarted master knows nobody, and roscpp does not register again: who is unknown altogether stays.
        """
        known = {node for table in state for nodes in table.values() for node in nodes} if links else set()
        for link in links:
            if link.caller_id in known and link.caller_id not in state.subscribers.get(link.topic, ()):
                link.close()

    def _verify_some(self) -> None:
        with self._wake:
            to_verify, self._to_verify = self._to_verify, {}
        for subscription in to_verify.values():
            if self._topics.subscription(subscription.name) is subscription:
                subscription.register(self._context.master)

    def _follow_address(self) -> bool:
        """Listen on our present address towards the master; True when it is another one than before.

        Raises:
            ConnectionLost: There is no way to the master, the cable is out.
        """
        context = self._context
        old = context.uri
        try:
            if not rebind(context, self._listen, self._moved):
                return False
        except RosError as error:
            if no_route(error.__cause__):
                if not self._context.master_lost:
                    context.master.reconnect()  # calls under way fail now, not when their time is over
                raise
            # The name server is silent, or the port taken: that says nothing about the master.
            _log.debug("! %s: the present address is not known: %s", context.name, error)
            return False
        self._topics.links_changed_address()
        context.master.reconnect()
        _log.warning("= %s: our address changed, %s is now %s", context.name, old, context.uri)
        context.emit(Event(EventKind.ADDRESS_CHANGED, address=context.uri))
        return True

    def _master_lost(self, error: RosError) -> None:
        if not self._context.master_lost:
            self._context.master_lost = True
            _log.warning("! the master %s is away, it is tried again: %s", self._context.master_uri, error)
            known = without_frames(error)
            self._context.emit(Event(EventKind.MASTER_LOST, address=self._context.master_uri, error=known))

    def _master_answers(self, stood: bool) -> None:
        self._backoff.reset()
        if self._context.master_lost or not stood:
            self._context.master_lost = False
            _log.warning("= master %s: everything is registered again", self._context.master_uri)
            self._context.emit(Event(EventKind.MASTER_BACK, address=self._context.master_uri))


REBIND_SECONDS = 1.0  # for looking up names, and for ending what used the old address


Listen = Callable[[str, str], Endpoints]
"""Opens the servers of the node: the host to announce, the address to listen on."""


class GraphFacts(NamedTuple):
    """What holds for the whole graph while a node is open.

    Attributes:
        simulated: Time comes from /clock.
        rosout_topics: Records on /rosout list the topics of their node.
    """

    simulated: bool
    rosout_topics: bool


def ask_facts(master: MasterClient, timeout: float | None) -> GraphFacts:
    """Ask a master, in one request, whether it is one and how its graph is set up.

    Raises:
        ConnectionLost, RosTimeout: Nobody answers.
        RosError: What answers is no master.
    """
    pid, sim_time, no_topics = master.several(
        [
            ("getPid", ()),
            ("getParam", ("/use_sim_time",)),
            ("getParam", ("/rosout_disable_topics_generation",)),
        ],
        timeout=timeout,
    )
    if isinstance(pid, MasterError):
        raise pid
    api_client.checked("getPid", master.uri, pid, api_client.as_int)
    return GraphFacts(
        simulated=sim_time is True,  # an error means that it is not set
        rosout_topics=isinstance(no_topics, MasterError) or not no_topics,
    )


def join(context: Context, listen: Listen, deadline: Deadline) -> tuple[Endpoints, GraphFacts]:
    """Find the master, then listen: a node that cannot register need not open a port.

    Raises:
        ConnectionLost, RosTimeout: The node cannot join; the text names it and the master.
    """
    try:
        facts = ask_facts(context.master, deadline.remaining())
        context.master_hosts = frozenset(resolve(context.master_address[0], deadline))
        announced, bind = choose_own_address(
            context.host_given, context.master_address, deadline.remaining() or 0.1
        )
        return listen(announced, bind), facts
    except RosError as error:
        raise _cannot_join(context, error) from error


def _cannot_join(context: Context, error: RosError) -> RosError:
    cannot = "node {name} cannot join the master {uri}: {error}"
    text = say(cannot, name=context.name, uri=context.master_uri, error=error)
    peer, why = context.master_uri, error.why or str(error)
    if isinstance(error, RosTimeout):
        what = f"the master {context.master_uri}"
        return RosTimeout(text, what=what, seconds=error.seconds, peer=peer, why=why)
    return ConnectionLost(text, peer=peer, why=why)


def rebind(context: Context, listen: Listen, moved: Callable[[str], None]) -> bool:
    """Listen on our present address towards the master, when it is another one now; True when it is.

    `moved` is called with the URI that holds no more, before what used it ends.

    Raises:
        RosError: There is no way to the master at present, or nothing can be listened on.
    """
    if context.host_given is not None:
        return False
    announced, bind = choose_own_address(None, context.master_address, REBIND_SECONDS)
    old = context.endpoints
    if announced == old.host:
        return False
    new = listen(announced, bind)
    new.tcpros.on_service = old.tcpros.on_service
    context.endpoints = new
    moved(old.uri)
    old.close(REBIND_SECONDS)
    return True
