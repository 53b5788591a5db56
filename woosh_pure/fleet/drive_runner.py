"""`DriveRunner`: carries out the drives of the order machine as goals of the chassis, each in a thread.

A new drive replaces the current one, so that a vehicle passes a node without a stop. A halt cancels it. The
end of each drive is reported exactly once: either the chassis has ended the goal (which does not mean that
the robot stands), or this is not known.

    the chassis's outcome, or our error                          report
    ------------------------------------------------------------------------------
    arrived, failed, rejected, cancelled, replaced               ended (`by_others` if not by this program)
    refused before anything was sent                             ended
    connection lost, timed out, cancel not sent or not confirmed not known
    any other error once sending has begun                       not known
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable

from rosproto.errors import RosError
from rosproto.logs import get_logger
from woosh_pure.chassis import Chassis
from woosh_pure.connection.call_scope import CallScope
from woosh_pure.enums import NavDirection, NavigationMode
from woosh_pure.errors import FirmwareLimit, MotionRefused
from woosh_pure.fleet.action_handlers.running_action import ended_by_others
from woosh_pure.fleet.messages.elements import Edge, Node
from woosh_pure.fleet.order.events import Drive, DriveEnded, StopEnded
from woosh_pure.fleet.order.vehicle_limits import AgvPosition
from woosh_pure.motion.action_goal import NavigationHandle
from woosh_pure.motion.task import TaskHandle
from woosh_pure.outcome import end_is_known

_log = get_logger("woosh_pure.fleet.drive_runner")
_MODE_SECONDS = 5.0
_STOP_SECONDS = 4.0


class _NotSent(RosError):
    """The drive was not sent, because speed or direction of its edge could not be set."""


class DriveRunner:
    """Drives one chassis.

    Args:
        chassis: The chassis.
        report: Called with a `DriveEnded` for each drive and a `StopEnded` for each `stop_all`, in their
            threads.
        position: Returns the current position of the vehicle.
        marks: Whether a node without a position is a mark.
    """

    def __init__(
        self,
        chassis: Chassis,
        report: Callable[[DriveEnded | StopEnded], object],
        position: Callable[[], AgvPosition | None],
        *,
        marks: bool = False,
    ) -> None:
        self._chassis, self._report_end = chassis, report
        self._position, self._marks = position, marks
        self._lock = threading.Lock()
        self._sending = threading.Lock()  # held while a goal is sent, so that no older one follows
        self._newest = 0
        self._halted = 0
        self._handle: tuple[int, TaskHandle | NavigationHandle] | None = None
        self._open: set[int] = set()  # tokens of drives whose end is not reported yet
        self._limited = False  # a speed or direction is set
        self._without_modes = False  # the chassis accepts no speed and direction
        self._closed = False
        self._closing = threading.Event()

    def drive(self, effect: Drive) -> None:
        """Start a drive; returns at once."""
        with self._lock:
            self._newest = effect.token
            self._open.add(effect.token)
        request = self._chassis.request()
        self._begin(lambda: self._work(effect, request), f"woosh:drive-{effect.node.id}")

    def halt(self, token: int) -> None:
        """Cancel the drive; returns at once. Its end is reported."""
        with self._lock:
            self._halted = token
            handle = self._handle
        if handle is not None and handle[0] == token:
            self._begin(lambda: self._cancel(*handle), "woosh:halt")

    def stop_all(self, after: float) -> None:
        """Stop all motion of the chassis after `after` seconds; returns at once. Its end is reported."""
        request = self._chassis.request()
        self._begin(lambda: self._stop_all(after, request), "woosh:stop-all")

    def close(self) -> None:
        """Cancel the current drive, and start no others."""
        with self._lock:
            self._closed = True
            handle = self._handle
        self._closing.set()
        if handle is not None:
            self._cancel(*handle)

    @staticmethod
    def _begin(work: Callable[[], None], name: str) -> None:
        threading.Thread(target=work, name=name, daemon=True).start()

    def _cancel(self, token: int, handle: TaskHandle | NavigationHandle) -> None:
        try:
            handle.cancel()
        except RosError as error:
            _log.warning("! a drive was not cancelled: %s; the robot may still be driving", error)
            self._report(token, False, f"it was not cancelled: {error}", known=False)

    def _stop_all(self, after: float, request: CallScope) -> None:
        if self._closing.wait(after):
            return
        standing = False
        try:
            with request:
                report = self._chassis.stop(everything=True, timeout=_STOP_SECONDS)
            standing = bool(report.standing)
            _log.warning("! how something that moves the robot ended is not known: %s", str(report))
        except RosError as error:
            _log.warning("! the robot was not stopped: %s", error)
        self._report_end(StopEnded(standing))

    def _is_obsolete(self, token: int) -> bool:
        return self._closed or token != self._newest or token == self._halted

    def _report(self, token: int, arrived: bool, text: str, *, known: bool, by_others: bool = False) -> None:
        with self._lock:
            if token in self._open:
                self._open.discard(token)
            else:
                return  # already reported
        self._report_end(DriveEnded(token, arrived, text, known, by_others))

    def _work(self, effect: Drive, request: CallScope) -> None:
        token = effect.token
        try:
            with self._sending:
                with self._lock:
                    obsolete, before = self._is_obsolete(token), self._handle
                try:
                    with request:
                        handle = None if obsolete else self._send(effect)
                except Exception:
                    if before is not None:  # it was to be replaced; now it must be cancelled
                        self._cancel(*before)
                    raise
                with self._lock:
                    self._handle = None if handle is None else (token, handle)
                    late = handle is not None and (self._closed or token == self._halted)
            if handle is None:
                self._report(token, False, "it was not begun", known=True)
                return
            if late:
                self._cancel(token, handle)
            outcome = handle.wait(None, raises=False)
            text = outcome.text or str(outcome.kind)
            known, by_others = end_is_known(outcome), ended_by_others(outcome)
            self._report(token, outcome.arrived, text, known=known, by_others=by_others)
        except (_NotSent, MotionRefused, FirmwareLimit, ValueError) as error:
            self._report(token, False, str(error), known=True)
        except RosError as error:
            self._report(token, False, str(error), known=False)
        except Exception as error:
            _log.exception("! a drive failed")
            self._report(token, False, f"{type(error).__name__}: {error}", known=False)

    def _send(self, effect: Drive) -> TaskHandle | NavigationHandle:
        node, edge = effect.node, effect.edge
        self._set_speed_and_direction(edge)
        if node.position is None:
            return self._chassis.go_to_mark(node.description or node.id, timeout=None, replace=True)
        yaw = node.position.theta
        if yaw is None:
            yaw = self._heading(node)
        return self._chassis.go_to(node.position.x, node.position.y, yaw, timeout=None, replace=True)

    def _heading(self, node: Node) -> float:
        """The heading for a node without one: the direction of travel."""
        place, position = self._position(), node.position
        assert position is not None
        if place is None:
            return 0.0
        dx, dy = position.x - place.x, position.y - place.y
        return math.atan2(dy, dx) if math.hypot(dx, dy) > 0.1 else place.theta

    def _set_speed_and_direction(self, edge: Edge | None) -> None:
        """Set speed and direction for an edge. This is done before each drive, because the chassis loses them
        in a restart, other programs may change them, and values from before a restart of this program remain
        set."""
        options = {} if edge is None else edge.options
        speed = float(options.get("maxSpeed", 0.0))
        direction = NavDirection.CHASSIS_DECIDES
        if "orientation" in options:
            backwards = abs(options["orientation"]) > 1.0
            direction = NavDirection.BACKWARD if backwards else NavDirection.FORWARD
        limited = speed > 0.0 or direction is not NavDirection.CHASSIS_DECIDES
        if self._without_modes and not limited:
            return
        try:
            self._chassis.set_navigation_mode(
                NavigationMode.PRECISE_AVOIDANCE, max_speed=speed, direction=direction, timeout=_MODE_SECONDS
            )
        except RosError as error:
            if limited or self._limited:
                raise _NotSent(f"speed and direction were not set, so it was not begun: {error}") from error
            self._without_modes = True
            _log.warning(
                "! the chassis takes no speed and direction (%s); it drives as it is configured", error
            )
            return
        self._limited, self._without_modes = limited, False


# -- the lease of the chassis --------------------------------------------------------------------------------

_LEASE_SECONDS = 60.0
_RENEW_SECONDS = _LEASE_SECONDS / 3.0


class DrivingLease:
    """The fleet manager's lease of one chassis: held during an order, and given to a local driver who asks.

    Args:
        chassis: The chassis.
        serial: The vehicle's serial number, part of the owner's name.
        due: Due times; "lease" is the time of the next `renew`.
    """

    def __init__(self, chassis: Chassis, serial: str, due: dict[str, float]) -> None:
        self._chassis, self._lease, self._owner = chassis, chassis.lease, f"fleet manager of {serial}"
        self._due = due

    def on_change(self, call: Callable[[], object]) -> Callable[[], None]:
        """Call back when the holder changes or somebody asks for it; return a function that ends this."""
        return self._lease.on(lambda state: call())

    @property
    def local_driver(self) -> str:
        """The local driver who holds the lease, which a mission of this order is not; "" if none does."""
        holder = self._lease.holder
        if holder in (None, self._owner):
            return ""
        missions = self._chassis.missions
        run = missions.state.run if holder == missions.owner else None
        return "" if run is not None and run.entry.by == self._owner else str(holder)

    def hand_over(self) -> None:
        """Grant the lease to a local driver who asks; the mode becomes MANUAL, and the order is cleared."""
        asking = self._lease.state.asking
        if self._lease.holder == self._owner and asking:
            self._lease.grant(self._owner, asking[0])

    def hold(self, executing: bool) -> None:
        """Take the lease during an order, and release it afterwards."""
        if not executing:
            self.release()
        elif "lease" not in self._due:
            self._due["lease"] = 0.0

    def renew(self, executing: bool) -> bool:
        """Renew the lease; False while a local driver holds it."""
        if not executing:
            del self._due["lease"]
            return True
        self._due["lease"] = time.monotonic() + _RENEW_SECONDS
        return bool(self._lease.acquire(self._owner, _LEASE_SECONDS))

    def release(self) -> None:
        """Release the lease."""
        self._due.pop("lease", None)
        if self._lease.holder == self._owner:
            self._lease.release(self._owner)
