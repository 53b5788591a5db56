"""Watches the master and our address once a second; registers again, or moves, when one of them changed.

All nodes of this process that have the same master are looked after in one round (`MasterWatch`): the master
is asked once for all of them, and its graph is read once. Each node compares the answers with its own
registrations (`MasterMonitor`).

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
from collections.abc import Callable, Hashable, Sequence
from concurrent.futures import Future
from typing import Any, TypeVar

from rosproto.errors import ConnectionLost, MasterError, RosError, RosTimeout
from rosproto.logs import get_logger
from rosproto.node.context import Context
from rosproto.node.events import Event, EventKind, without_frames
from rosproto.node.graph.master_client import LastGraph, SystemState
from rosproto.node.graph.registrations import Registration
from rosproto.node.incoming.subscription import Subscription
from rosproto.node.outgoing.datagram_link import DatagramLink
from rosproto.node.topics import TopicTable
from rosproto.transport.backoff import Backoff
from rosproto.transport.deadline import SleepDetector
from rosproto.transport.forking import on_fork
from rosproto.transport.os_errors import no_route
from rosproto.transport.own_address import choose_own_address
from rosproto.transport.shared_threads import shared_threads
from rosproto.transport.uri import same_uri

_log = get_logger("rosproto.node")
T = TypeVar("T")

PERIOD = 1.0  # seconds between two looks at a master that answers
CALL_TIMEOUT = 5.0
# After this time the question is repeated on a new connection: the old one may be from an address that is no
# longer ours, or wait for a retransmission.
PATIENCE = 2.0
FULL_CHECK_EVERY = 5  # looks
MAX_TO_VERIFY = 1000  # topics; more are not ours
MAX_LOOKUPS = 10  # nodes of this process whose names are looked up in one round, the others in the next ones
JOINED = 0.3  # of its pause: a node that is due so soon is looked after in the present round
ADDRESS_SECONDS = 1.0  # for a name lookup


class MasterView:
    """What the master says in one round, asked by the first node that wants to know it.

    Args:
        monitors: Of the nodes of this round.
        turn: Number of the round.
    """

    def __init__(self, monitors: Sequence[MasterMonitor], turn: int = 0) -> None:
        first = turn * MAX_LOOKUPS % len(monitors) if len(monitors) > MAX_LOOKUPS else 0
        self.names = [monitor.name for monitor in [*monitors[first:], *monitors[:first]][:MAX_LOOKUPS]]
        # Before the questions: only these can be expected in the answers.
        self.confirmed = {monitor: monitor.confirmed() for monitor in monitors}
        self.datagram_links = {monitor: monitor.datagram_links() for monitor in monitors}
        self._known: dict[str, Any] = {}

    def _once(self, what: str, ask: Callable[[], T], asker: MasterMonitor) -> T:
        if what not in self._known:
            try:
                self._known[what] = ask()
            except RosError as error:
                if asker.closed:
                    raise  # its own client is closed: the next node asks
                self._known[what] = error
        if isinstance(self._known[what], RosError):
            raise self._known[what]
        answer: T = self._known[what]
        return answer

    def identity(self, asker: MasterMonitor) -> tuple[object, object, object]:
        """The master's process id, the node's URI as the master knows it, the master's run id."""
        pid, run_id, uris = self._once("identity", lambda: asker.ask(self.names), asker)
        return pid, uris.get(asker.name, asker.uri), run_id

    @property
    def has_state(self) -> bool:
        """Whether the graph was read in this round."""
        return "state" in self._known

    def state(self, asker: MasterMonitor) -> SystemState:
        """The graph."""
        return self._once("state", asker.read_graph, asker)

    def own_address(self, asker: MasterMonitor) -> str:
        """This computer's address on the route to the master."""
        return self._once("address", asker.find_address, asker)


