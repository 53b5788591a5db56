"""Watches the master and our address once a second; registers again, or moves, when one of them changed.

* The master restarted (another process, or it does not know our name): everything is registered again. No
  peer does this; rospy and roscpp stay unregistered (docs/wire.md, 59).
* The master is away: it is asked again after 0.1 to 0.5 s, so that its return is noticed within 2 s.
* Our address towards the master changed (Wi-Fi, DHCP): the node listens on the new one and registers it.
* Every few rounds the whole graph is compared: a registration that was lost for any other reason is repeated,
  and unknown publishers are asked for. The master's `publisherUpdate` never arrives behind a firewall that
  blocks incoming connections, as most laptops have.
* Links to datagram subscribers that have gone are closed.
* A link that cannot reach its publisher asks for a check, too: the publisher may have moved.
* The computer slept (a laptop's lid): all links to publishers reconnect at once, and the graph is compared.
  Messages from before the sleep are late, and many connections are dead.
* A `publisherUpdate` that did not come from the master's address is checked by asking the master.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence

from rosproto.errors import ConnectionLost, MasterError, RosError, RosTimeout
from rosproto.logs import get_logger
from rosproto.node.context import Context
from rosproto.node.events import Event, EventKind, without_frames
from rosproto.node.graph.master_client import SystemState
from rosproto.node.graph.registrations import Registration
from rosproto.node.incoming.subscription import Subscription
from rosproto.node.outgoing.datagram_link import DatagramLink
from rosproto.node.topics import TopicTable
from rosproto.transport.backoff import Backoff
from rosproto.transport.deadline import SleepDetector
from rosproto.transport.os_errors import no_route
from rosproto.transport.uri import same_uri

_log = get_logger("rosproto.node")

PERIOD = 1.0  # seconds between two looks at a master that answers
CALL_TIMEOUT = 5.0
# After this time the question is repeated on a new connection: the old one may be from an address that is no
# longer ours, or wait for a retransmission.
PATIENCE = 2.0
FULL_CHECK_EVERY = 5  # looks
MAX_TO_VERIFY = 1000  # topics; more are not ours


class MasterMonitor:
    """One thread per node.

    Args:
        context: Of the node.
        topics: Its topics.
        moved: Called with the old URI when the node's servers have been opened on another address.

    Attributes:
        period: Seconds between two looks at a master that answers.
        full_check_every: Looks between two comparisons of the whole graph.
    """

    def __init__(self, context: Context, topics: TopicTable, moved: Callable[[str], None]) -> None:
        self.period = PERIOD
        self.full_check_every = FULL_CHECK_EVERY
        self._context = context
        self._name = context.name
        self._topics = topics
        self._moved = moved
        self._wake = threading.Condition()
        self._to_verify: dict[str, Subscription] = {}
        self._check_due = False
        self._backoff = Backoff(first=0.1, factor=1.5, maximum=0.5, jitter=0.1)
        self._identity: object = None
        self._looks = 0
        self._sleep = SleepDetector()
        name = f"rosproto:master monitor {context.name}"
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)

    def start(self) -> None:
        self._thread.start()

    def close(self, timeout: float) -> None:
        """End the thread (the node is closing)."""
        with self._wake:
            self._wake.notify_all()
        if self._thread.ident is not None and threading.current_thread() is not self._thread:
            self._thread.join(timeout)

    def check_publishers(self, subscription: Subscription) -> None:
        """Ask the master soon for the publishers of a topic; several requests become one."""
        with self._wake:
            if len(self._to_verify) < MAX_TO_VERIFY:
                self._to_verify[subscription.name] = subscription
                self._check_due = True
                self._wake.notify_all()

    def check_now(self) -> None:
        """Start the next round now: something is known to have changed."""
        with self._wake:
            self._check_due = True
            self._wake.notify_all()

    def _run(self) -> None:
        pause, took = self.period, 0.0
        while not self._context.lifecycle.closed:
            with self._wake:
                # Not "until there is a topic to verify": there is one as long as the master is away.
                self._wake.wait_for(lambda: self._context.lifecycle.closed or self._check_due, pause)
                self._check_due = False
            if self._context.lifecycle.closed:
                return
            try:
                self._notice_sleep(pause + took)  # waiting for a slow master is not a sleep
                begun = time.monotonic()
                pause = self._look()
                took = time.monotonic() - begun
            except Exception:
                _log.exception("! %s: the master monitor failed; it continues", self._name)
                pause = self.period

    def _notice_sleep(self, meant: float) -> None:
        seconds = self._sleep.slept(meant)
        if seconds:
            _log.info("= %s: this computer slept for %.0f s; all links are reconnected", self._name, seconds)
            self._looks = self.full_check_every - 1
            self._topics.woke_up()

    def _look(self) -> float:
        """One round; returns the seconds until the next."""
        try:
            moved = self._follow_address()
            stands = self.check_registration() and not moved
            if not stands and not self._context.registrations.register_all():
                raise ConnectionLost(
                    "the connection to the master was lost during registration", peer=self._context.master.uri
                )
            self._verify_some()
            if not self._context.registrations.register_pending():
                return self._backoff.next()
        except (ConnectionLost, RosTimeout) as error:
            self._master_lost(error)
            return self._backoff.next()
        except RosError as error:
            _log.warning("! master %s: %s", self._context.master.uri, error)
            return self.period
        self._master_answers(stands)
        return self.period

    def check_registration(self) -> bool:
        """False if everything has to be registered again."""
        before = self._context.registrations.confirmed()
        pid, uri, run_id = self._ask()
        identity = (pid, run_id)
        known, self._identity = self._identity, identity
        if self._context.master_lost or (known is not None and known != identity):
            return False
        if not self._still(before):
            return True
        if not isinstance(uri, str):
            return False
        if not same_uri(uri, self._context.uri):
            # Another node has taken our name, and the master asked us to shut down: do not register again.
            _log.debug("! %s is registered at %s, not at %s", self._name, uri, self._context.uri)
            return True
        self._looks += 1
        return self._looks % self.full_check_every != 0 or self.graph_has_all()

    def _ask(self) -> tuple[object, object, object]:
        """The master's process id, our URI as it knows it, its run id; one request where multicall works."""
        calls: list[tuple[str, tuple[object, ...]]] = [
            ("getPid", ()),
            ("lookupNode", (self._name,)),
            ("getParam", ("/run_id",)),
        ]
        master = self._context.master
        try:
            answers = master.batch(calls, timeout=PATIENCE)
        except RosTimeout:
            answers = master.batch(calls, timeout=CALL_TIMEOUT - PATIENCE)
        values = [None if isinstance(answer, MasterError) else answer for answer in answers]
        return values[0], values[1], values[2]

    def graph_has_all(self) -> bool:
        """Whether the master's graph has all that is registered."""
        before = self._context.registrations.confirmed()
        datagram_links = self._topics.datagram_links()
        state = self._context.master.get_system_state(timeout=CALL_TIMEOUT)
        tables = {"publisher": state.publishers, "subscriber": state.subscribers, "service": state.services}
        self._note_unknown_publishers(state)
        self.forget_unsubscribed(datagram_links, state)
        return all(
            self._name in tables[registration.kind].get(registration.name, ())
            for registration in self._still(before)
            if registration.kind in tables
        )

    def _still(self, before: list[Registration]) -> list[Registration]:
        """Of the registrations confirmed before a question, those that the answer must contain: all that were
        not removed meanwhile.
        """
        now = {id(registration) for registration in self._context.registrations.confirmed()}
        return [registration for registration in before if id(registration) in now]

    def _note_unknown_publishers(self, state: SystemState) -> None:
        """Verify the topics whose publishers differ from those we know."""
        for registration in self._context.registrations.of_kind("subscriber"):
            subscription = self._topics.subscription(registration.name)
            publishers = state.publishers.get(registration.name, ())
            if subscription is not None and not subscription.knows(publishers):
                self.check_publishers(subscription)

    @staticmethod
    def forget_unsubscribed(links: Sequence[DatagramLink], state: SystemState) -> None:
        """Close links to datagram subscribers that have unsubscribed: nothing else reports their end.

        A link to a node that the master does not know at all is kept: roscpp does not register again at a
        restarted master.
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
                self._context.registrations.announce(subscription)

    def _follow_address(self) -> bool:
        """Listen on our present address towards the master; True if it has changed.

        Raises:
            ConnectionLost: There is no route to the master, e.g. the cable is unplugged.
        """
        old = self._context.uri
        try:
            if not self._context.listening.follow(self._context.master_address, self._moved):
                return False
        except RosError as error:
            if no_route(error.__cause__):
                if not self._context.master_lost:
                    self._context.master.reconnect()  # calls under way fail now, not when their time is over
                raise
            # The name server is silent, or the port is taken: the master may be there.
            _log.debug("! %s: the current address cannot be determined: %s", self._name, error)
            return False
        self._topics.links_changed_address()
        self._context.master.reconnect()
        _log.warning("= %s: our address changed, %s is now %s", self._name, old, self._context.uri)
        self._context.events.emit(Event(EventKind.ADDRESS_CHANGED, address=self._context.uri))
        return True

    def _master_lost(self, error: RosError) -> None:
        if not self._context.master_lost:
            self._context.master_lost, uri = True, self._context.master.uri
            _log.warning("! the master %s cannot be reached; trying again: %s", uri, error)
            known = without_frames(error)
            self._context.events.emit(Event(EventKind.MASTER_LOST, address=uri, error=known))

    def _master_answers(self, stood: bool) -> None:
        self._backoff.reset()
        if self._context.master_lost or not stood:
            self._context.master_lost = False
            _log.warning("= master %s: everything is registered again", self._context.master.uri)
            self._context.events.emit(Event(EventKind.MASTER_BACK, address=self._context.master.uri))
