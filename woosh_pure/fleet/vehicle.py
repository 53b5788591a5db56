"""`Vehicle`: a chassis as a VDA 5050 vehicle. The broker on one side, the chassis on the other, the order
machine in between.

One thread owns the machine. It waits for whatever comes: a message, a position, the end of a drive or of an
action, a due time. That is told to the machine, and the effects are carried out in their order: state on
disk, state to the broker, then the drive or the action. An order is on disk before the machine takes it;
while the disk takes nothing, no order is taken and nothing begins. Callbacks of the broker and of the chassis
only leave something in the inbox.
"""

from __future__ import annotations

import math
import threading
import time
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from rosproto.logs import get_logger
from rosproto.version import __version__
from woosh_pure.fleet.action_runner import ActionRunner
from woosh_pure.fleet.broker import Broker
from woosh_pure.fleet.config import VehicleConfig
from woosh_pure.fleet.driver import Driver
from woosh_pure.fleet.driving_lease import DrivingLease
from woosh_pure.fleet.equipment import equipment_of
from woosh_pure.fleet.inbox import Inbox, Lane, Left, Malformed, Message
from woosh_pure.fleet.messages.elements import Order
from woosh_pure.fleet.messages.header import check_header
from woosh_pure.fleet.messages.parsing import parse, read_instant_actions, read_order
from woosh_pure.fleet.messages.schema import Invalid
from woosh_pure.fleet.monitor import SILENT_AFTER, ChassisMonitor
from woosh_pure.fleet.order.deviation import AgvPosition, within_deviation
from woosh_pure.fleet.order.effects import Begin, Changed, Drive, Effect, End, Factsheet, Halt, Retry, StopAll
from woosh_pure.fleet.order.errors import ErrorType, Level, Problem
from woosh_pure.fleet.order.machine import OrderMachine
from woosh_pure.fleet.order_storage import OrderStorage
from woosh_pure.fleet.outline import outline_of
from woosh_pure.fleet.publisher import Publisher
from woosh_pure.fleet.store import Store

if TYPE_CHECKING:
    from types import TracebackType

    from woosh_pure.chassis import Chassis

__all__ = ["Vehicle"]

