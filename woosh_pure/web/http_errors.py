"""Errors of the library as problem+json (RFC 9457): status, kind, the library's sentence, and its facts."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from http import HTTPStatus
from typing import TypeVar, cast

from rosproto.errors import (
    BagError,
    ConnectionLost,
    RosError,
    RosTimeout,
    ServiceError,
)
from rosproto.logs import get_logger
from rosproto.sentence import Sentence, say, sentence_of, shown
from rosproto.text import printable
from woosh_pure.errors import ApiRefused, ChassisError, FirmwareLimit, GoalFailed, MotionRefused, StaleState
from woosh_pure.language import translated
from woosh_pure.missions.machine import Refused
from woosh_pure.missions.mission import MissionError
from woosh_pure.web.snapshot import ADVICE, plain, reasons_part, said_part

T = TypeVar("T")
MEDIA_TYPE = "application/problem+json"
_logger = get_logger("woosh_pure.web")
_NEW_PHRASES = {413: "Content Too Large", 422: "Unprocessable Content"}
"""Of RFC 9110, where `http.HTTPStatus` has older ones before Python 3.13."""
STATUS_KINDS = {
    400: "bad-request",
    401: "no-token",
    403: "not-allowed",
    404: "not-there",
    405: "not-this-way",
    408: "too-slow",
    409: "refused",
    413: "too-large",
    415: "not-this-kind",
    421: "not-this-server",
    422: "not-valid",
    429: "too-often",
    500: "internal-error",
    501: "not-in-this-firmware",
    502: "the-robot-said-no",
    503: "not-available",
    504: "no-answer-in-time",
}
"""The kind of a problem that has none of its own."""
REFUSAL_KINDS = {
    "headers": "not-this-way",
    "host": "not-this-server",
    "origin": "not-allowed",
    "token": "no-token",
    "wrong-token": "wrong-token",
    "too-many-tokens": "too-many-tokens",
}
"""Kinds of problems, by the reason of an `AdmissionRefusal`."""
KINDS: tuple[tuple[type[Exception], int, str], ...] = (
    (MotionRefused, 409, "motion-refused"),
    (StaleState, 503, "stale-state"),
    (FirmwareLimit, 501, "firmware-limit"),
    (GoalFailed, 409, "goal-failed"),
    (RosTimeout, 504, "timeout"),
    (ConnectionLost, 503, "connection-lost"),
    (ServiceError, 502, "service-error"),
    (ApiRefused, 409, "api-refused"),
    (Refused, 409, "mission"),
    (MissionError, 422, "mission"),
    (ChassisError, 502, "chassis-error"),
    (BagError, 503, "bag-error"),
    (RosError, 502, "ros-error"),
    (KeyError, 404, "not-there"),
    (ValueError, 422, "value"),
)


def title_of(status: int) -> str:
    """Return the registered phrase of a status."""
    return _NEW_PHRASES.get(status) or HTTPStatus(status).phrase


class Problem(Exception):
    """An error whose text is sent to the client.

    Attributes:
        status: The HTTP status.
        text: The sentence, of a template and its `values`.
        kind: A short word for programs.
        facts: Further members of the document.
    """

    def __init__(
        self,
        status: int,
        text: str,
        kind: str = "",
        /,
        *,
        facts: dict[str, object] | None = None,
        **values: object,
    ) -> None:
        self.text = say(text, **values) if values else text
        super().__init__(self.text)
        self.status, self.kind, self.facts = status, kind, facts or {}

    def again(self) -> Problem:
        """A copy to raise again, without the traceback of this one."""
        return Problem(self.status, self.text, self.kind, facts=self.facts)

    def document(self, instance: str) -> dict[str, object]:
        """The problem+json document for a requested path, for `worded`."""
        kind = self.kind or STATUS_KINDS.get(self.status, "problem")
        return {
            "type": f"urn:woosh:{kind}",
            "title": title_of(self.status),
            "status": self.status,
            "detail": shown(say(self.text)),
            "instance": instance,
            **self.facts,
        }


def for_clients(text: str) -> str:
    """Replace advice for Python in a sentence of the library by advice for clients of the API."""
    return text.advised(ADVICE) if isinstance(text, Sentence) else text


def language_of(headers: Mapping[str, str]) -> str:
    """Return the first language of `Accept-Language`: "zh", or else "en"."""
    return "zh" if headers.get("accept-language", "").strip().lower().startswith("zh") else "en"


def worded(document: T, headers: Mapping[str, str]) -> T:
    """Return a document with its sentences in the language of a request; texts that are data stay."""
    said = partial(translated, language=language_of(headers))
    made = plain(document, text=lambda text: printable(said(text)) if isinstance(text, Sentence) else text)
    return cast("T", made)


def problem_of(error: Exception) -> Problem:
    """Convert an error to a problem. An unexpected error is logged, and its details are not sent."""
    if isinstance(error, Problem):
        return error
    for of, status, kind in KINDS:
        if isinstance(error, of):
            return Problem(status, for_clients(sentence_of(error)), kind, facts=_facts(error))
    _logger.error("internal error: %r", error, exc_info=error)
    return Problem(500, "internal error; see the server's log", "internal")


def _facts(error: Exception) -> dict[str, object]:
    facts: dict[str, object] = {}
    if isinstance(error, MotionRefused):
        facts.update(reasons=reasons_part(error.reasons), said=said_part(error.robot_text))
    elif isinstance(error, MissionError):
        facts.update(path=[*error.path])
    elif isinstance(error, ApiRefused):
        facts.update(said=said_part(error.robot_text))
    elif isinstance(error, StaleState):
        facts.update(topic=error.topic, age=error.age)
    elif isinstance(error, FirmwareLimit):
        facts.update(name=error.name, fields=list(error.fields), firmware=error.firmware)
    elif isinstance(error, RosTimeout):
        facts.update(what=error.what, seconds=error.seconds)
    return facts
