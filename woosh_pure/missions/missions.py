"""`Missions`: the missions of one chassis, their queue and the current run, as `chassis.missions`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from woosh_pure.missions.machine import Entry, Notice, Run, State
from woosh_pure.missions.mission import Mission

if TYPE_CHECKING:
    from woosh_pure.chassis import Chassis

PROGRAM = "program"
"""Name of who asks, where none is given."""


@dataclass(frozen=True, slots=True)
class StoredMission:
    """One file of the folder of missions.

    Attributes:
        file: Its name, "round.mission.toml".
        mission: None if it is faulty.
        error: Why; "" if it is not.
    """

    file: str
    mission: Mission | None
    error: str = ""


class MissionHandle:
    """A mission that was started or appended.

    Attributes:
        id: Of the run.
    """

    def __init__(self, missions: Missions, id: str) -> None:
        self.id = id
        self._missions = missions

    @property
    def run(self) -> Run | None:
        """Its run; None while it is in the queue, and when it was removed."""
        raise NotImplementedError

    def wait(self, timeout: float | None = None, *, raises: bool = True) -> Run:
        """Wait for its end.

        Raises:
            MissionFailed: It failed or was stopped, unless `raises` is false.
            RosTimeout: It has not ended in time; it goes on.
        """
        raise NotImplementedError


class Missions:
    """The missions of one robot. Safe from any thread; nothing moves because this object is made.

    The state is kept in a folder, which one program at a time has open: the first call that changes something
    opens it. Commands of other programs reach it through the folder.

    Args:
        chassis: The chassis.
        folder: Of the state, and of the mission files in its `files`; None for the user's.
        webhook: A URL that gets each notice, signed with `$WOOSH_WEBHOOK_SECRET`.
    """

    def __init__(self, chassis: Chassis, folder: str | Path | None = None, *, webhook: str = "") -> None:
        self._chassis = chassis

    # -- files

    def list(self) -> Sequence[StoredMission]:
        """The files of the folder of missions, sorted by name."""
        raise NotImplementedError

    def load(self, file: str | Path) -> Mission:
        """Read a file: a path, or a name in the folder of missions (with or without `.mission.toml`).

        Raises:
            MissionError: It is faulty, or there is none.
        """
        raise NotImplementedError

    def check(self, text: str, name: str = "mission") -> Mission:
        """Check the text of a file.

        Raises:
            MissionError: It is faulty: line, column, what was found, what is allowed.
        """
        raise NotImplementedError

    def save(self, file: str, mission: Mission | Mapping[str, Any] | str) -> StoredMission:
        """Write a file of the folder of missions: a mission, its `data()`, or its text as it is.

        Raises:
            MissionError: It is faulty, or `file` is not a name. Nothing is written.
        """
        raise NotImplementedError

    def remove(self, file: str) -> None:
        """Delete a file of the folder of missions."""
        raise NotImplementedError

    # -- run and queue

    def run(
        self,
        mission: str | Path | Mission,
        parameters: Mapping[str, object] | None = None,
        *,
        by: str = PROGRAM,
    ) -> MissionHandle:
        """Start a mission now.

        Raises:
            MissionError: It is faulty; or another run has not ended (`append` it then).
        """
        raise NotImplementedError

    def append(
        self,
        mission: str | Path | Mission,
        parameters: Mapping[str, object] | None = None,
        *,
        by: str = PROGRAM,
    ) -> MissionHandle:
        """Append a mission to the queue; it begins when it is the first one and the queue is not paused.

        Raises:
            MissionError: It is faulty, or the queue is full.
        """
        raise NotImplementedError

    @property
    def queue(self) -> Sequence[Entry]:
        """What comes after the current run."""
        raise NotImplementedError

    def unqueue(self, id: str, *, by: str = PROGRAM) -> None:
        """Remove an entry of the queue. Raises MissionError if it is not there."""
        raise NotImplementedError

    def clear(self, *, by: str = PROGRAM) -> None:
        """Remove all entries of the queue."""
        raise NotImplementedError

    def reorder(self, id: str, place: int, *, by: str = PROGRAM) -> None:
        """Move an entry of the queue to a place, from 0."""
        raise NotImplementedError

    def pause(self, *, by: str = PROGRAM) -> None:
        """Pause the run and the queue. A step that cannot pause goes on to its end."""
        raise NotImplementedError

    def resume(self, *, by: str = PROGRAM) -> None:
        """Let a paused or interrupted run, and the queue, go on."""
        raise NotImplementedError

    def stop(self, *, by: str = PROGRAM) -> None:
        """End the run as stopped, stop the robot, and pause the queue. Never refused, does not wait."""
        raise NotImplementedError

    def answer(self, answer: str, *, by: str = PROGRAM, run: str = "") -> None:
        """Answer the question.

        Raises:
            MissionError: There is no question (of this run), or it has no such answer.
        """
        raise NotImplementedError

    # -- what happens

    @property
    def state(self) -> State:
        """Everything: the queue, the run, the last runs and notices. Never waits."""
        raise NotImplementedError

    def status(self) -> Run | None:
        """The current run, or the last one; None before the first."""
        return self.state.run

    def find(self, id: str) -> Run | None:
        """A run by its id: the current one, or one of the last 50."""
        raise NotImplementedError

    def since(self, number: int) -> Sequence[Notice]:
        """The notices after that number."""
        raise NotImplementedError

    def on_notice(self, callback: Callable[[Notice], object]) -> Callable[[], None]:
        """Call back with each notice, in the thread of the missions; return a function that ends this."""
        raise NotImplementedError

    def close(self) -> None:
        """Cancel what runs: the run is interrupted, and can be resumed. Idempotent, bounded."""
        raise NotImplementedError
