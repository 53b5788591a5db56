"""`Publishing`: what a robot tells by its Robot API, as messages on the topics of the graph.

A velocity is published once for each PoseSpeed that came, and never repeated: "it stands" must be as new as
it seems. What is sent on change only by both sides is repeated every second, because here the link is known
to be good.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping

from rosproto.errors import RosError
from rosproto.logs import get_logger
from rosproto.node import Publisher
from woosh_pure.geometry import Pose2D
from woosh_pure.robot_api.translate import COUNT, PAIRS, ROBOT, SECTIONS, pose_2d, to_ros
from woosh_pure.robot_api.wire import Values, enum, load
from woosh_pure.served_graph.stamped import fill_transforms, stamp
from woosh_pure.values.messages import message_type, set_pose

POSE, DEVICE, SCANNER = (ROBOT + name for name in ("PoseSpeed", "DeviceState", "ScannerData"))
TASK, STATE, MODE = (ROBOT + name for name in ("TaskProc", "RobotState", "Mode"))
STATUS, CODES, SCAN = "/robot_status", "/status_code", "/scan"
ROWS = {pair.row for pair in PAIRS} | {"/amcl_pose", "/tf"}
TELLING = {pair.type_name for pair in PAIRS} - {SCANNER} | {DEVICE, COUNT + "AbnormalCodes"}
"""The types that are published."""
_REPEATED = ("/battery", "/information")
MAX_FAULTS = 100  # that are repeated
_PRESSED, _RELEASED, _STOP_CODES = 110201000013, 110201000000, 110_201  # the first six digits
_BUTTON = enum(ROBOT + "DeviceState.HardwareBit")["kEmgBtn"]
_LOCALISED = enum(ROBOT + "DeviceState.SoftwareBit")["kLocation"]
_log = get_logger("woosh_pure.api_bridge")


class Publishing:
    """Publishes what is known by the publisher of each row, and keeps it.

    Attributes:
        values: The newest values by type, since the link was made.
    """

    def __init__(self, publisher: Callable[[str], Publisher | None]) -> None:
        self._publisher = publisher
        self.values: dict[str, Values] = {}
        self._lock = threading.RLock()
        self._status: object = None
        self._pressed = self._status_due = False
        self._warned: set[str] = set()

    def lost(self) -> None:
        """The link is lost: nothing is known any more."""
        with self._lock:
            self.values.clear()

    def tell_status(self, *, again: bool = False) -> None:
        """Publish the state if it has changed, or again."""
        with self._lock:
            if again:
                self._status = None
            if again or self._status_due:
                self._status_due = False
                self._publish(STATUS)

    def take_all(self, info: Values) -> None:
        """Take the sections of RobotInfo; without a task it has none of it."""
        self.take(STATE, {"state": info["state"]})
        self.take(TASK, load(TASK, None))
        for key, type_name in SECTIONS.items():
            if key in info and type_name in TELLING:
                self.take(type_name, info[key])

    def take(self, type_name: str, values: Values) -> None:
        """Publish values that have come."""
        with self._lock:
            self.values[type_name] = values
            if type_name in (STATE, MODE):
                self._status_due = True  # the TaskProc of the same moment comes next, or has come
                return
            for pair in PAIRS:
                if pair.type_name == type_name:
                    self._publish(pair.row)
            if type_name == POSE:
                self._place()
            elif type_name == DEVICE:
                self._tell_button()

    def repeat(self) -> None:
        """Publish again what would be published on change only: battery, versions, faults."""
        with self._lock:
            for row in _REPEATED:
                self._publish(row)
            faults = self.values.get(COUNT + "AbnormalCodes", {}).get("scs", ())
            known = {one["code"] for one in faults[:MAX_FAULTS]}
            if self._pressed and not any(code // 10**6 == _STOP_CODES for code in known):
                known.add(_PRESSED)
            for code in sorted(known):
                self._send(CODES, {"data": code})

    def _publish(self, row: str) -> None:
        try:
            message = to_ros(row, self.values)
            if row == STATUS:
                if message is None or message == self._status:
                    return
                self._status = message
            if message is not None:
                if row == SCAN:
                    stamp(message, "laser", time.time())
                self._send(row, message)
        except (RosError, ValueError) as error:
            if row not in self._warned:
                self._warned.add(row)
                _log.warning("! %s is not published: %s", row, error)

    def _send(self, row: str, message: object) -> None:
        publisher = self._publisher(row)
        if publisher is not None and not publisher.closed:
            publisher.publish(**message) if isinstance(message, Mapping) else publisher.publish(message)

    def _tell_button(self) -> None:
        pressed = bool(self.values[DEVICE]["hardware"] & _BUTTON)
        if pressed != self._pressed:
            self._pressed = pressed
            self._send(CODES, {"data": _PRESSED if pressed else _RELEASED})

    def _place(self) -> None:
        found, now = self.values[POSE].get("pose"), time.time()
        if found is None:
            return
        pose = pose_2d(found)
        links = [("map", "base_link", pose)]
        if (scan := self.values.get(SCANNER)) is not None:
            offset = scan.get("offset", {"x": 0.0, "y": 0.0})
            links.append(("base_link", "laser", Pose2D(offset["x"], offset["y"])))
        transforms = message_type("tf2_msgs/TFMessage")()
        fill_transforms(transforms, now, *links)
        self._send("/tf", transforms)
        if self.values.get(DEVICE, {"software": 0})["software"] & _LOCALISED:
            estimate = message_type("geometry_msgs/PoseWithCovarianceStamped")()
            stamp(estimate, "map", now)
            set_pose(estimate.pose.pose, pose)
            estimate.pose.covariance = [-1.0] + [0.0] * 35  # not known
            self._send("/amcl_pose", estimate)

    @property
    def stands(self) -> bool:
        """Whether the newest PoseSpeed says so, of a robot without a task."""
        twist = self.values.get(POSE, {}).get("twist", {})
        return POSE in self.values and not any(twist.values())