_log = get_logger("woosh_pure.fleet.vehicle")
STATE_EVERY = 25.0
"""Seconds between two states at most; the standard asks for 30."""
_AGAIN_SECONDS = 1.5  # until the state is told once more after the connection has come back
_DISK_SECONDS = 2.0  # between two tries of a disk that is full, or cannot be written
_TOGETHER_SECONDS = 0.2  # for which messages that wait are answered by one state
_DROPPED_SECONDS = 5.0  # between two looks whether more messages were dropped
_FACTS_SECONDS = 3.0  # for the chassis to tell where it is, before the fleet manager may send orders
_END_SECONDS = 10.0  # for the thread to end
_REST_SECONDS = 10.0  # without a stand after which it is told that a cancel or a pause waits for it
_SLOWING_SECONDS = 2.0  # from the beginning of a drive, for the robot to come down to the speed of its edge
_FAST_SECONDS = 0.3
_FASTER, _FASTER_BY = 1.1, 0.05  # of the speed allowed, and m/s: what a controller goes beyond it
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
        equipment = equipment_of(config, store, self._report)
        self._journal, self._maps, self._triggers = equipment.journal, equipment.maps, equipment.triggers
        self.limits, self.facts = equipment.limits, equipment.facts
        self._inbox = Inbox()
        self._due = self._inbox.due
        self._machine = OrderMachine(self.limits)
        self._publisher = Publisher(config, broker, self._on_message, self._on_connected, self._journal)
        self._mqtt = self._publisher.connection
        self._monitor = ChassisMonitor(chassis, self.facts, self._on_moved, self._on_told, self._on_described)
        self._driver = Driver(
            chassis, self._on_drive_ended, self._on_stopped, lambda: self.facts.position, marks=config.marks
        )
        self._actions = ActionRunner(chassis, equipment.handlers, self._on_action_ended)
        self._storage = OrderStorage(store, config.prefix, self._on_disk_failed, self._on_disk_recovered)
        self._lease = DrivingLease(chassis, config.serial, self._due)
        self._thread: threading.Thread | None = None
        self._end_lease: Callable[[], object] = lambda: None
        self._moving = False
        self._ended = 0.0  # when something that moves the robot ended last
        self._driven = 0.0  # when the newest drive was given out
        self._fast_since: float | None = None  # from when on it is faster than its edge allows
        self._was_blocked = ""
        self._owed = False  # the state has changed, and was not told
        self._told = 0.0
        self._told_dropped: Counter[Lane] = Counter()

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
        """Restore what was kept, listen to the chassis, connect with the broker; returns at once.

        Raises:
            StoreInUse: Another vehicle with this manufacturer and serial keeps its order in the same folder.
        """
        if self._thread is None:
            self._storage.lock()
            self._monitor.open()  # what it hears comes while a drive of before is ended
            self._restore()
            if self._maps is not None:
                self._maps.confirm(self.chassis)
                self._use_maps()
            threading.Thread(target=self._learn_outline, name="woosh:outline", daemon=True).start()
            self._inbox.flag("told")
            self._end_lease = self._lease.on_change(lambda: self._inbox.flag("lease"))
            now = time.monotonic()
            self._due.update({"state": now, "silent": now + SILENT_AFTER, "connect": now + _FACTS_SECONDS})
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
        if not self._inbox.close():
            return
        self._actions.end_all()
        self._driver.close()
        thread = self._thread
        if thread is not None and thread is not threading.current_thread():
            thread.join(_END_SECONDS)
            if not thread.is_alive():
                self._end_in_order()
        self._end_lease()
        self._lease.release()
        self._monitor.close()
        self._mqtt.close()
        self._storage.unlock()

    def _end_in_order(self) -> None:
        """The last word of the machine, when its thread is over. What it still asks for is being done."""
        self._actions.join(_ACTIONS_SECONDS)
        effects = self._machine.shut_down("the vehicle's software was ended in order")
        if any(isinstance(effect, Changed) for effect in effects):
            self._publish()
        self._save()

    @property
    def connected(self) -> bool:
        """Whether it is connected with the broker."""
        return self._mqtt.connected.is_set()

    @property
    def dropped(self) -> int:
        """Messages of the fleet manager that came faster than they were read."""
        return self._inbox.dropped.total()

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
        restored = self._storage.restore(self.limits)
        if restored is not None:
            self._machine = restored
            # What the process before this one had sent may still be under way: then it is stopped now.
            self._carry_out(self._machine.set_standing(False))

    # -- from other threads ----------------------------------------------------------------------------------

    def _on_message(self, topic: str, payload: bytes) -> None:
        _log.debug("< %s %s, %d bytes", self.config.prefix, topic, len(payload))
        if self._journal is not None:
            self._journal.note(f"< {topic} {payload[:300]!r}")
        self._inbox.add_message(self._read(topic, payload))

    def _read(self, topic: str, payload: bytes) -> Message:
        data: Mapping[str, Any] = {}
        try:
            data, ours = parse(payload), self.config
            check_header(data, version=ours.version, manufacturer=ours.manufacturer, serial=ours.serial)
            return read_order(data) if topic == "order" else read_instant_actions(data)
        except Invalid as error:
            return Malformed(topic, data, error)

    def _on_connected(self, connected: bool) -> None:
        if connected:
            self._inbox.flag("connected")

    def _on_moved(self) -> None:
        """Ten times a second for each robot that drives: the thread is only woken up for what may matter."""
        facts, machine = self.facts, self._machine
        rests = machine.standing or machine.driving
        news = facts.lost or not facts.located or facts.moving != self._moving or not rests
        if news or self._at_node() or self._fast_since is not None or self._too_fast():
            self._inbox.flag("moved")

    def _at_node(self) -> bool:
        """Whether the drive under way has come into the range of its node."""
        drive = self._machine.drive
        return drive is not None and within_deviation(self.facts.position, drive.node, self.limits)

    def _on_told(self) -> None:
        self._inbox.flag("told")

    def _on_described(self) -> None:
        self._inbox.flag("described")

    def _on_drive_ended(self, token: int, arrived: bool, text: str, known: bool) -> None:
        self._inbox.call(lambda: self._drive_ended(token, arrived, text, known))

    def _on_stopped(self, standing: bool) -> None:
        self._inbox.call(lambda: self._stop_ended(standing))

    def _on_action_ended(self, action_id: str, ok: bool, text: str, known: bool) -> None:
        self._inbox.call(lambda: self._action_ended(action_id, ok, text, known))

    def _drive_ended(self, token: int, arrived: bool, text: str, known: bool) -> list[Effect]:
        self._ended = time.monotonic()
        before = self._machine.set_position(self._position())
        return [*before, *self._machine.drive_ended(token, arrived, text, known=known)]

    def _stop_ended(self, standing: bool) -> list[Effect]:
        self._ended = time.monotonic()
        return self._machine.stop_ended(standing)

    # -- the one thread --------------------------------------------------------------------------------------

    def _run(self) -> None:
        while (left := self._inbox.wait()) is not None:
            try:
                self._handle(left)
                self._on_time(time.monotonic())
            except Exception:
                _log.exception("! %s: a failure of our own; the vehicle goes on", self.config.prefix)

    def _handle(self, left: Left) -> None:
        flags, calls, message = left
        if "lease" in flags:
            self._lease.hand_over()
        if flags & {"told", "moved", "lease"} or message is not None:
            self._refresh(full=bool(flags & {"told", "lease"}) or not self.facts.located)
        for call in calls:
            self._carry_out(call())
        if message is not None:
            self._carry_out(self._receive(message))
        self._look_for_rest()
        if "dropped" in flags and "dropped" not in self._due:
            self._due["dropped"] = 0.0
        if self._owed and not self._inbox.waiting_messages:
            self._tell()
        if "connected" in flags or "described" in flags:
            self._factsheet()
        if "connected" in flags:
            self._publish()
            # A state is not retained: who comes back from the same loss a little later shall have it, too.
            self._due["state"] = time.monotonic() + _AGAIN_SECONDS
        if self.facts.moving != self._moving:
            self._moving = self.facts.moving
            self._publish()

    def _receive(self, message: Message) -> list[Effect]:
        if isinstance(message, Order):
            return self._take(message)
        if isinstance(message, Malformed):
            return self._machine.receive_malformed(message.data, message.error, message.topic)
        return self._machine.receive_instant(message)

    def _look_for_rest(self) -> None:
        """A cancel or a pause that waits for a stand is told after a while."""
        if self._machine.waits_for_rest:
            self._due.setdefault("rest", time.monotonic() + _REST_SECONDS)
        elif self._due.pop("rest", None) is not None:
            self._carry_out(self._machine.set_problem("rest", None))

    def _tell_dropped(self) -> None:
        """What was not read is told as an error, until nothing more was dropped for a while."""
        dropped = self._inbox.dropped
        if dropped == self._told_dropped:
            del self._due["dropped"]
            self._carry_out(self._machine.set_problem("dropped", None))
            return
        counted = ", ".join(f"{lane.value}: {n}" for lane, n in dropped.items())
        text = f"messages came faster than they are read, and were dropped since the start: {counted}"
        _log.warning("! %s: %s", self.config.prefix, text)
        hint = "send less at a time, and wait for the state that answers"
        problem = Problem(ErrorType.DROPPED, text, (), Level.WARNING, hint)
        self._due["dropped"], self._told_dropped = time.monotonic() + _DROPPED_SECONDS, dropped.copy()
        self._carry_out(self._machine.set_problem("dropped", problem))

    def _take(self, order: Order) -> list[Effect]:
        """What is acknowledged is there after a restart: the disk takes an order before the machine does."""
        error = self._storage.save_with(self._machine, order)
        if error is not None:
            text = f"the order cannot be kept on disk ({error}), so it is not taken"
            return self._machine.reject(order, text)
        return self._machine.receive(order)

    def _position(self) -> AgvPosition | None:
        return self.facts.position if self.facts.located and not self.facts.lost else None

    def _too_fast(self) -> float:
        """How fast it drives, where that is more than the edge under way allows; or else 0."""
        drive, velocity = self._machine.drive, self.facts.velocity
        limit = 0.0 if drive is None or drive.edge is None else float(drive.edge.options.get("maxSpeed", 0.0))
        speed = 0.0 if velocity is None else math.hypot(velocity[0], velocity[1])
        return speed if limit and speed > _FASTER * limit + _FASTER_BY else 0.0

    def _watch(self) -> None:
        """Whether it stands, and whether it is too fast, by the newest velocity."""
        now, machine = time.monotonic(), self._machine
        if not machine.driving:
            standing = not self.facts.lost and self._monitor.stood(self._ended)
            if standing != machine.standing:
                self._carry_out(machine.set_standing(standing))
        speed = self._too_fast()
        if not speed:
            self._fast_since = None
            return
        if self._fast_since is None:
            self._fast_since = max(now, self._driven + _SLOWING_SECONDS)
        if now - self._fast_since >= _FAST_SECONDS and machine.drive is not None:
            edge = machine.drive.edge
            name, limit = ("", 0.0) if edge is None else (edge.id, edge.options["maxSpeed"])
            text = f"it drove at {speed:.2f} m/s, and edge {name} allows {limit:g} m/s; it is halted"
            self._carry_out(machine.drive_too_fast(text))

    def _refresh(self, *, full: bool) -> None:
        if self.facts.lost and not self._monitor.silent:
            self.facts.lost, full = False, True
            self._ended = time.monotonic()  # what was measured before is no news
            self._carry_out(self._machine.set_heard(True))
            self._carry_out(self._machine.set_problem("lost", None))
        if full:
            before = self.facts.alarms
            self._monitor.refresh(self._lease.local_driver)
            if self._monitor.heard:
                self._carry_out(self._machine.set_mode(self._monitor.mode))
            if before != self.facts.alarms:
                self._publish()
        self._carry_out(self._machine.set_position(self._position()))
        self._watch()
        if "connect" in self._due and self.facts.located and self.facts.percent is not None:
            self._due["connect"] = 0.0  # ONLINE says that orders are taken
        if full:
            freed, self._was_blocked = self._was_blocked and not self._monitor.blocked, self._monitor.blocked
            if freed:
                self._carry_out(self._machine.retry())

    def _on_time(self, now: float) -> None:
        for name in [name for name, due in self._due.items() if due <= now]:
            if name == "state":
                self._publish()
            elif name == "visualization":
                self._due[name] = now + self.config.visualization
                self._publisher.send_visualization(self.facts)
            elif name == "dropped":
                self._tell_dropped()
            elif name == "rest":
                self._due[name] = now + _REST_SECONDS
                text = (
                    f"the robot was not measured standing for {_REST_SECONDS:g} s after it was told to stop"
                )
                hint = "look at the robot; its own stop button stops it"
                problem = Problem(ErrorType.STILL_MOVING, text, (), Level.WARNING, hint)
                self._carry_out(self._machine.set_problem("rest", problem))
            elif name == "disk":
                del self._due[name]
                self._save()
            elif name == "retry":
                del self._due[name]
                self._carry_out(self._machine.retry())
            elif name == "lease":
                if not self._lease.renew(self._machine.executing):
                    self._inbox.flag("told")
            elif name == "connect":
                del self._due[name]
                self._mqtt.open()
            elif name == "silent":
                self._due[name] = max(self._monitor.heard + SILENT_AFTER, now + 0.2)
                self._look_for_silence()

    def _look_for_silence(self) -> None:
        if self.facts.lost or not self._monitor.silent:
            return
        self.facts.may_move = self.facts.moving or not self._machine.at_rest
        self.facts.lost, self.facts.velocity = True, None
        self._carry_out(self._machine.set_heard(False))
        self._carry_out(self._machine.set_problem("lost", self._monitor.silence()))
        self._carry_out(self._machine.set_position(None))

    # -- effects ---------------------------------------------------------------------------------------------

    def _carry_out(self, effects: list[Effect]) -> None:
        # What stops waits for no disk and no broker.
        for effect in effects:
            if isinstance(effect, Halt):
                self._driver.halt(effect.token)
            elif isinstance(effect, StopAll):
                self._driver.stop_all(effect.after)
            elif isinstance(effect, End):
                self._actions.end(effect.action_id)
        if any(isinstance(effect, Changed) for effect in effects):
            self._owed = True
            if all(isinstance(effect, Changed) for effect in effects) and self._busy():
                return  # nothing follows from it: the next state tells it, too
            self._tell()
        for effect in effects:
            if isinstance(effect, Drive):
                self._driven = time.monotonic()
                self._driver.drive(effect)
            elif isinstance(effect, Begin):
                self._actions.begin(effect)
            elif isinstance(effect, Retry):
                self._due["retry"] = time.monotonic() + effect.after
            elif isinstance(effect, Factsheet):
                self._factsheet()

    def _busy(self) -> bool:
        """Whether what has changed may be told with the next message: a stop waits, or many messages do."""
        waits = self._inbox.waiting_messages > 0 and time.monotonic() < self._told + _TOGETHER_SECONDS
        return self._inbox.stop_waits or waits

    def _tell(self) -> None:
        """Put what has changed on disk, then tell it."""
        self._owed, self._told = False, time.monotonic()
        self._lease.hold(self._machine.executing)
        self._save()
        self._publish()

    def _action_ended(self, action_id: str, ok: bool, text: str, known: bool) -> list[Effect]:
        self._actions.forget(action_id)
        if self.facts.loads is not None:
            self.facts.loads = tuple(self._actions.loads)
        self._use_maps()
        self._monitor.refresh(self._lease.local_driver)  # a pose that was given is known now
        effects = self._machine.action_ended(action_id, ok, text, known=known)
        if not self._machine.standing:
            self._ended = time.monotonic()
        return [*effects, *self._machine.set_position(self._position())]

    def _use_maps(self) -> None:
        if self._maps is not None:
            facts = self.facts
            facts.maps, facts.map_id = self._maps.entries, self._maps.active
            if facts.position is not None:
                facts.position = replace(facts.position, map_id=facts.map_id)
            self.limits = replace(self.limits, maps=self._maps.enabled_ids)
            self._machine.limits = replace(self._machine.limits, maps=self.limits.maps)

    def _report(self, reason: str) -> str:
        """logReport: its name is the result, and stands in the state's information."""
        assert self._journal is not None
        facts = {
            "vehicle": self.config.prefix, "version": __version__, "chassis": self.chassis.master_uri,
            "readiness": self.chassis.readiness().sentence(), "facts": repr(self.facts),
            "order": self._storage.kept,
        }  # fmt: skip
        name = self._journal.write(reason, facts)
        self.facts.information = (("logReport", name),)
        return name

    # -- disk, broker, lease ---------------------------------------------------------------------------------

    def _save(self) -> None:
        self._storage.save(self._machine)

    def _on_disk_failed(self, problem: Problem | None) -> None:
        self._due["disk"] = time.monotonic() + _DISK_SECONDS
        if problem is not None:
            self._actions.defer()
            self._inbox.call(lambda: self._machine.set_storage_problem(problem))

    def _on_disk_recovered(self) -> None:
        self._actions.resume()
        self._inbox.call(lambda: self._machine.set_storage_problem(None))

    def _publish(self) -> None:
        self._due["state"] = time.monotonic() + STATE_EVERY
        self._publisher.send_state(self._machine, self.facts)

    def _factsheet(self) -> None:
        self._publisher.send_factsheet(self.limits, self._monitor.parameters)

    def _learn_outline(self) -> None:
        """What the navigation takes for the robot's outline goes before what the configuration says."""
        found = outline_of(self.chassis)
        if found:
            self._publisher.outline = found
            self._inbox.flag("described")
