"""Creates the parts of one `Chassis` and connects them; verbs and motions use them."""

from __future__ import annotations

import threading
from functools import partial
from typing import TYPE_CHECKING

from rosproto.logs import get_logger
from rosproto.sentence import say
from rosproto.watchdog import Watchdog
from woosh_pure.connection.clients import Clients
from woosh_pure.connection.connection import Connection, say_elsewhere
from woosh_pure.connection.velocity_topics import VelocityTopics
from woosh_pure.feed.feed import Feeds
from woosh_pure.readiness.readiness_state import ReadinessState
from woosh_pure.stopping.active_motions import ActiveMotions
from woosh_pure.stopping.stop_executor import Job
from woosh_pure.stopping.watchdog_client import WatchdogClient

if TYPE_CHECKING:
    from woosh_pure.robot_api.background import Background
    from woosh_pure.robot_api.values import DeviceFacts

logger = get_logger("woosh_pure.components")

_ELSEWHERE = 15.0  # seconds for the last words of another node


class Components:
    """The parts of one `Chassis`.

    Attributes:
        connection: Our node, made on first use.
        clients: Publishers, service clients and action clients.
        feeds: The topics that are read.
        readiness_state: The known reasons against moving.
        motions: Our goals and velocity blocks under way.
        velocity: The velocity topics.
        watchdog_client: Registers motions at the watchdog process.
        in_block: Whether the Chassis is in its own `with` block, which will close it.
    """

    def __init__(
        self,
        connection: Connection,
        *,
        leave_running: bool = False,
        watchdog: bool | Watchdog = False,
        robot_facts: Background[DeviceFacts] | None = None,
    ) -> None:
        self.connection = connection
        connection.before_close = self._before_close
        self.in_block = False
        self.clients = Clients(self.connection)
        self.feeds = Feeds(self.connection)
        self._own_watchdog = watchdog is True
        self._watchdog = Watchdog() if watchdog is True else watchdog or None
        self.watchdog_client = WatchdogClient(self.connection, self._watchdog, leave=leave_running)
        self.velocity = VelocityTopics(self.connection, self._heard_since, unused=self.watchdog_client.over)
        if self._watchdog is not None:
            self._watchdog.on_sent(self._stopped_by_watchdog)
        self.motions = ActiveMotions(self.velocity, leave=leave_running)
        self.readiness_state = ReadinessState(
            self.connection,
            self.feeds,
            own_tasks=self.motions.own_tasks,
            require_not_over=self.motions.require_not_over,
            robot_facts=robot_facts,
        )

    def start_watchdog(self) -> None:
        """Start the watchdog, to be ready for the first motion; returns at once."""
        if self._watchdog is not None:
            self._watchdog.start()

    def _stopped_by_watchdog(self, why: str) -> None:
        """End the motions that the watchdog has stopped, in a thread: its own must keep receiving."""
        threading.Thread(target=partial(self.motions.end_all, why), name="woosh:stop", daemon=True).start()

    def _before_close(self, reason: str) -> None:
        words = self.velocity.final_messages
        goals = [] if self.motions.leave else self.motions.goals
        words += [goal.final_message for goal in goals if goal.final_message is not None]
        own_over = threading.Event()
        elsewhere = Job(partial(say_elsewhere, self.connection, words, own_over), _ELSEWHERE)
        self.motions.end_with_node(reason, elsewhere if reason and words else None)
        own_over.set()
        if reason and words:
            elsewhere.join()
            for problem in elsewhere.result() if elsewhere.over else [say("no answer yet")]:
                logger.warning("! %s: the robot may still be driving: %s", reason, problem)

    def _heard_since(self, moment: float) -> bool:
        feed = self.feeds.used("velocity")
        newest = None if feed is None else feed.known
        return newest is not None and newest.received > moment

    def close(self) -> None:
        """Close feeds and node; goals and drives must have ended before.

        May be called again, to finish a close that Ctrl-C interrupted.
        """
        self.connection.note_close()
        self.motions.close()
        self.feeds.close()
        self.connection.close()
        if self._own_watchdog and self._watchdog is not None:
            self._watchdog.close()
