"""The conditions under which a velocity block ends by itself; they are checked before each velocity is sent.

A drive that has ended is never resumed: a person may have stopped the robot.
"""

from __future__ import annotations

import threading
import time

import rosproto
from rosproto.errors import ConnectionLost, MasterError, RemoteProtocolError, RosError
from rosproto.logs import get_logger
from rosproto.node import NodeClient
from rosproto.sentence import say
from rosproto.transport import parse_uri
from woosh_pure.connection.other_drivers import is_refused
from woosh_pure.errors import MotionRefused
from woosh_pure.feed.feed import Feed
from woosh_pure.geometry import Velocity
from woosh_pure.interface.table import ROBOT_NODES
from woosh_pure.readiness.readiness_state import ReadinessState
from woosh_pure.stopping.stop_executor import Flag

# Linux: CLOCK_BOOTTIME. macOS and the BSDs: CLOCK_MONOTONIC, unlike what time.monotonic() takes there.
# Windows has neither; its time.monotonic() goes on in sleep.
_SOURCE: int | None = getattr(time, "CLOCK_BOOTTIME", getattr(time, "CLOCK_MONOTONIC", None))


def boot_seconds() -> float:
    """Seconds of a clock that is never set and includes the time while the computer sleeps.

    `time.monotonic()` stops on Linux and macOS while the computer sleeps, so a command from before would seem
    fresh afterwards. The wall clock includes that time, but users and NTP set it.
    """
    if _SOURCE is None or not hasattr(time, "clock_gettime"):
        return time.monotonic()
    now: float = time.clock_gettime(_SOURCE)
    return now


ANSWER_SECONDS = 1.0
"""Seconds without an answer after which velocities count as late."""
_PERIOD = 0.25
logger = get_logger("woosh_pure.velocity")


class Heartbeat:
    """Checks whether velocities still reach the robot in time, by asking the subscribing node periodically.

    Used by a drive without measured velocities. An open link does not show a loss for many seconds: TCP keeps
    data that the network does not deliver, and delivers it later. The request is `getPid` of
    wiki.ros.org/ROS/Slave_API, which every node answers at once. A thread sends it until `over` is set.

    Args:
        node: Our node.
        publisher: The publisher of the velocity topic, with a subscriber.
        over: Ends the requests.
    """

    def __init__(self, node: rosproto.Node, publisher: rosproto.Publisher, over: Flag) -> None:
        self._node = node
        self._publisher = publisher
        self._over = over
        self._answered: float | None = None

    def start(self) -> None:
        """Send the first request, for at most two seconds, and continue in the background.

        If the node cannot be reached (a firewall), this is logged, the drive is allowed, and `late` stays
        False.
        """
        try:
            # One of the robot's own nodes, if there is one: false sorts before true.
            listener = min(self._publisher.subscribers, key=lambda name: name not in ROBOT_NODES)
            uri = self._node.master.lookup_node(listener, timeout=ANSWER_SECONDS)
            client = NodeClient(uri, self._node.name, hosts=self._node.hosts)
            self._ask(client)
        except (RosError, ValueError) as error:
            logger.warning(
                "! %s: who listens cannot be asked (%s): nothing ends this drive when the network delivers "
                "late; watch the robot",
                self._publisher.topic,
                error,
            )
            return
        threading.Thread(target=self._run, args=(client,), name="woosh:heartbeat", daemon=True).start()

    @property
    def late(self) -> bool:
        """Whether the last answered request was sent too long ago."""
        return self._answered is not None and boot_seconds() - self._answered > ANSWER_SECONDS

    def _run(self, client: NodeClient) -> None:
        with client:  # connected already: later, no file may be left for a connection
            while not self._over.wait(_PERIOD):
                try:
                    self._ask(client)
                except RosError:
                    continue

    def _ask(self, client: NodeClient) -> None:
        """Send one request. The time of sending counts, so a late answer does not help."""
        asked = boot_seconds()
        try:
            client.get_pid(timeout=ANSWER_SECONDS)
        except (MasterError, RemoteProtocolError):
            pass  # an unexpected answer also counts
        except ConnectionLost as error:
            if not is_refused(error) or self._node.hosts.is_guess(parse_uri(client.uri)[0]):
                raise  # refused: the robot's computer has answered; the link shows that the node is gone
        self._answered = asked


PAUSE_SECONDS = 1.0
"""Seconds without running after which the sending thread ends the drive."""
DISOBEYED_SECONDS = 3.0
"""Seconds for which the robot may stand still although a velocity is sent."""
_TOLD_LINEAR, _TOLD_ANGULAR = 0.05, 0.1  # m/s, rad/s: commands below these may be measured as zero


