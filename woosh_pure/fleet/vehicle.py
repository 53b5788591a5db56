"""`Vehicle`: a chassis as a VDA 5050 vehicle. The broker on one side, the chassis on the other, the order
machine in between.

One thread owns the order. It waits for whatever comes: a message, a position, the end of a drive or of an
action, a due time. Each of them is an event of the order machine, and its effects are carried out in their
order: what stops, state on disk, state to the broker, then the drive or the action. Callbacks of the broker
and of the chassis only leave something in the inbox.
"""

from __future__ import annotations

import threading
import time
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from types import TracebackType
from typing import Any

from rosproto.logs import get_logger
from rosproto.version import __version__
from woosh_pure.chassis import Chassis
from woosh_pure.fleet.action_runner import ActionRunner
from woosh_pure.fleet.broker_address import Broker
from woosh_pure.fleet.broker_connection import BrokerConnection
from woosh_pure.fleet.config import VehicleConfig
from woosh_pure.fleet.drive_runner import DriveRunner
from woosh_pure.fleet.driving_lease import DrivingLease
from woosh_pure.fleet.edge_speed import EdgeSpeedMonitor, speed_above_limit
from woosh_pure.fleet.inbox import Inbox, InboxContents, Message, MessageKind
from woosh_pure.fleet.messages.elements import Order
from woosh_pure.fleet.messages.parsing import parse, read_instant_actions, read_order
from woosh_pure.fleet.messages.schema import Invalid, check_header
from woosh_pure.fleet.monitor import SILENT_AFTER, ChassisMonitor
from woosh_pure.fleet.order import events
from woosh_pure.fleet.order.errors import ErrorType, Level, Problem
from woosh_pure.fleet.order.events import Effect, Event
from woosh_pure.fleet.order.state import OrderState
from woosh_pure.fleet.order.vehicle_limits import AgvPosition, within_deviation
from woosh_pure.fleet.persistent_order import PersistentOrder
from woosh_pure.fleet.published_messages import MessageHeaders, connection_message
from woosh_pure.fleet.publisher import MessagePublisher
from woosh_pure.fleet.state_file import Store, StoreInUse
from woosh_pure.fleet.vehicle_setup import navigation_footprint, set_up_vehicle

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
        equipment = set_up_vehicle(config, store, self._report)
        self._journal, self._maps, self._triggers = equipment.journal, equipment.maps, equipment.triggers
        self.limits, self.facts = equipment.limits, equipment.facts
        self._inbox = Inbox()
        self._due = self._inbox.due
        self._order = PersistentOrder(self.limits, store, config.prefix)
        self._store = store
        self._headers = MessageHeaders(config.version, config.manufacturer, config.serial)
        self._connection = BrokerConnection(
            broker, config.prefix, self._connection_message, self._on_message, self._on_connected
        )
        self._publisher = MessagePublisher(config, self._connection, self._headers, self._journal)
        self._monitor = ChassisMonitor(
            chassis, self.facts, self._on_moved, self._on_told, self._on_described, self._on_planned
        )
        self._driver = DriveRunner(
            chassis, self._inbox.report, lambda: self.facts.position, marks=config.marks
        )
        self._actions = ActionRunner(chassis, equipment.handlers, self._inbox.report)
        self._lease = DrivingLease(chassis, config.serial, self._due)
        self._do: dict[type, Callable[[Any], object]] = {
            events.Halt: lambda effect: self._driver.halt(effect.token),
            events.StopAll: lambda effect: self._driver.stop_all(effect.after),
            events.EndAction: lambda effect: self._actions.end(effect.action_id),
            events.PublishState: lambda effect: self._tell(),
            events.Drive: self._drive,
            events.BeginAction: self._actions.begin,
            events.ScheduleRetry: self._retry_after,
            events.PublishFactsheet: lambda effect: self._factsheet(),
        }
        self._thread: threading.Thread | None = None
        self._end_lease: Callable[[], object] = lambda: None
        self._moving = False
        self._ended = 0.0  # when something that moves the robot ended last
        self._edge_speed = EdgeSpeedMonitor()
        self._planned = 0  # the newest drive whose path was told
        self._was_blocked = ""
        self._told = 0.0
        self._told_dropped: Counter[MessageKind] = Counter()

    # -- life ------------------------------------------------------------------------------------------------

    def __enter__(self) -> Vehicle:
        return self.open()

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<Vehicle {self.config.prefix}: order {self._state.order_id or 'none'}>"

    def open(self) -> Vehicle:
        """Restore what was kept, listen to the chassis, connect with the broker; returns at once.

        Raises:
            StoreInUse: Another vehicle with this manufacturer and serial keeps its order in the same folder.
        """
        if self._thread is None:
            self._lock_store()
            self._monitor.open()  # what it hears comes while a drive of before is ended
            # What the process before this one had sent may still be under way: then it is stopped now.
            self._carry_out(self._order.restore())
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
            self._write()  # a disk that takes nothing is told before an order comes
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
        self._connection.close()
        if self._store is not None:
            self._store.unlock()

    def _lock_store(self) -> None:
        """A disk that takes nothing is no reason not to start: it is told, and tried again."""
        try:
            if self._store is not None:
                self._store.lock()
        except StoreInUse:
            raise
        except OSError as error:
            _log.warning("! %s: %s cannot be locked: %s", self.config.prefix, self._store, error)

    def _end_in_order(self) -> None:
        """The last word of the machine, when its thread is over. What it still asks for is being done."""
        self._actions.join(_ACTIONS_SECONDS)
        self._happens(events.ShutDown("the vehicle's software was ended in order"))
        self._write()

    @property
    def _state(self) -> OrderState:
        return self._order.state

    @property
    def connected(self) -> bool:
        """Whether it is connected with the broker."""
        return self._connection.connected.is_set()

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
        return self._triggers.fire(name)

    def wait_connected(self, timeout: float = 10.0) -> bool:
        """Wait for the broker; whether it is there."""
        return self._connection.connected.wait(timeout)

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
            return events.MalformedMessage(data, error, topic)

    def _on_connected(self, connected: bool) -> None:
        if connected:
            self._inbox.flag("connected")

    def _on_moved(self) -> None:
        """Ten times a second for each robot that drives: the thread is only woken up for what may matter."""
        facts, state = self.facts, self._state
        rests = state.standing or state.driving
        news = facts.lost or not facts.located or facts.moving != self._moving or not rests
        fast = self._edge_speed.above_limit or speed_above_limit(state.drive, facts.velocity)
        if news or fast or self._at_node():
            self._inbox.flag("moved")

    def _at_node(self) -> bool:
        """Whether the drive under way has come into the range of its node."""
        drive = self._state.drive
        return drive is not None and within_deviation(self.facts.position, drive.node, self.limits)

    def _on_told(self) -> None:
        self._inbox.flag("told")

    def _on_described(self) -> None:
        self._inbox.flag("described")

    def _on_planned(self) -> None:
        """The first path of each drive is told at once, another one with the next state."""
        drive = self._state.drive
        if drive is not None and drive.token != self._planned and self.facts.has_path_to(drive.node):
            self._planned = drive.token
            self._inbox.flag("planned")

    # -- the one thread --------------------------------------------------------------------------------------

    def _run(self) -> None:
        while (left := self._inbox.wait()) is not None:
            try:
                self._handle(left)
                self._on_time(time.monotonic())
            except Exception:
                _log.exception("! %s: a failure of our own; the vehicle goes on", self.config.prefix)

    def _handle(self, left: InboxContents) -> None:
        flags, reported, message = left
        if "lease" in flags:
            self._lease.hand_over()
        if flags & {"told", "moved", "lease"} or message is not None:
            self._refresh(full=bool(flags & {"told", "lease"}) or not self.facts.located)
        for event in reported:
            self._robot_reports(event)
        if message is not None:
            self._happens(message)
        self._look_for_rest()
        if "dropped" in flags and "dropped" not in self._due:
            self._due["dropped"] = 0.0
        if self._order.owed and not self._inbox.waiting_messages:
            self._write()
        if "connected" in flags or "described" in flags:
            self._factsheet()
        if "connected" in flags:
            self._publish()
            # A state is not retained: who comes back from the same loss a little later shall have it, too.
            self._due["state"] = time.monotonic() + _AGAIN_SECONDS
        if self.facts.moving != self._moving or "planned" in flags:
            self._moving = self.facts.moving
            self._publish()

    def _robot_reports(self, event: Event) -> None:
        """Something that moves the robot has ended, or an action."""
        if isinstance(event, events.ActionEnded):
            self._actions.forget(event.action_id)
            if self.facts.loads is not None:
                self.facts.loads = tuple(self._actions.loads)
            self._use_maps()
            self._monitor.refresh(self._lease.local_driver)  # a pose that was given is known now
            self._happens(event)
            if not self._state.standing:
                self._ended = time.monotonic()
            self._happens(events.PositionMeasured(self._position()))
            return
        self._ended = time.monotonic()
        if isinstance(event, events.DriveEnded):
            self._happens(events.PositionMeasured(self._position()))
        self._happens(event)

    def _look_for_rest(self) -> None:
        """A cancel or a pause that waits for a stand is told after a while."""
        if self._state.waits_for_rest:
            self._due.setdefault("rest", time.monotonic() + _REST_SECONDS)
        elif self._due.pop("rest", None) is not None:
            self._happens(events.ProblemChanged("rest", None))

    def _tell_dropped(self) -> None:
        """What was not read is told as an error, until nothing more was dropped for a while."""
        dropped = self._inbox.dropped
        if dropped == self._told_dropped:
            del self._due["dropped"]
            self._happens(events.ProblemChanged("dropped", None))
            return
        counted = ", ".join(f"{lane.value}: {n}" for lane, n in dropped.items())
        text = f"messages came faster than they are read, and were dropped since the start: {counted}"
        _log.warning("! %s: %s", self.config.prefix, text)
        hint = "send less at a time, and wait for the state that answers"
        problem = Problem(ErrorType.DROPPED, text, (), Level.WARNING, hint)
        self._due["dropped"], self._told_dropped = time.monotonic() + _DROPPED_SECONDS, dropped.copy()
        self._happens(events.ProblemChanged("dropped", problem))

    def _position(self) -> AgvPosition | None:
        return self.facts.position if self.facts.located and not self.facts.lost else None

    def _watch(self) -> None:
        """Whether it stands, and whether it is too fast, by the newest velocity."""
        now = time.monotonic()
        if not self._state.driving:
            standing = not self.facts.lost and self._monitor.stood(self._ended)
            if standing != self._state.standing:
                self._happens(events.StandingMeasured(standing))
        text = self._edge_speed.check(self._state.drive, self.facts.velocity, now)
        if text is not None:
            self._happens(events.DriveTooFast(text))

    def _refresh(self, *, full: bool) -> None:
        if self.facts.lost and not self._monitor.silent:
            self.facts.lost, full = False, True
            self._ended = time.monotonic()  # what was measured before is no news
            self._happens(events.ContactChanged(True))
            self._happens(events.ProblemChanged("lost", None))
        if full:
            before = self.facts.alarms
            self._monitor.refresh(self._lease.local_driver)
            if self._monitor.heard:
                self._happens(events.ModeChanged(self._monitor.mode))
            if before != self.facts.alarms:
                self._publish()
        self._happens(events.PositionMeasured(self._position()))
        self._watch()
        if "connect" in self._due and self.facts.located and self.facts.percent is not None:
            self._due["connect"] = 0.0  # ONLINE says that orders are taken
        if full:
            freed, self._was_blocked = self._was_blocked and not self._monitor.blocked, self._monitor.blocked
            if freed:
                self._happens(events.RetryDue())

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
                self._happens(events.ProblemChanged("rest", problem))
            elif name == "disk":
                del self._due[name]
                self._write()
            elif name == "retry":
                del self._due[name]
                self._happens(events.RetryDue())
            elif name == "lease":
                if not self._lease.renew(self._state.executing):
                    self._inbox.flag("told")
            elif name == "connect":
                del self._due[name]
                self._connection.open()
            elif name == "silent":
                self._due[name] = max(self._monitor.heard + SILENT_AFTER, now + 0.2)
                self._look_for_silence()

    def _look_for_silence(self) -> None:
        if self.facts.lost or not self._monitor.silent:
            return
        self.facts.may_move = self.facts.moving or not self._state.at_rest
        self.facts.lost, self.facts.velocity = True, None
        self._happens(events.ContactChanged(False))
        self._happens(events.ProblemChanged("lost", self._monitor.silence()))
        self._happens(events.PositionMeasured(None))

    # -- effects ---------------------------------------------------------------------------------------------

    def _happens(self, event: Event) -> None:
        """An event of the order machine, with all that it leads to. An order is written before it is
        answered."""
        later = self._busy() and not isinstance(event, Order)
        self._carry_out(self._order.happens(event, later=later))

    def _write(self) -> None:
        """Write and tell what was put off; or try a disk again that took nothing."""
        self._carry_out(self._order.write())

    def _carry_out(self, effects: Iterable[Effect]) -> None:
        for effect in effects:
            self._do[type(effect)](effect)
        if self._order.failing:
            self._due.setdefault("disk", time.monotonic() + _DISK_SECONDS)

    def _tell(self) -> None:
        self._told = time.monotonic()
        self._lease.hold(self._state.executing)
        self._publish()

    def _drive(self, effect: events.Drive) -> None:
        self._edge_speed.drive_began(time.monotonic())
        self._driver.drive(effect)

    def _retry_after(self, effect: events.ScheduleRetry) -> None:
        self._due["retry"] = time.monotonic() + effect.after

    def _busy(self) -> bool:
        """Whether what has changed may be told with the next message: a stop waits, or many messages do."""
        waits = self._inbox.waiting_messages > 0 and time.monotonic() < self._told + _TOGETHER_SECONDS
        return self._inbox.stop_waits or waits

    def _use_maps(self) -> None:
        if self._maps is not None:
            facts = self.facts
            facts.maps, facts.map_id = self._maps.entries, self._maps.active
            if facts.position is not None:
                facts.position = replace(facts.position, map_id=facts.map_id)
            self.limits = replace(self.limits, maps=self._maps.enabled_ids)
            self._happens(events.MapsChanged(self.limits.maps))

    def _report(self, reason: str) -> str:
        """logReport: its name is the result, and stands in the state's information."""
        assert self._journal is not None
        facts = {
            "vehicle": self.config.prefix, "version": __version__, "chassis": self.chassis.master_uri,
            "readiness": self.chassis.readiness().sentence(), "facts": repr(self.facts),
            "order": self._state.to_json(),
        }  # fmt: skip
        name = self._journal.write(reason, facts)
        self.facts.information = (("logReport", name),)
        return name

    # -- broker ----------------------------------------------------------------------------------------------

    def _connection_message(self, state: str) -> dict[str, Any]:
        return connection_message(state, self._headers.header("connection", time.time()))

    def _publish(self) -> None:
        self._due["state"] = time.monotonic() + STATE_EVERY
        self._publisher.send_state(self._state, self.facts)

    def _factsheet(self) -> None:
        self._publisher.send_factsheet(self.limits, self._monitor.parameters)

    def _learn_outline(self) -> None:
        """What the navigation takes for the robot's outline goes before what the configuration says."""
        found = navigation_footprint(self.chassis)
        if found:
            self._publisher.outline = found
            self._inbox.flag("described")
