"""The registrations of one node at the master, kept in a table so that they can be repeated.

Publishers, subscribers, services and parameter subscriptions each add one `Registration`. The master monitor
(`master_monitor.py`) registers the whole table again when the master has forgotten the node, or when our
address has changed. What one thread adds within `batch` is registered at the end of that block, with one
request.

Source: wiki.ros.org/ROS/Master_API.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import NamedTuple, Protocol

from rosproto.errors import (
    ConnectionLost,
    LocalProtocolError,
    MasterError,
    RegistrationsRefused,
    RosError,
    RosTimeout,
)
from rosproto.logs import get_logger
from rosproto.node.graph import api_client
from rosproto.node.graph.master_client import MasterClient
from rosproto.transport.deadline import Deadline


class RegistrationCall(NamedTuple):
    """The call that makes a registration, alone or in one request with others.

    Attributes:
        method: Of the master.
        params: Its parameters, without our name.
        on_answer: Called with the value of the answer; raises TypeError if it is malformed.
    """

    method: str
    params: tuple[object, ...]
    on_answer: Callable[[object], object]


class Registration(Protocol):
    """One entry of the table.

    Both methods must be repeatable: they read the node's present URIs each time, since these change with our
    address.

    Attributes:
        kind: "publisher", "subscriber", "service" or "parameter".
        name: Resolved name of the topic, service or parameter.
    """

    @property
    def kind(self) -> str: ...

    @property
    def name(self) -> str: ...

    def registration_call(self) -> RegistrationCall:
        """The call that registers it at the master."""

    def unregister(self, master: MasterClient) -> int:
        """Unregister; 0 if the master did not have it. Raise what the call raises."""


_log = get_logger("rosproto.node")
ARRIVING_SECONDS = 0.3
"""How long a registration whose call was interrupted may be on its way to the master when its node closes."""
_MAX_IN_BATCH = 100  # registrations in one request, so that neither it nor its time grows without a bound


class _Deferred(NamedTuple):
    """A registration that waits for the end of a block; `undo` closes what was opened for it."""

    registration: Registration
    undo: Callable[[], object]


class Registrations:
    """The table of one node, safe from any thread.

    `add` registers at once in the calling thread and raises the master's error. A registration stays in the
    table until `remove`, also while the master is away. If the master does not answer `remove`, the call is
    repeated later: perhaps only the network is away, and a closed publisher would stay in the graph.

    Args:
        master: Client to register with.
        farewell: Client to unregister with; its time-out is shorter.
        is_away: True while the master is known not to answer; then `remove` does not call it.
    """

    def __init__(
        self,
        master: MasterClient,
        farewell: MasterClient | None = None,
        is_away: Callable[[], bool] = lambda: False,
    ) -> None:
        self._master = master
        self._farewell = farewell or master
        self._is_away = is_away
        self._table: dict[tuple[str, str], Registration] = {}
        self._confirmed: dict[tuple[str, str], Registration] = {}
        self._to_unregister: dict[tuple[str, str], Registration] = {}
        self._lock = threading.Lock()
        self._pending: set[tuple[str, str]] = set()
        self._leaving: list[Registration] = []
        self._adding = 0
        self._added = threading.Condition(self._lock)
        self._deferred: dict[int, list[_Deferred]] = {}  # by thread
        self._closed = False

    def add(self, registration: Registration, timeout: float | None = None) -> None:
        """Register now and remember.

        Args:
            registration: What to register.
            timeout: Seconds for the master's answer; None takes its client's.

        Raises:
            MasterError: The master refused; nothing is remembered.
            ConnectionLost, RosTimeout: The master is away; if it got the call, it is unregistered later.
            LocalProtocolError: The node was closed by another thread meanwhile.
        """
        self._register_batch([_Deferred(registration, lambda: None)], timeout)

    def _remember(self, registration: Registration) -> None:
        assert self._lock.locked()
        if self._closed:  # it would never be unregistered
            raise LocalProtocolError(
                f"{registration.kind} {registration.name}: the node was closed in the meantime; open another"
            )
        # Remembered first: the master may restart between its answer and our note of it.
        key = (registration.kind, registration.name)
        self._table[key] = registration
        self._to_unregister.pop(key, None)
        self._adding += 1

    # -- many at once ----------------------------------------------------------------------------------------

    def register_in_batch(
        self, registration: Registration, undo: Callable[[], object], timeout: float | None = None
    ) -> None:
        """As `add`; within a block of `batch` of this thread it is registered at the end of that block.

        `undo` is called if that fails: it closes what was opened.
        """
        with self._lock:
            held = self._deferred.get(threading.get_ident())
            if held is not None and not self._closed:
                held.append(_Deferred(registration, undo))
                return
        self.add(registration, timeout)

    @contextmanager
    def batch(self) -> Iterator[None]:
        """Register at the end of the block what this thread adds in it, with one request if possible.

        A block within a block is part of it. If the block raises, what it has opened is closed.

        Raises:
            MasterError: The master refused one; the others stand.
            RegistrationsRefused: It refused several.
            ConnectionLost, RosTimeout: The master is away; all of it is closed.
            LocalProtocolError: The node was closed meanwhile.
        """
        thread = threading.get_ident()
        with self._lock:
            inner = thread in self._deferred
            self._deferred.setdefault(thread, [])
        if inner:
            yield
            return
        try:
            yield
        except BaseException:
            _undo(self._take_deferred(thread))
            raise
        held = self._take_deferred(thread)
        for start in range(0, len(held), _MAX_IN_BATCH):
            try:
                self._register_batch(held[start : start + _MAX_IN_BATCH])
            except BaseException:
                _undo(held[start + _MAX_IN_BATCH :])
                raise

    def _take_deferred(self, thread: int) -> list[_Deferred]:
        with self._lock:
            return self._deferred.pop(thread)

    def _register_batch(self, held: Sequence[_Deferred], timeout: float | None = None) -> None:
        begun: list[_Deferred] = []
        try:
            with self._lock:
                for one in held:
                    self._remember(one.registration)
                    begun.append(one)
            refused = self._announce_batch(begun, timeout)
        except BaseException as error:
            self._forget(begun, error)
            _undo(held)
            raise
        finally:
            with self._lock:
                self._adding -= len(begun)
                self._added.notify_all()
        self._forget([one for one in begun if _key(one) in refused], None)
        _undo([one for one in begun if _key(one) in refused])
        if len(refused) > 1:
            raise RegistrationsRefused(refused, among=len(held), uri=self._master.uri)
        for refusal in refused.values():
            raise refusal

    def _announce_batch(
        self, held: Sequence[_Deferred], timeout: float | None
    ) -> dict[tuple[str, str], RosError]:
        """Register all of them; return the errors of those that failed."""
        calls = [one.registration.registration_call() for one in held]
        answers = self._master.batch([(call.method, call.params) for call in calls], timeout=timeout)
        refused: dict[tuple[str, str], RosError] = {}
        for one, call, answer in zip(held, calls, answers, strict=True):
            try:
                if isinstance(answer, MasterError):
                    raise answer
                api_client.checked(call.method, self._master.uri, answer, call.on_answer)
            except RosError as error:
                refused[_key(one)] = error
                continue
            if not self._confirm(_key(one), one.registration):
                self._unregister(one.registration, self._farewell)
        return refused

    def _forget(self, held: Sequence[_Deferred], error: BaseException | None) -> None:
        """Remove failed registrations; if the master may have them nevertheless, unregister them later."""
        with self._lock:
            for one in held:
                key = _key(one)
                if self._table.get(key) is one.registration:
                    del self._table[key]
                    self._confirmed.pop(key, None)
                if error is not None and key not in self._table:
                    self._to_unregister[key] = one.registration

    def _was_deferred(self, registration: Registration) -> bool:
        """Remove a registration that waits for the end of a block; False if there is none."""
        assert self._lock.locked()
        for held in self._deferred.values():
            for one in held:
                if one.registration is registration:
                    held.remove(one)
                    return True
        return False

    # -- one -------------------------------------------------------------------------------------------------

    def announce(self, registration: Registration) -> None:
        """Make the call of one registration.

        Raises:
            MasterError: The master refused.
            ConnectionLost, RosTimeout: It is away.
        """
        call = registration.registration_call()
        answer = self._master.call(call.method, *call.params)
        api_client.checked(call.method, self._master.uri, answer, call.on_answer)

    def announce_again(self, registrations: Iterable[Registration]) -> None:
        """Make the calls of these registrations, with one request for many if possible.

        Raises:
            MasterError: The master refused one; the others are made.
            ConnectionLost, RosTimeout: It is away.
        """
        held = [_Deferred(registration, lambda: None) for registration in registrations]
        refused: dict[tuple[str, str], RosError] = {}
        for start in range(0, len(held), _MAX_IN_BATCH):
            refused |= self._announce_batch(held[start : start + _MAX_IN_BATCH], None)
        for refusal in refused.values():
            raise refusal

    def register_again(self, registration: Registration) -> None:
        """Repeat a registration, so that the master notifies the peers again.

        If it is removed meanwhile, it is unregistered.

        Raises:
            MasterError: The master refused.
            ConnectionLost, RosTimeout: It is away.
        """
        key = (registration.kind, registration.name)
        with self._lock:
            if self._table.get(key) is not registration:
                return
        self.announce(registration)
        self._settle(key, registration)

    def remove(self, registration: Registration) -> None:
        """Remove and unregister; if the master does not answer, the call is repeated when it does."""
        key = (registration.kind, registration.name)
        with self._lock:
            if self._was_deferred(registration) or self._table.get(key) is not registration:
                return
            del self._table[key]
            self._confirmed.pop(key, None)
            self._pending.discard(key)
            if self._is_away():
                self._to_unregister[key] = registration
                return
            self._leaving.append(registration)
        done = False
        try:
            done = self._unregister(registration, self._farewell)
        finally:
            with self._lock:
                self._leaving.remove(registration)
                if not done and key not in self._table:
                    self._to_unregister[key] = registration

    @staticmethod
    def _unregister(
        registration: Registration, master: MasterClient, arriving: Deadline | None = None
    ) -> bool:
        try:
            while not registration.unregister(master) and arriving is not None and not arriving.expired:
                time.sleep(0.02)
        except (ConnectionLost, RosTimeout) as error:
            _log.debug("! unregister %s %s: %s", registration.kind, registration.name, error)
            return False
        except RosError as error:
            _log.warning("unregistering the %s %s: %s", registration.kind, registration.name, error)
        return True

    def register_all(self) -> bool:
        """Register everything again; True if all of it succeeded.

        One refusal does not stop the others. A lost master stops the round; the master monitor tries again.
        """
        with self._lock:
            self._pending = set(self._table)
        return self.register_pending()

    def register_pending(self) -> bool:
        """Register and unregister what the last round left out; True if nothing is left."""
        for key in sorted(self.pending):
            with self._lock:
                registration = self._table.get(key)
            if registration is not None:
                try:
                    self.announce(registration)
                except (ConnectionLost, RosTimeout) as error:
                    _log.debug("! register %s %s: %s", *key, error)
                    return False
                except RosError as error:
                    _log.error("registering the %s %s again: %s", *key, error)
                    continue
            self._settle(key, registration)
        return self._unregister_pending(self._farewell) and not self.pending

    def _unregister_pending(self, master: MasterClient) -> bool:
        with self._lock:
            unwanted = dict(self._to_unregister)
        for key, registration in unwanted.items():
            if not self._unregister(registration, master):
                return False
            with self._lock:
                if self._to_unregister.get(key) is registration:
                    del self._to_unregister[key]
                again = self._table.get(key)
                if again is not None:  # registered again meanwhile, and perhaps just unregistered
                    self._pending.add(key)
        return True

    def _settle(self, key: tuple[str, str], registration: Registration | None) -> None:
        """Note that `key` is registered; unregister it if it was removed meanwhile."""
        with self._lock:
            self._pending.discard(key)
        if registration is not None and not self._confirm(key, registration):
            self._unregister(registration, self._master)

    def _confirm(self, key: tuple[str, str], registration: Registration) -> bool:
        """Note that the master has it; False if it was removed meanwhile."""
        with self._lock:
            if key not in self._table:
                return False
            if self._table[key] is registration:
                self._confirmed[key] = registration
            return True

    def unregister_all(self, deadline: Deadline, master: MasterClient) -> None:
        """Unregister everything, the newest first, and accept no more; stops at the deadline or when the
        master is away.
        """
        with self._lock:
            self._closed = True
            # A registration under way on another connection must not arrive after we unregistered it.
            left = deadline.remaining()
            self._added.wait_for(lambda: not self._adding, None if left is None else left / 2)
            doubtful = list(self._to_unregister.values())
            registrations = [*list(self._table.values())[::-1], *self._leaving, *doubtful]
            self._table.clear()
            self._confirmed.clear()
            self._pending.clear()
            self._to_unregister.clear()
        interrupt: BaseException | None = None
        arriving = Deadline(ARRIVING_SECONDS)
        for registration in registrations:
            try:
                done = self._unregister(registration, master, arriving if registration in doubtful else None)
            except BaseException as error:  # Ctrl-C: complete it first
                interrupt, done = error, self._unregister(registration, master)
            if deadline.expired or not done:
                break
        if interrupt is not None:
            raise interrupt

    @property
    def pending(self) -> frozenset[tuple[str, str]]:
        """(kind, name) of the registrations to repeat."""
        with self._lock:
            return frozenset(self._pending)

    def of_kind(self, kind: str) -> list[Registration]:
        """The present registrations of one kind."""
        with self._lock:
            return [registration for (k, _), registration in self._table.items() if k == kind]

    def confirmed(self) -> list[Registration]:
        """Registrations that the master has confirmed and that were not removed; none that is under way."""
        with self._lock:
            return list(self._confirmed.values())

    def __len__(self) -> int:
        return len(self._table)


def _key(held: _Deferred) -> tuple[str, str]:
    return held.registration.kind, held.registration.name


def _undo(held: Sequence[_Deferred]) -> None:
    """Close what was opened for these registrations."""
    for one in held:
        try:
            one.undo()
        except Exception:
            _log.exception("! closing the %s %s failed", *_key(one))
