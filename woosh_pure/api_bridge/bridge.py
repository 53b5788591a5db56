"""`ApiBridge`: the ROS 1 graph of a robot that has only the Robot API, on a master in this process."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial

import rosproto
from rosproto.errors import RosError
from rosproto.logs import get_logger
from rosproto.sentence import say
from rosproto.transport import HostNames
from woosh_pure import interface
from woosh_pure.api_bridge import publishing
from woosh_pure.api_bridge.client import GONE_SECONDS, LATE_SECONDS, Answer, ApiLink
from woosh_pure.api_bridge.handlers import ApiHandlers
from woosh_pure.api_bridge.publishing import POSE, SCAN, SCANNER, STATUS, TASK, Publishing
from woosh_pure.robot_api import wire
from woosh_pure.robot_api.commands import FEEDBACKS
from woosh_pure.robot_api.http import ApiAddress, ApiRequests
from woosh_pure.robot_api.translate import ROBOT
from woosh_pure.robot_api.wire import Values
from woosh_pure.served_graph.graph import ServedGraph

NODE = "/ros_interface"
"""Has all that the bridge serves: one of the robot's own nodes for everybody who looks at the graph."""
_TICK, _ASK_EVERY, _REPEAT_EVERY = 0.05, 0.2, 1.0
_RENEWED = (STATUS, publishing.CODES)
"""Published by a new publisher after a lost link: who listens sees that something may have been missed."""
_log = get_logger("woosh_pure.api_bridge")


