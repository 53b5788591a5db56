"""`Vehicle`: a chassis as a VDA 5050 vehicle. The broker on one side, the chassis on the other, between
them the order machine.

One thread owns the machine. It waits for what comes: a message, a pose, the end of a drive or of an action,
the time of something. Whatever comes is told to the machine, and its effects are carried out in their order:
state on disk, state to the broker, then the drive or the action. An order is on disk before the machine takes
it; while the disk takes nothing no order is taken and nothing begins. Callbacks of the broker and of the
chassis only leave a note.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from rosproto.errors import RosError
from rosproto.logs import get_logger
from rosproto.version import __version__
from woosh_pure.fleet.actions.abilities import Task, Triggers, abilities_of
from woosh_pure.fleet.actions.log_report import Journal
from woosh_pure.fleet.actions.map_store import MapShelf
from woosh_pure.fleet.config import VehicleConfig
from woosh_pure.fleet.driver import Driver
from woosh_pure.fleet.factsheet import Body, factsheet_message
from woosh_pure.fleet.messages.elements import Order
from woosh_pure.fleet.messages.header import Headers
from woosh_pure.fleet.messages.parsing import parse, read_instant_actions, read_order
from woosh_pure.fleet.messages.schema import Invalid
from woosh_pure.fleet.monitor import SILENT_AFTER, Watch, outline_of
from woosh_pure.fleet.mqtt.broker import Broker
from woosh_pure.fleet.mqtt.connection import BrokerConnection
from woosh_pure.fleet.order.deviation import AgvPosition
from woosh_pure.fleet.order.effects import Begin, Changed, Drive, Effect, End, Factsheet, Halt, Retry
from woosh_pure.fleet.order.errors import ErrorType, Level, Problem
from woosh_pure.fleet.order.limits import Limits
from woosh_pure.fleet.order.machine import OrderMachine
from woosh_pure.fleet.state import Facts, Load, MapEntry, state_message, visualization_message
from woosh_pure.fleet.store import Store

if TYPE_CHECKING:
    from types import TracebackType

    from woosh_pure.chassis import Chassis

__all__ = ["Vehicle"]

_log = get_logger("woosh_pure.fleet.vehicle")
STATE_EVERY = 25.0
"""Seconds between two states at most; the standard asks for 30."""
MOST_MESSAGES = 100
"""Messages of a fleet manager that wait; more are dropped, counted and logged."""
_AGAIN_SECONDS = 1.5  # until the state is told once more after the line has come back
_DISK_SECONDS = 2.0  # between two tries of a disk that is full, or cannot be written
_FACTS_SECONDS = 3.0  # for the chassis to tell where it is, before the fleet manager may send orders
_LEASE_SECONDS = 60.0
_END_SECONDS = 10.0  # for the thread to end
_STOP_SECONDS = 4.0
_ACTIONS_SECONDS = 3.5  # for actions to end when the vehicle does; a program is killed after 3


class Vehicle:
    """One chassis under a fleet manager. Use it in a `with` block, or call `open` and `close`.

    Nothing moves until an order comes. Leaving the block halts the drive, ends the order and tells it, then
    says OFFLINE. An order that was cut off by another end (kill -9, a loss of power) is restored and waits.

    Args:
        chassis: An open chassis; closing it stays with the caller.
        config: Who this vehicle is and what it can do.
        broker: Where the broker is.
        store: Where its state is kept; None keeps it nowhere: after a restart the order is forgotten.

    Raises:
        ImportError: paho-mqtt is not installed; the text names the extra.
        ValueError: An action of the configuration cannot be loaded.
    """

    def __init__(
        self, chassis: Chassis, config: VehicleConfig, broker: Broker, store: Store | None = None
    ) -> None:
        self.chassis, self.config = chassis, config
        self._store = store
        self._journal, self._shelf = _kept_beside(store, config)
        self._triggers = Triggers()
        self._kept: dict[str, Any] = {}  # the machine, as it was saved last
        self._outline = tuple((float(x), float(y)) for x, y in config.footprint)
        found = abilities_of(
            config,
            shelf=self._shelf,
            report=None if store is None else self._report,
            triggers=self._triggers,
        )
        self._doings = {name: doing for name, (_, doing) in found.items()}
        self.limits = Limits(
            abilities={name: ability for name, (ability, _) in found.items()},
            maps=(config.map_id,) if self._shelf is None else (self._shelf.active,),
            tolerance=config.tolerance,
            turn_tolerance=config.turn_tolerance,
            marks=config.marks,
            zone_set=config.zone_set,
        )
        self._headers = Headers(config.version, config.manufacturer, config.serial)
        self._header_lock = threading.Lock()
        self._loads: list[Load] = []
        self.facts = Facts(
            map_id=config.map_id,
            maps=(MapEntry(config.map_id, config.map_version),),
            zone_set=config.zone_set,
            loads=() if config.marks else None,
        )
        self._machine = OrderMachine(self.limits)
        self._mqtt = BrokerConnection(
            broker, config.prefix, self._connection_message, self._on_message, self._on_line
        )
        self._watch = Watch(chassis, self.facts, self._on_moved, self._on_told, self._on_described)
        self._driver = Driver(chassis, self._on_drive_ended, lambda: self.facts.position, marks=config.marks)
        self._tasks: dict[str, Task] = {}
        self._workers: set[threading.Thread] = set()
        self._wake = threading.Condition()
        self._calls: deque[Callable[[], list[Effect]]] = deque()
        self._messages: deque[tuple[str, bytes]] = deque()
        self._flags: set[str] = set()
        self._due: dict[str, float] = {}
        self._thread: threading.Thread | None = None
        self._closing = False
        self._end_lease: Callable[[], object] = lambda: None
        self._lost = False
        self._unkept = False  # the disk does not take the state
        self._unbegun: list[Begin] = []  # actions that wait until it does
        self._moving = False
        self._was_blocked = ""
        self.dropped = 0

    # -- life ------------------------------------------------------------------------------------------------

    def __enter__(self) -> Vehicle:
        return self.open()

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<Vehicle {self.config.prefix}: order {self._machine.order_id or 'none'}>"

    def open(self) -> Vehicle:
        """Restore what was kept, listen to the chassis, connect with the broker; returns at once."""
        if self._thread is None:
            self._watch.open()  # what it hears comes while a drive of before is ended
            self._restore()
            if self._shelf is not None:
                self._shelf.confirm(self.chassis)
                self._use_maps()
            threading.Thread(target=self._learn_outline, name="woosh:outline", daemon=True).start()
            self._flags.add("told")
            self._end_lease = self.chassis.lease.on(lambda state: self._note("lease"))
            now = time.monotonic()
            self._due = {"state": now, "silent": now + SILENT_AFTER, "line": now + _FACTS_SECONDS}
            if self.config.visualization:
                self._due["visualization"] = now
            self._save()  # a disk that takes nothing is told before an order comes
            self._thread = threading.Thread(
                target=self._run, name=f"woosh:vehicle-{self.config.serial}", daemon=True
            )
            self._thread.start()
        return self

    def close(self) -> None:
        """Halt, end the order and the actions that run, tell it, say OFFLINE. Bounded, idempotent."""
        with self._wake:
            if self._closing:
                return
            self._closing = True
            self._wake.notify_all()
        for task in list(self._tasks.values()):
            task.cancelled.set()
        self._driver.close()
        thread = self._thread
        if thread is not None and thread is not threading.current_thread():
            thread.join(_END_SECONDS)
            if not thread.is_alive():
                self._end_in_order()
        self._end_lease()
        self._release_lease()
        self._watch.close()
        self._mqtt.close()

    def _end_in_order(self) -> None:
        """The last word of the machine, when its thread is over. What it still asks for is being done."""
        deadline = time.monotonic() + _ACTIONS_SECONDS
        for worker in self._workers:
            worker.join(max(0.0, deadline - time.monotonic()))
        effects = self._machine.shut_down("the vehicle's software was ended in order")
        if any(isinstance(effect, Changed) for effect in effects):
            self._publish()
        self._save()

    @property
    def connected(self) -> bool:
        """Whether the line to the broker stands."""
        return self._mqtt.connected.is_set()

    def trigger(self, name: str) -> int:
        """Somebody has pressed the button: every waitForTrigger of this type that waits now is over.

        Args:
            name: `triggerType`, one of the configuration's `triggers`. No units, no frame.

        Returns:
            How many have waited.
        """
        return self._triggers.pull(name)

    def wait_connected(self, timeout: float = 10.0) -> bool:
        """Wait for the broker; whether it is there."""
        return self._mqtt.connected.wait(timeout)

    def _restore(self) -> None:
        kept = None if self._store is None else self._store.load()
        if kept is None or self._store is None:
            return
        try:
            machine = OrderMachine.from_json(kept, self.limits)
        except (Invalid, KeyError, TypeError, ValueError, AttributeError) as error:
            self._store.put_aside(f"{type(error).__name__}: {error}")
            return
        self._machine = machine
        if kept.get("driving"):
            # The process before this one did not end in order: what it had sent may still be under way.
            report = self.chassis.stop(everything=True, timeout=_STOP_SECONDS)
            _log.warning("! it was driving when it ended: %s", report.sentence())

    # -- notes from other threads ----------------------------------------------------------------------------

    def _note(self, flag: str) -> None:
        with self._wake:
            self._flags.add(flag)
            self._wake.notify_all()

    def _call(self, call: Callable[[], list[Effect]]) -> None:
        with self._wake:
            self._calls.append(call)
            self._wake.notify_all()

    def _on_message(self, topic: str, payload: bytes) -> None:
        with self._wake:
            if len(self._messages) >= MOST_MESSAGES:
                self.dropped += 1
                full = self.dropped == 1
            else:
                full = False
                self._messages.append((topic, payload))
                self._wake.notify_all()
        if full:
            _log.warning(
                "! %s: messages come faster than they are read; some are dropped", self.config.prefix
            )

    def _on_line(self, stands: bool) -> None:
        if stands:
            self._note("line")

    def _on_moved(self) -> None:
        if self._machine.driving or self._lost or not self.facts.located or self.facts.moving != self._moving:
            self._note("moved")

    def _on_told(self) -> None:
        self._note("told")

    def _on_described(self) -> None:
        self._note("described")

    def _on_drive_ended(self, token: int, arrived: bool, text: str) -> None:
        self._call(lambda: self._drive_ended(token, arrived, text))

    def _drive_ended(self, token: int, arrived: bool, text: str) -> list[Effect]:
        before = self._machine.set_position(self._place())
        return [*before, *self._machine.drive_ended(token, arrived, text)]

    # -- the one thread --------------------------------------------------------------------------------------

    def _run(self) -> None:
        while True:
            with self._wake:
                while not (self._closing or self._flags or self._calls or self._messages):
                    wait = min(self._due.values()) - time.monotonic()
                    if wait <= 0.0:
                        break
                    self._wake.wait(wait)
                if self._closing:
                    break
                flags, self._flags = self._flags, set()
                calls = list(self._calls)
                self._calls.clear()
                messages = list(self._messages)
                self._messages.clear()
            try:
                self._handle(flags, calls, messages)
                self._on_time(time.monotonic())
            except Exception:
                _log.exception("! %s: a failure of our own; the vehicle goes on", self.config.prefix)

    def _handle(
        self, flags: set[str], calls: list[Callable[[], list[Effect]]], messages: list[tuple[str, bytes]]
    ) -> None:
        if "lease" in flags:
            self._hand_over()
        if flags & {"told", "moved", "lease"} or messages:
            self._refresh(full=bool(flags & {"told", "lease"}) or not self.facts.located)
        for call in calls:
            self._carry_out(call())
        for topic, payload in messages:
            self._carry_out(self._receive(topic, payload))
        if "line" in flags or "described" in flags:
            self._factsheet()
        if "line" in flags:
            self._publish()
            # A state is not retained: who comes back from the same loss a little later shall have it, too.
            self._due["state"] = time.monotonic() + _AGAIN_SECONDS
        if self.facts.moving != self._moving:
            self._moving = self.facts.moving
            self._publish()

    def _receive(self, topic: str, payload: bytes) -> list[Effect]:
        data: Mapping[str, Any] = {}
        if self._journal is not None:
            self._journal.note(f"< {topic} {payload[:300]!r}")
        _log.debug("< %s %s, %d bytes", self.config.prefix, topic, len(payload))
        try:
            data = parse(payload)
            if topic == "order":
                return self._take(read_order(data))
            return self._machine.receive_instant(read_instant_actions(data))
        except Invalid as error:
            return self._machine.receive_malformed(data, error, topic)

    def _take(self, order: Order) -> list[Effect]:
        """What is acknowledged is there after a restart: the disk takes an order before the machine does."""
        if self._store is not None:
            rehearsal = self._machine.trial_copy()
            rehearsal.receive(order)
            try:
                self._store.save(rehearsal.to_json())
            except OSError as error:
                self._tell_disk(error)
                text = f"the order cannot be kept on disk ({error}), so it is not taken"
                return self._machine.reject(order, text)
        return self._machine.receive(order)

    def _place(self) -> AgvPosition | None:
        return self.facts.position if self.facts.located and not self._lost else None

    def _refresh(self, *, full: bool) -> None:
        if self._lost and not self._watch.silent:
            self._lost, full = False, True
            self._carry_out(self._machine.set_problem("lost", None))
        if full:
            before = (self.facts.emergency_stop, self.facts.bumper, self.facts.faults, self.facts.charging)
            self._watch.refresh(self._local_owner())
            if self._watch.heard:
                self._carry_out(self._machine.set_mode(self._watch.mode))
            if before != (
                self.facts.emergency_stop, self.facts.bumper, self.facts.faults, self.facts.charging
            ):  # fmt: skip
                self._publish()
        self._carry_out(self._machine.set_position(self._place()))
        if "line" in self._due and self.facts.located and self.facts.percent is not None:
            self._due["line"] = 0.0  # ONLINE says that orders are taken
        if full:
            freed, self._was_blocked = self._was_blocked and not self._watch.blocked, self._watch.blocked
            if freed:
                self._carry_out(self._machine.retry())

    def _on_time(self, now: float) -> None:
        for name in [name for name, due in self._due.items() if due <= now]:
            if name == "state":
                self._publish()
            elif name == "visualization":
                self._due[name] = now + self.config.visualization
                header = self._header("visualization")
                self._mqtt.send("visualization", visualization_message(self.facts, header))
            elif name == "disk":
                del self._due[name]
                self._save()
            elif name == "retry":
                del self._due[name]
                self._carry_out(self._machine.retry())
            elif name == "lease":
                self._keep_lease()
            elif name == "line":
                del self._due[name]
                self._mqtt.open()
            elif name == "silent":
                self._due[name] = max(self._watch.heard + SILENT_AFTER, now + 0.2)
                self._look_for_silence()

    def _look_for_silence(self) -> None:
        if self._lost or not self._watch.silent:
            return
        self._lost = True
        self.facts.velocity = None
        text = f"nothing was heard of the chassis at {self.chassis.master_uri} for {SILENT_AFTER:g} s"
        hint = "check the robot and its network; it may go on with what it was told"
        problem = Problem(ErrorType.ROBOT_LOST, text, (), Level.FATAL, hint)
        self._carry_out(self._machine.set_problem("lost", problem))
        self._carry_out(self._machine.set_position(None))

    # -- effects ---------------------------------------------------------------------------------------------

    def _carry_out(self, effects: list[Effect]) -> None:
        if any(isinstance(effect, Changed) for effect in effects):
            self._hold_lease()
            self._save()
            self._publish()
        for effect in effects:
            if isinstance(effect, Drive):
                self._driver.drive(effect)
            elif isinstance(effect, Halt):
                self._driver.halt(effect.token)
            elif isinstance(effect, Begin):
                self._begin(effect)
            elif isinstance(effect, End):
                self._forget_unbegun(effect.action_id)
                task = self._tasks.get(effect.action_id)
                if task is not None:
                    task.cancelled.set()
            elif isinstance(effect, Retry):
                self._due["retry"] = time.monotonic() + effect.after
            elif isinstance(effect, Factsheet):
                self._factsheet()

    def _begin(self, effect: Begin) -> None:
        if self._unkept:
            self._unbegun.append(effect)  # on disk it has not begun: after a restart it would begin again
            return
        task = Task(effect.action, self.chassis, self._loads)
        self._tasks[effect.action.id] = task
        doing = self._doings[effect.action.type]

        def work() -> None:
            ok, text = False, ""
            try:
                text = str(doing(task) or "")
                ok = True
            except Exception as error:
                text = str(error) or type(error).__name__
                if not isinstance(error, (RosError, ValueError, OSError)):
                    _log.exception("! the action %s has failed", effect.action.type)
            self._call(lambda: self._action_ended(effect.action.id, ok, text))

        worker = threading.Thread(target=work, name=f"woosh:action-{effect.action.type}", daemon=True)
        self._workers = {each for each in self._workers if each.is_alive()} | {worker}
        worker.start()

    def _action_ended(self, action_id: str, ok: bool, text: str) -> list[Effect]:
        self._tasks.pop(action_id, None)
        if self.facts.loads is not None:
            self.facts.loads = tuple(self._loads)
        self._use_maps()
        self._watch.refresh(self._local_owner())  # a pose that was given is known now
        return [*self._machine.action_ended(action_id, ok, text), *self._machine.set_position(self._place())]

    def _use_maps(self) -> None:
        if self._shelf is not None:
            self.facts.maps, self.facts.map_id = self._shelf.entries, self._shelf.active
            self.limits = replace(self.limits, maps=(self._shelf.active,))
            self._machine.limits = replace(self._machine.limits, maps=self.limits.maps)

    def _report(self, reason: str) -> str:
        """logReport: its name is the result, and stands in the state's information."""
        assert self._journal is not None
        facts = {
            "vehicle": self.config.prefix, "version": __version__, "chassis": self.chassis.master_uri,
            "readiness": self.chassis.readiness().sentence(), "facts": repr(self.facts), "order": self._kept,
        }  # fmt: skip
        name = self._journal.write(reason, facts)
        self.facts.information = (("logReport", name),)
        return name

    def _save(self) -> None:
        if self._store is None:
            return
        self._kept = self._machine.to_json()
        try:
            self._store.save(self._kept)
        except OSError as error:
            self._tell_disk(error)
            return
        if self._unkept:
            self._unkept = False
            _log.warning("! %s: the state is kept on disk again", self.config.prefix)
            waiting, self._unbegun = self._unbegun, []
            for effect in waiting:
                self._begin(effect)
            self._call(lambda: self._machine.set_storage_problem(None))

    def _tell_disk(self, error: OSError) -> None:
        self._due["disk"] = time.monotonic() + _DISK_SECONDS
        if self._unkept or self._store is None:
            return
        self._unkept = True
        text = (
            f"the state cannot be kept in {self._store.path}: {error}; no order is taken and no action "
            "begins, because a restart would forget them"
        )
        _log.error("! %s: %s", self.config.prefix, text)
        hint = "make room, or let it be written; it is tried again and again"
        problem = Problem(ErrorType.STORAGE, text, (), Level.FATAL, hint)
        self._call(lambda: self._machine.set_storage_problem(problem))

    def _forget_unbegun(self, action_id: str) -> None:
        """An action that waited for the disk is ended before it began."""
        for effect in [each for each in self._unbegun if each.action.id == action_id]:
            self._unbegun.remove(effect)
            self._call(lambda: self._machine.action_ended(action_id, False, "it was ended before it began"))

    # -- messages to the broker ------------------------------------------------------------------------------

    def _header(self, topic: str) -> dict[str, Any]:
        with self._header_lock:
            return self._headers.header(topic, time.time())

    def _connection_message(self, state: str) -> dict[str, Any]:
        return {**self._header("connection"), "connectionState": state}

    def _publish(self) -> None:
        self._due["state"] = time.monotonic() + STATE_EVERY
        if self.connected:
            message = state_message(self._machine, self.facts, self._header("state"), self.config.version)
            self._mqtt.send("state", message)
            if self._journal is not None:
                told = [f"{each.action.id} {each.status.value}" for each in self._machine.action_states[-5:]]
                kinds = [problem.kind for problem in self._machine.problems]
                node = self._machine.last_node
                self._journal.note(f"> state {message['headerId']}: at {node}, {told}, {kinds}")

    def _factsheet(self) -> None:
        message = factsheet_message(
            self._body(),
            self.limits,
            self._header("factsheet"),
            version=self.config.version,
            visualization=self.config.visualization,
            software=(("woosh-pure", __version__),),
        )
        self._mqtt.send("factsheet", message, retain=True)

    def _body(self) -> Body:
        config, known = self.config, self._watch.parameters
        return Body(
            series=config.series,
            speed_max=0.0 if known is None else known.max_linear,
            turn_max=0.0 if known is None else known.max_angular,
            height=config.height,
            load=config.load,
            acceleration=config.acceleration,
            outline=self._outline,
        )

    def _learn_outline(self) -> None:
        """What the navigation takes for the robot's outline goes before what the configuration says."""
        found = outline_of(self.chassis)
        if found:
            self._outline = found
            self._note("described")

    # -- one driver at a time --------------------------------------------------------------------------------

    @property
    def _owner(self) -> str:
        return f"fleet manager of {self.config.serial}"

    def _local_owner(self) -> str:
        holder = self.chassis.lease.holder
        return "" if holder in (None, self._owner) else str(holder)

    def _hand_over(self) -> None:
        """A local driver who asks for the lease gets it: MANUAL, and the order is cleared."""
        lease = self.chassis.lease
        asking = lease.state.asking
        if lease.holder == self._owner and asking:
            lease.grant(self._owner, asking[0])

    def _hold_lease(self) -> None:
        """While an order is carried out the lease is ours; a local driver who asks gets it."""
        if not self._machine.executing:
            self._release_lease()
        elif "lease" not in self._due:
            self._due["lease"] = 0.0

    def _keep_lease(self) -> None:
        self._due["lease"] = time.monotonic() + _LEASE_SECONDS / 3.0
        if not self._machine.executing:
            del self._due["lease"]
        elif not self.chassis.lease.acquire(self._owner, _LEASE_SECONDS):
            self._flags.add("told")

    def _release_lease(self) -> None:
        self._due.pop("lease", None)
        if self.chassis.lease.holder == self._owner:
            self.chassis.lease.release(self._owner)


def _kept_beside(store: Store | None, config: VehicleConfig) -> tuple[Journal | None, MapShelf | None]:
    """Reports and maps are kept where the order is; without such a place there are none."""
    if store is None:
        return None, None
    journal = Journal(store.path.parent / "logs", store.path.stem)
    if not config.map_actions:
        return journal, None
    own = MapEntry(config.map_id, config.map_version)
    return journal, MapShelf(store.path.parent / "maps" / store.path.stem, own)
