"""Errors of the library as problem+json (RFC 9457), with the library's own sentence and the error's facts."""

from __future__ import annotations

from typing import Any

from rosproto.errors import (
    BagError,
    ConnectionLost,
    RosError,
    RosTimeout,
    ServiceError,
)
from rosproto.logs import get_logger
from rosproto.text import printable
from woosh_pure.errors import ChassisError, FirmwareLimit, GoalFailed, MotionRefused, StaleState
from woosh_pure.web.snapshot import reasons_part, said_part

MEDIA_TYPE = "application/problem+json"
_logger = get_logger("woosh_pure.web")
_TITLES = {
    400: "Bad request",
    401: "No token",
    403: "Not allowed",
    404: "Not there",
    405: "Not this way",
    408: "Too slow",
    409: "Refused",
    413: "Too large",
    415: "Not this kind",
    421: "Not this server",
    422: "Makes no sense",
    429: "Too often",
    500: "Internal error",
    501: "Not in this firmware",
    502: "The robot said no",
    503: "Not available",
    504: "No answer in time",
}
KINDS: tuple[tuple[type[Exception], int, str], ...] = (
    (MotionRefused, 409, "motion-refused"),
    (StaleState, 503, "stale-state"),
    (FirmwareLimit, 501, "firmware-limit"),
    (GoalFailed, 409, "goal-failed"),
    (RosTimeout, 504, "timeout"),
    (ConnectionLost, 503, "connection-lost"),
    (ServiceError, 502, "service-error"),
    (ChassisError, 502, "chassis-error"),
    (BagError, 503, "bag-error"),
    (RosError, 502, "ros-error"),
    (KeyError, 404, "not-there"),
    (ValueError, 422, "value"),
)


class Problem(Exception):
    """An error that the client is told as it is.

    Attributes:
        status: The HTTP status.
        text: The sentence.
        kind: A short word for programs.
        facts: Further members of the document.
    """

    def __init__(self, status: int, text: str, kind: str = "", **facts: Any) -> None:
        super().__init__(text)
        self.status, self.text, self.kind, self.facts = status, text, kind, facts

    def document(self, instance: str) -> dict[str, Any]:
        """The problem+json document."""
        kind = self.kind or _TITLES.get(self.status, "problem").lower().replace(" ", "-")
        return {
            "type": f"urn:woosh:{kind}",
            "title": _TITLES.get(self.status, "Problem"),
            "status": self.status,
            "detail": printable(self.text),
            "instance": instance,
            **self.facts,
        }


def problem_of(error: Exception) -> Problem:
    """An error as a problem. An unexpected one is logged, and the client gets no details of it."""
    if isinstance(error, Problem):
        return error
    for of, status, kind in KINDS:
        if isinstance(error, of):
            text = str(error.args[0]) if isinstance(error, KeyError) and error.args else str(error)
            return Problem(status, text, kind, **_facts(error))
    _logger.error("an unforeseen error: %r", error, exc_info=error)
    return Problem(500, "an error that nobody foresaw; the log of the server has it", "internal")


def _facts(error: Exception) -> dict[str, Any]:
    facts: dict[str, Any] = {}
    if isinstance(error, MotionRefused):
        facts.update(reasons=reasons_part(error.reasons), said=said_part(error.said))
    elif isinstance(error, StaleState):
        facts.update(topic=error.topic, age=error.age)
    elif isinstance(error, FirmwareLimit):
        facts.update(name=error.name, fields=list(error.fields), firmware=error.firmware)
    elif isinstance(error, RosTimeout):
        facts.update(what=error.what, seconds=error.seconds)
    return facts