class ApiBridge:
    """Serves the rows of the interface that the Robot API can express. Use it in a `with` block.

    PoseSpeed is asked five times a second, because a robot at rest does not push it: the answers are the
    measured velocity, and show that the link is good. When one is late, drives end (nobody subscribes to the
    velocity topics any more) and nothing is published until the robot was asked anew.

    Args:
        address: Where the Robot API is.
        hosts: Resolves names that the system does not know.
        on_refused: Called with a sentence when the robot refuses a velocity.
    """

    def __init__(
        self,
        address: ApiAddress,
        *,
        hosts: HostNames | None = None,
        on_refused: Callable[[str], object] = lambda why: None,
    ) -> None:
        self._on_refused = on_refused
        topics = wire.topics() & {*publishing.TELLING, FEEDBACKS}
        self._link = ApiLink(address, topics, self._received, self._refused, hosts)
        self._known = Publishing(self._publisher)
        self._requests = ApiRequests(address, hosts)
        self._closed = threading.Event()
        self._handlers = ApiHandlers(self._link, self._requests, self._known, self._closed)
        self._graph = ServedGraph(self._handlers, self._new_node)
        self._master: rosproto.Master | None = None
        self._informed = 0  # number of the link about which everything was asked
        self._asked = 0
        self._good = True
        self._scanning = False
        self._thread = threading.Thread(target=self._run, name="woosh:robot api bridge", daemon=True)

    def start(self, timeout: float = 5.0) -> ApiBridge:
        """Connect to the robot and serve it; return this object.

        Raises:
            RosError: The robot cannot be reached, or does not answer as a Robot API.
        """
        self._link.start()
        try:
            number, info = self._link.number, self._link.ask(ROBOT + "RobotInfo", timeout=timeout)
            self._master = rosproto.Master("127.0.0.1")
            self._build()
        except BaseException:
            self.close()
            raise
        self._asked = number
        self._take_info(number, info)
        self._thread.start()
        return self

    def _new_node(self, name: str) -> rosproto.Node:
        return rosproto.Node(
            name, master_uri=self.master_uri, host="127.0.0.1", rosout=False, allow_shutdown=False
        )

    def _build(self) -> None:
        served = {*publishing.ROWS, *self._handlers.topics, *self._handlers.services, *self._handlers.actions}
        self._rows = {
            row.name: replace(row, providers=(NODE,), latched=row.name == STATUS)
            for row in interface.ROWS
            if row.name in served
        }
        self._velocities = [row for row in self._rows.values() if row.bypasses_protection]
        self._graph.build(self._rows.values())
        for name in self._handlers.actions:
            cancel = partial(self._handlers.cancel, name)
            self._graph.node(NODE).subscriber(f"{name}/cancel", "actionlib_msgs/GoalID", callback=cancel)

    def _publisher(self, topic: str) -> rosproto.Publisher | None:
        return self._graph.publishers.get((NODE, topic))

    @property
    def master_uri(self) -> str:
        """The URI of its master."""
        if self._master is None:
            raise RuntimeError("the bridge is not started; use `with ApiBridge(...) as bridge:`")
        return self._master.uri

    def close(self) -> None:
        """Send a zero that is due, and close everything. Bounded; may be called again."""
        self._closed.set()
        if self._thread.is_alive():
            self._thread.join(2.0)
        self._link.close()
        self._requests.close()
        self._graph.close()
        if self._master is not None:
            self._master.close()

    def __enter__(self) -> ApiBridge:
        return self.start()

    def __exit__(self, *exc_info: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<ApiBridge to {self._link.uri}, {'connected' if self._link.up else 'not connected'}>"

    # -- from the robot, in the link's thread ----------------------------------------------------------------

    def _received(self, type_name: str, values: Values) -> None:
        if self._informed != self._link.number:
            return  # the answer to RobotInfo is as new, and complete
        if type_name == FEEDBACKS:
            self._handlers.feedbacks(values)
        else:
            self._known.take(type_name, values)
        if type_name == TASK:
            self._handlers.task_seen()

    def _answered(self, answer: Answer) -> None:
        """The answer to PoseSpeed."""
        if isinstance(answer, dict) and self._informed == self._link.number:
            self._known.take(POSE, answer)

    def _take_info(self, number: int, info: Values) -> None:
        self._known.take_all(info)
        self._known.tell_status()
        self._informed = number
        self._handlers.task_seen()

    def _refused(self, why: str) -> None:
        text = say("the robot refused the velocity: {why}", why=say(why))
        _log.error("! %s", text)
        self._on_refused(text)

    # -- the link --------------------------------------------------------------------------------------------

    def _run(self) -> None:
        ask_at = repeat_at = 0.0
        while not self._closed.wait(_TICK):
            now, link = time.monotonic(), self._link
            if link.up and link.silence > GONE_SECONDS:
                link.cut()
            good = link.up and link.silence <= LATE_SECONDS
            try:
                if self._good and not (good and self._informed == link.number):
                    self._lose()
                if good and not self._good and self._informed == link.number and not link.zero_due:
                    self._regain()
                if link.up and now >= ask_at:
                    ask_at = now + _ASK_EVERY
                    link.post(POSE, done=self._answered, prompt=True)
                    if good and self._asked != link.number:
                        self._asked = link.number
                        link.post(ROBOT + "RobotInfo", done=partial(self._informed_by, link.number))
                if self._good and now >= repeat_at:
                    repeat_at = now + _REPEAT_EVERY
                    self._known.repeat()
                self._known.tell_status()
                self._follow_scan()
            except RosError as error:
                _log.debug("! %s", error)

    def _lose(self) -> None:
        """End what relies on the link. Nothing resumes: a drive is over when nobody listens."""
        self._link.end_drive()
        for row in self._velocities:
            self._graph.subscribers[NODE, row.name].close()
        self._good, self._asked, self._informed = False, 0, 0
        _log.warning("! %s: the link is late or lost; velocities are not obeyed", self._link.uri)
        self._known.lost()
        for name in _RENEWED:
            self._graph.publishers[NODE, name].close()

    def _regain(self) -> None:
        for name in _RENEWED:
            self._graph.publish(self._rows[name])
        self._known.tell_status(again=True)
        for row in self._velocities:
            self._graph.listen(row)
        self._good = True
        _log.warning("= %s: the link is good again", self._link.uri)

    def _informed_by(self, number: int, answer: Answer) -> None:
        if isinstance(answer, dict):
            self._take_info(number, answer)
        else:
            _log.debug("! %s: %s", self._link.uri, answer)
            self._asked = 0

    def _follow_scan(self) -> None:
        """Subscribe to scans while somebody listens."""
        publisher = self._publisher(SCAN)
        wanted = publisher is not None and publisher.connections > 0 and self._good
        if wanted != self._scanning:
            self._scanning = wanted
            self._link.subscribe(SCANNER, wanted)