class EndConditions:
    """The end conditions of one drive. Only its sending thread calls `problem`.

    Args:
        readiness_state: The known reasons against moving.
        measured: The feed of `/odom_twist`.
        publisher: The publisher of the velocity topic.
        feedback_timeout: Seconds for which `/odom_twist` may be silent; None drives without it.
        heartbeat: Shows that the network still delivers, if `/odom_twist` is not used; else None.
        check: False ignores the known state of the robot.
    """

    def __init__(
        self,
        readiness_state: ReadinessState,
        measured: Feed[Velocity],
        publisher: rosproto.Publisher,
        feedback_timeout: float | None,
        heartbeat: Heartbeat | None = None,
        *,
        check: bool,
    ) -> None:
        self._readiness_state = readiness_state
        self._publisher = publisher
        self._feedback_timeout = feedback_timeout
        self._heartbeat = heartbeat
        self._check = check
        self._measured = measured
        self._last = self._obeyed = boot_seconds()

    def problem(self, sent: Velocity) -> RosError | None:
        """Return why the drive must end now; None if it need not.

        Args:
            sent: The velocity that was sent last.
        """
        return self._paused() or (self._blocked() if self._check else None) or self._lost(sent)

    def awaits_code(self, problem: RosError) -> bool:
        """Whether the code that says which fault ended the drive may still be on its way."""
        return isinstance(problem, MotionRefused) and self._readiness_state.awaits_code(problem.readiness)

    def with_code(self, problem: RosError) -> RosError:
        """The same problem with the reasons that are known by now."""
        return self._blocked() or problem

    def _paused(self) -> RosError | None:
        """The process was suspended (SIGSTOP, a debugger, a closed laptop) while the robot was driving."""
        now = boot_seconds()
        pause, self._last = now - self._last, now
        if pause <= PAUSE_SECONDS:
            return None
        return MotionRefused(
            say(
                "the drive is over: this program did not run for {seconds:.1f} s; without a watchdog the "
                "robot went on with the last velocity; driving does not resume by itself, look where it is "
                "and open a new drive",
                seconds=pause,
            )
        )

    def _blocked(self) -> RosError | None:
        """An emergency stop and the like: releasing the button must not resume the drive."""
        readiness = self._readiness_state.known_readiness()
        if not readiness.refuses:
            return None
        return MotionRefused(
            "the drive is over and does not resume by itself; open a new one when the robot is ready",
            readiness=readiness,
        )

    def _lost(self, sent: Velocity) -> RosError | None:
        if self._publisher.connections == 0:
            return _connection_lost(say("{topic} no longer has a subscriber", topic=self._publisher.topic))
        if self._heartbeat is not None and self._heartbeat.late:
            return _connection_lost(
                say(
                    "the subscriber of {topic} has not answered within {seconds:g} s, so messages would "
                    "arrive late",
                    topic=self._publisher.topic,
                    seconds=ANSWER_SECONDS,
                )
            )
        if self._feedback_timeout is None:
            return None
        measured = self._measured.known
        if measured is None or measured.age > self._feedback_timeout:
            return _connection_lost(
                say(
                    "{topic} has been silent for more than {seconds} s",
                    topic=self._measured.topic,
                    seconds=self._feedback_timeout,
                )
            )
        return self._disobeyed(sent, measured.value) if self._check else None

    def _disobeyed(self, sent: Velocity, measured: Velocity) -> RosError | None:
        """The robot stands still although a velocity is sent.

        The chassis does not report an emergency stop that was pressed before we connected; without this, the
        robot would start as soon as the button is released.
        """
        now = boot_seconds()
        if sent.is_standing(_TOLD_LINEAR, _TOLD_ANGULAR) or not measured.is_standing():
            self._obeyed = now
            if not measured.is_standing(_TOLD_LINEAR, _TOLD_ANGULAR):
                self._readiness_state.refusals.end()
        if now - self._obeyed <= DISOBEYED_SECONDS:
            return None
        self._readiness_state.refusals.note(
            "the last drive was not obeyed: the robot stood still", time.monotonic()
        )
        return MotionRefused(
            say(
                "the drive is over: the robot has stood still for {seconds:g} s although it was told to move;"
                " is its emergency stop pressed, its brake on, or something in its way? Driving does not "
                "resume by itself",
                seconds=DISOBEYED_SECONDS,
            )
        )


def _connection_lost(why: str) -> ConnectionLost:
    return ConnectionLost(
        say("the drive is over: {why}; driving does not resume by itself, check the network", why=why)
    )
