"""`Vehicle`: a chassis as a VDA 5050 vehicle. It connects the broker, the order machine and the chassis.

One thread owns the order. It waits for messages, positions, ends of drives and actions, and due times. Each
of them is an event of the order machine, and its effects are carried out in their order. Callbacks of the
broker and of the chassis only put something into the inbox.
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
from woosh_pure.fleet.action_handlers.custom_actions import Triggers
from woosh_pure.fleet.action_handlers.maps import MapStore
from woosh_pure.fleet.action_handlers.predefined_actions import supported_actions
from woosh_pure.fleet.action_handlers.running_action import ActionRunner
from woosh_pure.fleet.broker_connection import BrokerConnection
from woosh_pure.fleet.chassis_facts import ChassisFacts, MapEntry
from woosh_pure.fleet.config import Broker, VehicleConfig
from woosh_pure.fleet.drive_runner import DriveRunner, DrivingLease
from woosh_pure.fleet.inbox import Inbox, InboxContents, Message, MessageKind
from woosh_pure.fleet.messages.elements import Order
from woosh_pure.fleet.messages.parsing import Invalid, check_header, parse, read_instant_actions, read_order
from woosh_pure.fleet.monitor import (
    SILENT_AFTER,
    ChassisMonitor,
    EdgeSpeedMonitor,
    StandingCheck,
    navigation_footprint,
)
from woosh_pure.fleet.order import events
from woosh_pure.fleet.order.errors import ErrorType, Level, Problem
from woosh_pure.fleet.order.events import Effect, Event
from woosh_pure.fleet.order.rules import goes_on_from
from woosh_pure.fleet.order.vehicle_limits import AgvPosition, Capabilities, within_deviation
from woosh_pure.fleet.persistent_order import PersistentOrder
from woosh_pure.fleet.published_messages import (
    MessageHeaders,
    StateMessages,
    factsheet_message,
    visualization_message,
)
from woosh_pure.fleet.state_file import Journal
from woosh_pure.state_file import Store, StoreInUse

_log = get_logger("woosh_pure.fleet.vehicle")
STATE_EVERY = 25.0
"""Longest time between two states, seconds; the standard requires 30."""
_AGAIN_SECONDS = 1.5  # until the state is published again after a reconnect
_DISK_SECONDS = 2.0  # between two attempts to write to a failing disk
_TOGETHER_SECONDS = 0.2  # in which one state answers all waiting messages
_DROPPED_SECONDS = 5.0  # between two checks for dropped messages
_FACTS_SECONDS = 3.0  # for the chassis to report its position, before the broker is connected
_END_SECONDS = 10.0  # for the end of the thread
_REST_SECONDS = 10.0  # of waiting for a stand, after which a waiting cancel or pause is reported
_ACTIONS_SECONDS = 3.5  # for actions to end when the vehicle is closed; programs are killed after 3


class Vehicle:
    """One chassis under a fleet manager. Use it in a `with` block, or call `open` and `close`.

    Nothing moves before an order arrives. Leaving the block halts the drive, ends the order, publishes this,
    and sends OFFLINE. After any other end (kill -9, a loss of power) the order is restored at the next start,
    and waits.

    Args:
        chassis: An open chassis; the caller closes it.
        config: The vehicle's configuration.
        broker: The broker.
        store: The file of its order; None stores nothing: a restart forgets the order.

    Raises:
        ImportError: paho-mqtt is not installed; the text names the extra.
        ValueError: A configured action cannot be loaded.
    """

    def __init__(
        self, chassis: Chassis, config: VehicleConfig, broker: Broker, store: Store | None = None
    ) -> None:
        self.chassis, self.config = chassis, config
        own = MapEntry(config.map_id, config.map_version)
        self._journal = self._maps = None
        if store is not None:  # reports and maps are stored beside the order
            self._journal = Journal(store.path.parent / "logs", store.path.stem)
            if config.map_actions:
                self._maps = MapStore(store.path.parent / "maps" / store.path.stem, own)
        self._triggers = Triggers()
        actions = supported_actions(
            config,
            maps=self._maps,
            report=None if store is None else self._write_report,
            triggers=self._triggers,
        )
        self.limits = Capabilities(
            actions={name: supported for name, (supported, _) in actions.items()},
            maps=(config.map_id,) if self._maps is None else self._maps.enabled_ids,
            tolerance=config.tolerance,
            turn_tolerance=config.turn_tolerance,
            marks=config.marks,
            zone_set=config.zone_set,
        )
        self.facts = ChassisFacts(
            map_id=config.map_id, maps=(own,), zone_set=config.zone_set, loads=() if config.marks else None
        )
        self._inbox = Inbox()
        self._due = self._inbox.due
        self._order = PersistentOrder(self.limits, store, config.prefix)
        self._store = store
        self._headers = MessageHeaders(config.version, config.manufacturer, config.serial)
        self._states = StateMessages(config.version)
        self._connection = BrokerConnection(
            broker, config.prefix, self._headers.connection_message, self._on_message, self._on_connected
        )
        self._outline = tuple((float(x), float(y)) for x, y in config.footprint)  # for the factsheet
        self._monitor = ChassisMonitor(chassis, self.facts, self._on_motion, self._on_path, self._inbox.flag)
        self._standing = StandingCheck(chassis, lambda: self._inbox.flag("motion"))
        self._driver = DriveRunner(
            chassis, self._inbox.report, lambda: self.facts.position, marks=config.marks
        )
        handlers = {name: handler for name, (_, handler) in actions.items()}
        self._actions = ActionRunner(chassis, handlers, self._inbox.report)
        self._lease = DrivingLease(chassis, config.serial, self._due)
        self._effect_handlers: dict[type, Callable[[Any], object]] = {
            events.Halt: lambda effect: self._driver.halt(effect.token),
            events.StopAll: lambda effect: self._driver.stop_all(effect.after),
            events.EndAction: lambda effect: self._actions.end(effect.action_id),
            events.PublishState: lambda effect: self._publish_after_event(),
            events.Drive: self._drive,
            events.BeginAction: self._actions.begin,
            events.ScheduleRetry: lambda effect: self._due.update(retry=time.monotonic() + effect.after),
            events.PublishFactsheet: lambda effect: self._publish_factsheet(),
        }
        self._calls = chassis.request()  # stops within it, and requests that are made within it, are our own
        self._thread: threading.Thread | None = None
        self._end_lease: Callable[[], object] = lambda: None
        self._moving = False
        self._motion_ended_at = 0.0  # when the last motion of the robot ended
        self._edge_speed = EdgeSpeedMonitor()
        self._path_of_drive = 0  # the newest drive whose path was published
        self._was_blocked = ""
        self._published_at = 0.0
        self._reported_dropped: Counter[MessageKind] = Counter()

    # -- opening and closing ---------------------------------------------------------------------------------

    def __enter__(self) -> Vehicle:
        return self.open()

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<Vehicle {self.config.prefix}: order {self._order.state.order_id or 'none'}>"

    def open(self) -> Vehicle:
        """Restore the order, listen to the chassis, connect to the broker; returns at once.

        Raises:
            StoreInUse: Another vehicle with this manufacturer and serial uses the same folder.
        """
        if self._thread is None:
            self._lock_store()
            self._monitor.open()  # it must listen while an earlier drive is being stopped
            # A drive of the process before may still be under way: then it is stopped now.
            with self._calls.renewed():
                self._carry_out(self._order.restore())
            if self._maps is not None:
                self._maps.confirm(self.chassis)
                self._use_maps()
            threading.Thread(target=self._learn_footprint, name="woosh:outline", daemon=True).start()
            self._inbox.flag("status")
            self._end_lease = self._lease.on_change(lambda: self._inbox.flag("lease"))
            now = time.monotonic()
            self._due.update({"state": now, "silent": now + SILENT_AFTER, "connect": now + _FACTS_SECONDS})
            if self.config.visualization:
                self._due["visualization"] = now
            self._write()  # a failing disk is reported before an order arrives
            self._thread = threading.Thread(
                target=self._run, name=f"woosh:vehicle-{self.config.serial}", daemon=True
            )
            self._thread.start()
        return self

    def close(self) -> None:
        """Halt, end the order and its actions, publish this, send OFFLINE. Takes bounded time; idempotent."""
        if not self._inbox.close():
            return
        self._actions.end_all()
        self._driver.close()
        thread = self._thread
        if thread is not None and thread is not threading.current_thread():
            thread.join(_END_SECONDS)
            if not thread.is_alive():  # drives and actions are being ended already
                self._actions.join(_ACTIONS_SECONDS)
                self._apply(events.ShutDown("the vehicle's software was ended in order"))
                self._write()
        self._end_lease()
        self._lease.release()
        self._monitor.close()
        self._connection.close()
        if self._store is not None:
            self._store.unlock()

    def _lock_store(self) -> None:
        """Lock the file. A failing disk does not prevent the start: it is reported and tried again."""
        try:
            if self._store is not None:
                self._store.lock()
        except StoreInUse:
            raise
        except OSError as error:
            _log.warning("! %s: %s cannot be locked: %s", self.config.prefix, self._store, error)

    @property
    def connected(self) -> bool:
        """Whether the broker is connected."""
        return self._connection.connected.is_set()

    @property
    def dropped(self) -> int:
        """Number of dropped messages of the fleet manager."""
        return self._inbox.dropped.total()

    def trigger(self, name: str) -> int:
        """Fire a trigger: finish every waitForTrigger action that waits for it now.

        Args:
            name: `triggerType`, one of the configuration's `triggers`. No units, no frame.

        Returns:
            The number of finished actions.
        """
        return self._triggers.fire(name)

    def wait_connected(self, timeout: float = 10.0) -> bool:
        """Wait until the broker is connected; False after the timeout."""
        return self._connection.connected.wait(timeout)

    # -- callbacks in other threads --------------------------------------------------------------------------

    def _on_message(self, topic: str, payload: bytes) -> None:
        _log.debug("< %s %s, %d bytes", self.config.prefix, topic, len(payload))
        if self._journal is not None:
            self._journal.note(f"< {topic} {payload[:300]!r}")
        call = self._calls.renewed()
        self._inbox.add_message(self._read(topic, payload), call)

    def _read(self, topic: str, payload: bytes) -> Message:
        data: Mapping[str, object] = {}
        try:
            data, ours = parse(payload), self.config
            check_header(data, version=ours.version, manufacturer=ours.manufacturer, serial=ours.serial)
            return read_order(data) if topic == "order" else read_instant_actions(data)
        except Invalid as error:
            return events.MalformedMessage(data, error, topic)

    def _on_connected(self, connected: bool) -> None:
        if connected:
            self._inbox.flag("connected")

    def _on_motion(self) -> None:
        """Called ten times a second for each robot; wakes the vehicle's thread only if the order may be
        affected."""
        facts, state = self.facts, self._order.state
        news = facts.lost or not facts.located or facts.moving != self._moving
        if state.drive is None:
            still = self._monitor.still_since(self._motion_ended_at) is not None
            news = news or still is not state.standing
        elif within_deviation(facts.position, state.drive.node, self.limits):
            news = news or goes_on_from(state, state.drive.node)
        if news or self._edge_speed.must_check(state.drive, facts.velocity):
            self._inbox.flag("motion")

    def _stands(self) -> bool:
        """Whether the robot was measured standing since its last motion ended, by what it sent after that. If
        this is not known and its velocities are zero, it is measured now."""
        since = None if self.facts.lost else self._monitor.still_since(self._motion_ended_at)
        if since is not None and since != self._standing.since:
            self._standing.begin(since)
            return False
        return since is not None

    def _on_path(self) -> None:
        """Publish the first path of each drive at once; later ones go with the next state."""
        drive = self._order.state.drive
        if drive is not None and drive.token != self._path_of_drive and self.facts.has_path_to(drive.node):
            self._path_of_drive = drive.token
            self._inbox.flag("path")

    # -- the vehicle's thread --------------------------------------------------------------------------------

    def _run(self) -> None:
        checked = self._calls.renewed()
        while (contents := self._inbox.wait()) is not None:
            # Whatever begins now counts from here: a stop after this moment prevents it, an earlier one holds
            # the order first. Stops of the vehicle itself do neither.
            now = self._calls.renewed()
            stopped, checked = checked.overtaken_at(now.stops), now
            try:
                with now:
                    self._handle(contents, stopped=stopped)
                    self._on_time(time.monotonic())
            except Exception:
                _log.exception("! %s: an internal error; the vehicle goes on", self.config.prefix)

    def _handle(self, contents: InboxContents, *, stopped: bool) -> None:
        flags, robot_events, message, call = contents
        if stopped:
            self._apply(events.StoppedByOthers())
        if "lease" in flags:
            self._lease.hand_over()
        if flags & {"status", "motion", "lease"} or message is not None:
            self._refresh(full=bool(flags & {"status", "lease"}) or not self.facts.located)
        for event in robot_events:
            self._robot_reports(event)
        if message is not None:
            with call:  # a stop of the chassis since its arrival prevents the drive that it begins
                self._apply(message)
            if call.overtaken:
                self._apply(events.StoppedByOthers())
        self._check_waiting_for_rest()
        if "dropped" in flags and "dropped" not in self._due:
            self._due["dropped"] = 0.0  # now
        if self._order.unsaved and not self._inbox.waiting_messages:
            self._write()
        if "connected" in flags or "parameters" in flags:
            self._publish_factsheet()
        if "connected" in flags:
            self._publish_state()
            # States are not retained: a manager that reconnects a little later needs one, too.
            self._due["state"] = time.monotonic() + _AGAIN_SECONDS
        if self.facts.moving != self._moving or "path" in flags:
            self._moving = self.facts.moving
            self._publish_state()

    def _robot_reports(self, event: Event) -> None:
        """Handle the end of a drive, a stop or an action."""
        if isinstance(event, events.ActionEnded):
            self._actions.forget(event.action_id)
            if self.facts.loads is not None:
                self.facts.loads = tuple(self._actions.loads)
            self._use_maps()
            self._monitor.refresh(self._lease.local_driver)  # a newly set pose is valid now
            self._apply(event)
            if not self._order.state.standing:
                self._motion_ended_at = time.monotonic()
            self._apply(events.PositionMeasured(self._position()))
            return
        self._motion_ended_at = time.monotonic()
        if isinstance(event, events.DriveEnded):
            self._apply(events.PositionMeasured(self._position()))
        self._apply(event)

    def _check_waiting_for_rest(self) -> None:
        """Report a cancel or pause that has waited too long for the robot to stand."""
        if self._order.state.waits_for_rest:
            self._due.setdefault("rest", time.monotonic() + _REST_SECONDS)
        elif self._due.pop("rest", None) is not None:
            self._apply(events.ProblemChanged("rest", None))

    def _report_dropped(self) -> None:
        """Report dropped messages as an error, until none was dropped for a while."""
        dropped = self._inbox.dropped
        if dropped == self._reported_dropped:
            del self._due["dropped"]
            self._apply(events.ProblemChanged("dropped", None))
            return
        counted = ", ".join(f"{lane.value}: {n}" for lane, n in dropped.items())
        text = f"messages came faster than they are read, and were dropped since the start: {counted}"
        _log.warning("! %s: %s", self.config.prefix, text)
        hint = "send less at a time, and wait for the state that answers"
        problem = Problem(ErrorType.DROPPED, text, level=Level.WARNING, hint=hint)
        self._due["dropped"], self._reported_dropped = time.monotonic() + _DROPPED_SECONDS, dropped.copy()
        self._apply(events.ProblemChanged("dropped", problem))

    def _position(self) -> AgvPosition | None:
        return self.facts.position if self.facts.located and not self.facts.lost else None

    def _check_motion(self) -> None:
        """Check standing and speed by the newest velocity."""
        now = time.monotonic()
        if not self._order.state.driving:
            standing = self._stands()
            if standing is not self._order.state.standing:
                self._apply(events.StandingMeasured(standing))
        text = self._edge_speed.check(self._order.state.drive, self.facts.velocity, now)
        if text is not None:
            self._apply(events.DriveTooFast(text))

    def _refresh(self, *, full: bool) -> None:
        if self.facts.lost and not self._monitor.silent:
            self.facts.lost, full = False, True
            self._motion_ended_at = time.monotonic()  # older measurements do not count
            self._apply(events.ContactChanged(True))
            self._apply(events.ProblemChanged("lost", None))
        if full:
            before = self.facts.alarms
            self._monitor.refresh(self._lease.local_driver)
            if self._monitor.heard:
                self._apply(events.ModeChanged(self._monitor.mode))
            if before != self.facts.alarms:
                self._publish_state()
        self._apply(events.PositionMeasured(self._position()))
        self._check_motion()
        if "connect" in self._due and self.facts.located and self.facts.percent is not None:
            self._due["connect"] = 0.0  # ONLINE means that orders are accepted
        if full:
            freed = self._was_blocked and not self._monitor.blocked
            self._was_blocked = self._monitor.blocked
            if freed:
                self._apply(events.RetryDue())

    def _on_time(self, now: float) -> None:
        for name in [name for name, due in self._due.items() if due <= now]:
            if name == "state":
                self._publish_state()
            elif name == "visualization":
                self._due[name] = now + self.config.visualization
                header = self._headers.header(name)
                self._connection.send(name, visualization_message(self.facts, header))
            elif name == "dropped":
                self._report_dropped()
            elif name == "rest":
                self._due[name] = now + _REST_SECONDS
                text = (
                    f"the robot was not measured standing for {_REST_SECONDS:g} s after it was told to stop"
                )
                hint = "look at the robot; its own stop button stops it"
                problem = Problem(ErrorType.STILL_MOVING, text, level=Level.WARNING, hint=hint)
                self._apply(events.ProblemChanged("rest", problem))
            elif name == "disk":
                del self._due[name]
                self._write()
            elif name == "retry":
                del self._due[name]
                self._apply(events.RetryDue())
            elif name == "lease":
                if not self._lease.renew(self._order.state.executing):
                    self._inbox.flag("status")
            elif name == "connect":
                del self._due[name]
                self._connection.open()
            elif name == "silent":
                self._due[name] = max(self._monitor.heard + SILENT_AFTER, now + 0.2)
                self._check_contact()

    def _check_contact(self) -> None:
        if self.facts.lost or not self._monitor.silent:
            return
        self.facts.may_move = self.facts.moving or not self._order.state.at_rest
        self.facts.lost, self.facts.velocity = True, None
        self._apply(events.ContactChanged(False))
        self._apply(events.ProblemChanged("lost", self._monitor.silence_problem()))
        self._apply(events.PositionMeasured(None))

    # -- effects ---------------------------------------------------------------------------------------------

    def _apply(self, event: Event) -> None:
        """Apply an event and carry out its effects. An order is saved before it is answered."""
        later = self._busy() and not isinstance(event, Order)
        self._carry_out(self._order.apply(event, later=later))

    def _write(self) -> None:
        """Save and publish what was put off, or try a failing disk again."""
        self._carry_out(self._order.write())

    def _carry_out(self, effects: Iterable[Effect]) -> None:
        for effect in effects:
            self._effect_handlers[type(effect)](effect)
        if self._order.failing:
            self._due.setdefault("disk", time.monotonic() + _DISK_SECONDS)

    def _publish_after_event(self) -> None:
        self._published_at = time.monotonic()
        self._lease.hold(self._order.state.executing)
        self._publish_state()

    def _drive(self, effect: events.Drive) -> None:
        self._edge_speed.drive_began(time.monotonic())
        self._driver.drive(effect)

    def _busy(self) -> bool:
        """Whether a state may be published later: a stop waits, or several messages wait."""
        if not self._inbox.waiting_messages:
            return False
        return self._inbox.stop_waits or time.monotonic() < self._published_at + _TOGETHER_SECONDS

    def _use_maps(self) -> None:
        if self._maps is not None:
            facts = self.facts
            facts.maps, facts.map_id = self._maps.entries, self._maps.active
            if facts.position is not None:
                facts.position = replace(facts.position, map_id=facts.map_id)
            self.limits = replace(self.limits, maps=self._maps.enabled_ids)
            self._apply(events.MapsChanged(self.limits.maps))

    def _write_report(self, reason: str) -> str:
        """Write a report for logReport; return its name, which the state's `information` has, too."""
        assert self._journal is not None
        facts = {
            "vehicle": self.config.prefix, "version": __version__, "chassis": self.chassis.master_uri,
            "readiness": str(self.chassis.readiness()), "facts": repr(self.facts),
            "order": self._order.state.to_json(),
        }  # fmt: skip
        name = self._journal.write(reason, facts)
        self.facts.information = (("logReport", name),)
        return name

    # -- publishing ------------------------------------------------------------------------------------------

    def _publish_state(self) -> None:
        self._due["state"] = time.monotonic() + STATE_EVERY
        self._connection.revive()
        if not self.connected:
            return
        state, header = self._order.state, self._headers.header("state")
        self._connection.send("state", self._states.text(state, self.facts, header))
        if self._journal is not None:
            actions = [f"{each.action.id} {each.status.value}" for each in state.action_states.all[-5:]]
            errors = [problem.kind for problem in state.problems]
            self._journal.note(f"> state {header['headerId']}: at {state.last_node}, {actions}, {errors}")

    def _publish_factsheet(self) -> None:
        header, parameters = self._headers.header("factsheet"), self._monitor.parameters
        message = factsheet_message(self.config, self.limits, header, parameters, self._outline)
        self._connection.send("factsheet", message, retain=True)

    def _learn_footprint(self) -> None:
        """Use the footprint of the navigation instead of the configured one."""
        found = navigation_footprint(self.chassis)
        if found:
            self._outline = found
            self._inbox.flag("parameters")