class MasterWatch:
    """The rounds of all nodes of this process with one master.

    Attributes:
        busy: Seconds that all rounds so far took.
    """

    def __init__(self) -> None:
        self.busy = 0.0
        self._changed = threading.Condition()
        self._monitors: list[MasterMonitor] = []
        self._present: MasterMonitor | None = None  # being looked after
        self._thread = 0  # in which a round runs
        self._turn = 0
        self._next: tuple[float, Future[None]] | None = None

    def join(self, monitor: MasterMonitor) -> None:
        """Look after this node, too."""
        with self._changed:
            self._monitors.append(monitor)
            self._plan()

    def leave(self, monitor: MasterMonitor) -> bool:
        """Look after this node no more; True if it was the last one."""
        with self._changed:
            if monitor in self._monitors:
                self._monitors.remove(monitor)
            return not self._monitors

    def wait_for(self, monitor: MasterMonitor, timeout: float) -> None:
        """Wait for the end of a look for this node, except in its thread."""
        with self._changed:
            if self._thread != threading.get_ident():
                self._changed.wait_for(lambda: self._present is not monitor, timeout)

    def hurry(self, monitor: MasterMonitor) -> None:
        """Begin a round for this node now."""
        with self._changed:
            monitor.due = 0.0
            self._plan()

    def _plan(self) -> None:
        """Have the next round begin when the first node is due; called with the lock held."""
        if self._thread or not self._monitors:
            return  # after this round
        due = min(monitor.due for monitor in self._monitors)
        if self._next is not None:
            if self._next[0] <= due:
                return
            self._next[1].cancel()
        task = shared_threads().add_later(max(0.0, due - time.monotonic()), self._round)
        self._next = due, task

    def _round(self) -> None:
        began = time.monotonic()
        with self._changed:
            self._next, self._thread = None, threading.get_ident()
            due = [monitor for monitor in self._monitors if monitor.due <= began + JOINED * monitor.pause]
            self._turn += 1
        view = MasterView(due, self._turn) if due else None
        for monitor in due:
            with self._changed:
                if monitor not in self._monitors:
                    continue
                self._present, monitor.due = monitor, float("inf")
            assert view is not None
            monitor.look(view, self.busy + time.monotonic() - began)
            with self._changed:
                self._present, monitor.due = None, min(monitor.due, time.monotonic() + monitor.pause)
                self._changed.notify_all()
        with self._changed:
            self.busy += time.monotonic() - began
            self._thread = 0
            self._plan()


_watches: dict[Hashable, MasterWatch] = {}
_watches_lock = threading.Lock()


