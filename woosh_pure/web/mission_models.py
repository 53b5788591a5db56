"""The requests and answers about missions in the REST API, as pydantic models; see `models`."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Field

from woosh_pure.web.models import Answer, Request, Said, Words


class MissionRequest(Request):
    """A mission: the values of its file."""

    mission: dict[str, Any]


class MissionStart(Request):
    """What to start: the name of a file, and parameters other than the defaults."""

    file: Annotated[str, Field(min_length=1, max_length=100)]
    parameters: Annotated[dict[str, str | float | bool], Field(default_factory=dict)]


class MissionAnswer(Request):
    """An answer to a question; with `step`, that of the run, it is not taken for the next question."""

    answer: Annotated[str, Field(min_length=1, max_length=200)]
    step: float | None = None


class MissionPlace(Request):
    """A place in the queue, from 0."""

    place: Annotated[float, Field(ge=0, le=1000, multiple_of=1)]


class MissionFile(Answer):
    """A mission of the folder; null if its file is faulty, and `problem` says why."""

    file: str
    problem: Words | None
    mission: dict[str, Any] | None


class MissionFolder(Answer):
    """The missions, the keys of each kind of step, and those of every step; a default of null is none."""

    missions: list[MissionFile]
    kinds: dict[str, dict[str, object]]
    common: dict[str, object]


class MissionRun(Answer):
    """A run of a mission, or a mission in the queue."""

    id: str
    mission: str
    parameters: dict[str, object]
    who: Words
    state: Annotated[
        str, Field(description="`queued`, `paused`, or the phase: `running`, `asking`, `done` ...")
    ]
    done: bool
    step: Annotated[int, Field(description="the current one, from 0")]
    steps: Annotated[list[dict[str, object]], Field(description="empty once it has ended")]
    question: Annotated[dict[str, object] | None, Field(description="text, answers, default, seconds_left")]
    text: Annotated[Words, Field(description="why it waits, or how it ended")]
    said: Annotated[Said | None, Field(description="the same in both languages")]


class MissionRuns(Answer):
    """The last runs, the one under way, and the queue."""

    paused: bool
    problem: Annotated[Said | None, Field(description="another program carries them out, or no disk")]
    runs: list[MissionRun]
