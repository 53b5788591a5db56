"""The simulated chassis as an older firmware: on the wire it has that firmware's definitions.

Handlers and fillers know the current definitions only. On the way out and in, messages are carried over by
field name, as the real robot's program was written for its own.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from woosh_pure.firmware.revisions import Firmware
from woosh_pure.values.rostypes import message_type

__all__ = ["RevisedGoal", "revised_action", "revised_listener", "revised_service"]


def revised_listener(firmware: Firmware, type_name: str, callback: Callable[[Any], object]) -> Any:
    """A callback for messages in the firmware's definition."""
    ours = message_type(type_name)
    if firmware.message_class(type_name)._md5sum == ours._md5sum:
        return callback
    return lambda message: callback(firmware.convert(message, ours))


def revised_service(
    firmware: Firmware, type_name: str, handler: Callable[[Any], Any]
) -> Callable[[Any], Any]:
    """A handler for requests in the firmware's definition; the inner one returns a dict of current fields."""
    theirs = firmware.service_class(type_name)
    request, response = message_type(f"{type_name}Request"), message_type(f"{type_name}Response")

    def handle(message: Any) -> Any:
        answer = handler(firmware.convert(message, request))
        return firmware.convert(response(**answer), theirs._response_class)

    return handle


def revised_action(firmware: Firmware, type_name: str, handler: Callable[[Any], Any]) -> Callable[[Any], Any]:
    """A handler for goals in the firmware's definition."""
    return lambda goal: handler(RevisedGoal(firmware, type_name, goal))


class RevisedGoal:
    """A `ServerGoal` whose goal, feedback and result are in the current definitions."""

    def __init__(self, firmware: Firmware, type_name: str, goal: Any) -> None:
        self._firmware = firmware
        self._goal = goal
        self._result = firmware.message_class(f"{type_name}Result")
        self._feedback = firmware.message_class(f"{type_name}Feedback")
        self.goal = firmware.convert(goal.goal, message_type(f"{type_name}Goal"))

    def __getattr__(self, name: str) -> Any:
        return getattr(self._goal, name)

    def publish_feedback(self, feedback: Any) -> None:
        """See `ServerGoal`."""
        self._goal.publish_feedback(self._firmware.convert(feedback, self._feedback))

    def succeed(self, result: Any = None, text: str = "") -> None:
        """See `ServerGoal`."""
        self._goal.succeed(self._old(result), text)

    def abort(self, result: Any = None, text: str = "") -> None:
        """See `ServerGoal`."""
        self._goal.abort(self._old(result), text)

    def preempted(self, result: Any = None, text: str = "") -> None:
        """See `ServerGoal`."""
        self._goal.preempted(self._old(result), text)

    def _old(self, result: Any) -> Any:
        return None if result is None else self._firmware.convert(result, self._result)