class MasterMonitor:
    """The part of one node.

    Args:
        context: Of the node.
        topics: Its topics.
        moved: Called with the old URI when the node's servers have been opened on another address.

    Attributes:
        period: Seconds between two looks at a master that answers.
        full_check_every: Looks between two comparisons of the whole graph.
        name: Of the node.
        pause: Seconds until the next look.
        due: Monotonic time of the next look.
    """

    def __init__(self, context: Context, topics: TopicTable, moved: Callable[[str], None]) -> None:
        self.period = self.pause = PERIOD
        self.full_check_every = FULL_CHECK_EVERY
        self.name = context.name
        self.due = 0.0
        self._context = context
        self._topics = topics
        self._moved = moved
        self._lock = threading.Lock()
        self._watch: MasterWatch | None = None
        self._to_verify: dict[str, Subscription] = {}
        self._backoff = Backoff(first=0.1, factor=1.5, maximum=0.5, jitter=0.1)
        self._identity: object = None
        self._graph = LastGraph()
        self._looks = 0
        self._compared = 0
        self._sleep = SleepDetector()
        self._busy = 0.0

    def start(self) -> None:
        """Begin the looks."""
        with _watches_lock:
            on_fork(_forget_watches)
            watch = self._watch = _watches.setdefault(self._key, MasterWatch())
            self.pause, self.due, self._busy = self.period, time.monotonic() + self.period, watch.busy
            watch.join(self)

    def close(self, timeout: float) -> None:
        """End the looks (the node is closing)."""
        if self._watch is None:
            return
        with _watches_lock:
            if self._watch.leave(self) and _watches.get(self._key) is self._watch:
                del _watches[self._key]
        self._watch.wait_for(self, timeout)

    @property
    def _key(self) -> Hashable:
        """The same for nodes that find the master in the same way."""
        context = self._context
        return context.master.uri, context.master_address, context.local_nodes

    @property
    def closed(self) -> bool:
        """Whether the node is closed."""
        return self._context.lifecycle.closed

    @property
    def uri(self) -> str:
        """Of the node."""
        return self._context.uri

    def check_publishers(self, subscription: Subscription, at_once: bool) -> None:
        """Ask the master for the publishers of a topic, at once or in the next look."""
        with self._lock:
            if len(self._to_verify) >= MAX_TO_VERIFY:
                return
            self._to_verify[subscription.name] = subscription
        if at_once:
            self.check_now()

    def check_now(self) -> None:
        """Look at the master now: something is known to have changed."""
        if self._watch is not None:
            self._watch.hurry(self)

    def look(self, view: MasterView, busy: float) -> None:
        """Look at the master, and set `pause` until the next look.

        Args:
            view: What the master says.
            busy: Seconds that all rounds so far took.
        """
        if self.closed:
            return
        try:
            self._notice_sleep(self.pause + busy - self._busy)  # waiting for a slow master is not a sleep
            self._busy = busy
            self.pause = self._look(view)
        except Exception:
            _log.exception("! %s: the master monitor failed; it continues", self.name)
            self.pause = self.period

    def _notice_sleep(self, meant: float) -> None:
        seconds = self._sleep.slept(meant)
        if seconds:
            _log.info("= %s: this computer slept for %.0f s; all links are reconnected", self.name, seconds)
            self._compared = self._looks - self.full_check_every
            self._topics.woke_up()

    def _look(self, view: MasterView) -> float:
        """Look once; returns the seconds until the next."""
        try:
            moved = self._follow_address(view)
            stands = self.check_registration(view) and not moved
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

    def check_registration(self, view: MasterView | None = None) -> bool:
        """False if everything has to be registered again."""
        view = view or MasterView([self])
        pid, uri, run_id = view.identity(self)
        identity = (pid, run_id)
        known, self._identity = self._identity, identity
        if self._context.master_lost or (known is not None and known != identity):
            return False
        if not self._still(view.confirmed[self]):
            return True
        if not isinstance(uri, str):
            return False
        if not same_uri(uri, self._context.uri):
            # Another node has taken our name, and the master asked us to shut down: do not register again.
            _log.debug("! %s is registered at %s, not at %s", self.name, uri, self._context.uri)
            return True
        self._looks += 1
        if not view.has_state and self._looks - self._compared < self.full_check_every:
            return True
        self._compared = self._looks
        return self.graph_has_all(view)

    def graph_has_all(self, view: MasterView | None = None) -> bool:
        """Whether the master's graph has all that is registered."""
        view = view or MasterView([self])
        state = view.state(self)
        tables = {"publisher": state.publishers, "subscriber": state.subscribers, "service": state.services}
        self._note_unknown_publishers(state)
        self.forget_unsubscribed(view.datagram_links[self], state)
        return all(
            self.name in tables[registration.kind].get(registration.name, ())
            for registration in self._still(view.confirmed[self])
            if registration.kind in tables
        )

    # -- questions, for all nodes of the round ---------------------------------------------------------------

    def ask(self, names: Sequence[str]) -> tuple[object, object, dict[str, object]]:
        """The master's process id and run id, and the URIs of these nodes; one request with multicall."""
        calls: list[tuple[str, tuple[object, ...]]] = [
            ("getPid", ()),
            ("getParam", ("/run_id",)),
            *(("lookupNode", (name,)) for name in names),
        ]
        master = self._context.master
        try:
            answers = master.batch(calls, timeout=PATIENCE)
        except RosTimeout:
            answers = master.batch(calls, timeout=CALL_TIMEOUT - PATIENCE)
        pid, run_id, *uris = [None if isinstance(answer, MasterError) else answer for answer in answers]
        return pid, run_id, dict(zip(names, uris, strict=True))

    def read_graph(self) -> SystemState:
        """The master's graph."""
        return self._context.master.get_system_state(timeout=CALL_TIMEOUT, last=self._graph)

    def find_address(self) -> str:
        """Our address on the route to the master."""
        return choose_own_address(None, self._context.master_address, ADDRESS_SECONDS)[0]

    def confirmed(self) -> list[Registration]:
        """What the master has confirmed."""
        return self._context.registrations.confirmed()

    def datagram_links(self) -> list[DatagramLink]:
        """The subscribers that get datagrams."""
        return self._topics.datagram_links()

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
                self.check_publishers(subscription, at_once=True)

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
        with self._lock:
            to_verify, self._to_verify = self._to_verify, {}
        self._context.registrations.announce_again(
            subscription
            for subscription in to_verify.values()
            if self._topics.subscription(subscription.name) is subscription
        )

    def _follow_address(self, view: MasterView) -> bool:
        """Listen on our present address towards the master; True if it has changed.

        Raises:
            ConnectionLost: There is no route to the master, e.g. the cable is unplugged.
        """
        old = self._context.uri
        try:
            if not self._context.listening.follow(lambda: view.own_address(self), self._moved):
                return False
        except RosError as error:
            if no_route(error.__cause__):
                if not self._context.master_lost:
                    self._context.master.reconnect()  # calls under way fail now, not when their time is over
                raise
            # The name server is silent, or the port is taken: the master may be there.
            _log.debug("! %s: the current address cannot be determined: %s", self.name, error)
            return False
        self._topics.links_changed_address()
        self._context.master.reconnect()
        _log.warning("= %s: our address changed, %s is now %s", self.name, old, self._context.uri)
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


def _forget_watches() -> None:
    """A fork has none of the threads; its nodes are closed."""
    global _watches_lock
    _watches_lock = threading.Lock()
    _watches.clear()
