"""What a node has registered at the master: one table, so that all of it can be registered again.

A publisher, a subscriber, a service and a parameter subscription each put one `Registration` here. The
watchdog (`watchdog.py`) runs the whole table again when the master came back without us, or when our own
address changed.

Source: wiki.ros.org/ROS/Master_API.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import TYPE_CHECKING, Protocol

from rosproto.errors import ConnectionLost, LocalProtocolError, RosError, RosTimeout
from rosproto.logs import get_logger

if TYPE_CHECKING:
    from rosproto.node.graph.master_client import MasterClient
    from rosproto.transport.deadline import Deadline

__all__ = ["Registration", "Registrations"]

_log = get_logger("rosproto.node")


class Registration(Protocol):
    """One thing the master knows about us.

    Both calls must be repeatable: they read the node's present URIs each time, because after a change of
    address the same registration is made again under another one.

    Attributes:
        kind: "publisher", "subscriber", "service" or "parameter".
        name: Resolved name of the topic, service or parameter.
    """

    @property
    def kind(self) -> str: ...

    @property
    def name(self) -> str: ...

    def register(self, master: MasterClient) -> None:
        """Tell the master; raise what the call raises."""

    def unregister(self, master: MasterClient) -> None:
        """Take it back; raise what the call raises."""


class Registrations:
    """The table of one node, safe from any thread.

    `add` registers at once in the calling thread and raises what the master answered. What was added stays in
    the table until `remove`, whatever happens to the master meanwhile. What a master that does not answer
    could not be told to take back is told later: it may be the network that is away, and a publisher that is
    gone would stay in the graph.

    Args:
        master: To register at.
        farewell: The same for taking back, which nobody should wait for long.
        is_away: True while the master is known not to answer: then nobody waits for it at all.
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
        self._unwanted: dict[tuple[str, str], Registration] = {}
        self._lock = threading.Lock()
        self._pending: set[tuple[str, str]] = set()
        self._leaving: list[Registration] = []
        self._adding = 0
        self._added = threading.Condition(self._lock)
        self._closed = False

    def add(self, registration: Registration, timeout: float | None = None) -> None:
        """Register now and remember.

        Args:
            registration: What to register.
            timeout: Seconds for the master's answer; None takes its client's.

        Raises:
            MasterError: The master refused; nothing is remembered.
            ConnectionLost, RosTimeout: The master is away; should it have heard of it, it is taken back.
            LocalProtocolError: The node was closed by another thread meanwhile.
        """
        key = (registration.kind, registration.name)
        with self._lock:
            if self._closed:  # nobody would take it back any more
                raise LocalProtocolError(
                    f"{registration.kind} {registration.name}: the node was closed meanwhile; open another"
                )
            # Remembered first: the master may restart between its answer and our note of it.
            self._table[key] = registration
            self._unwanted.pop(key, None)
            self._adding += 1
        try:
            self._register(key, registration, timeout)
        finally:
            with self._lock:
                self._adding -= 1
                self._added.notify_all()

    def _register(self, key: tuple[str, str], registration: Registration, timeout: float | None) -> None:
        try:
            registration.register(self._master if timeout is None else self._master.within(timeout))
        except BaseException as error:
            with self._lock:
                self._table.pop(key, None)
                if isinstance(error, (ConnectionLost, RosTimeout)):
                    self._unwanted[key] = registration
            raise
        if not self._confirm(key, registration):
            self._take_back(registration, self._farewell)

    def remove(self, registration: Registration) -> None:
        """Forget and take back; a master that does not answer is told when it does."""
        key = (registration.kind, registration.name)
        with self._lock:
            if self._table.get(key) is not registration:
                return
            del self._table[key]
            self._confirmed.pop(key, None)
            self._pending.discard(key)
            if self._is_away():
                self._unwanted[key] = registration
                return
            self._leaving.append(registration)
        try:
            if not self._take_back(registration, self._farewell):
                with self._lock:
                    if key not in self._table:
                        self._unwanted[key] = registration
        finally:
            with self._lock:
                self._leaving.remove(registration)

    @staticmethod
    def _take_back(registration: Registration, master: MasterClient) -> bool:
        try:
            registration.unregister(master)
        except (ConnectionLost, RosTimeout) as error:
            _log.debug("! unregister %s %s: %s", registration.kind, registration.name, error)
            return False
        except RosError as error:
            _log.warning("unregistering the %s %s: %s", registration.kind, registration.name, error)
        return True

    def register_all(self) -> bool:
        """Register everything again; True when all of it stands.

        One refusal does not stop the others. A lost master stops the round: the watchdog comes back.
        """
        with self._lock:
            self._pending = set(self._table)
        return self.register_pending()

    def register_pending(self) -> bool:
        """Register and take back what the last round left out; True when nothing is left."""
        for key in sorted(self.pending):
            with self._lock:
                registration = self._table.get(key)
            if registration is not None:
                try:
                    registration.register(self._master)
                except (ConnectionLost, RosTimeout) as error:
                    _log.debug("! register %s %s: %s", *key, error)
                    return False
                except RosError as error:
                    _log.error("registering the %s %s again: %s", *key, error)
                    continue
            self._settle(key, registration)
        return self._take_back_unwanted(self._farewell) and not self.pending

    def _take_back_unwanted(self, master: MasterClient) -> bool:
        with self._lock:
            unwanted = dict(self._unwanted)
        for key, registration in unwanted.items():
            if not self._take_back(registration, master):
                return False
            with self._lock:
                if self._unwanted.get(key) is registration:
                    del self._unwanted[key]
                again = self._table.get(key)
                if again is not None:  # made anew meanwhile, so it may have been taken back
                    self._pending.add(key)
        return True

    def _settle(self, key: tuple[str, str], registration: Registration | None) -> None:
        """Note that `key` stands; undo it when it was removed while it was being registered."""
        with self._lock:
            self._pending.discard(key)
        if registration is not None and not self._confirm(key, registration):
            self._take_back(registration, self._master)

    def _confirm(self, key: tuple[str, str], registration: Registration) -> bool:
        """Note that the master has it; False when it was removed meanwhile."""
        with self._lock:
            if key not in self._table:
                return False
            if self._table[key] is registration:
                self._confirmed[key] = registration
            return True

    def unregister_all(self, deadline: Deadline, master: MasterClient) -> None:
        """Take everything back, the newest first, and take no more; stops at the deadline or when the master
        is away.
        """
        with self._lock:
            self._closed = True
            # What is on its way to the master on another connection must not arrive after our farewell.
            left = deadline.remaining()
            self._added.wait_for(lambda: not self._adding, None if left is None else left / 2)
            registrations = [*list(self._table.values())[::-1], *self._leaving, *self._unwanted.values()]
            self._table.clear()
            self._confirmed.clear()
            self._pending.clear()
            self._unwanted.clear()
        for registration in registrations:
            if deadline.expired or not self._take_back(registration, master):
                return

    @property
    def pending(self) -> frozenset[tuple[str, str]]:
        """(kind, name) of what is to be registered again."""
        with self._lock:
            return frozenset(self._pending)

    def of_kind(self, kind: str) -> list[Registration]:
        """The present registrations of one kind."""
        with self._lock:
            return [registration for (k, _), registration in self._table.items() if k == kind]

    def confirmed(self) -> list[Registration]:
        """What the master has said it knows, and nobody has taken back: not what is on its way to it."""
        with self._lock:
            return list(self._confirmed.values())

    def __len__(self) -> int:
        return len(self._table)
