"""The missions of one robot for its clients: files and runs as they are sent, and runs in the journal."""

from __future__ import annotations

import threading
import time
from typing import Any

from rosproto.sentence import sentence_of, shown
from rosproto.text import printable
from woosh_pure.chassis import Chassis
from woosh_pure.missions import Run, StoredMission
from woosh_pure.missions.machine import MAX_HISTORY
from woosh_pure.state_file import StoreInUse
from woosh_pure.web.goals import Journal, command
from woosh_pure.web.http_errors import Problem
from woosh_pure.web.snapshot import plain, said_part

MAX_ENDED = 10
"""Ended runs that a page is sent."""


def file_part(stored: StoredMission) -> dict[str, Any]:
    """A file as the API sends it; `problem` is why it cannot be started."""
    data = None if stored.mission is None else plain(stored.mission.data(), text=printable)
    return {"file": stored.file, "problem": shown(stored.error) or None, "mission": data}


def run_part(run: Run, *, queued: bool = False) -> dict[str, Any]:
    """A run, or a mission in the queue; its steps only while it is under way."""
    done, given = run.phase.over, run.entry.parameters
    ended = {} if run.failure else dict(run.ended)
    left = None if run.deadline is None else max(0, round(run.deadline - time.monotonic()))
    steps = [
        {
            "do": step.do,
            "values": {key: step.value(key, given) for key in step.values},
            "state": {True: "done", False: "failed", None: ""}[ended.get(place)],
        }
        for place, step in enumerate(() if done or queued else run.steps)
    ]
    part = {
        "id": run.entry.id,
        "mission": run.entry.mission.name,
        "parameters": given,
        "state": "queued" if queued else "paused" if run.paused and not done else run.phase,
        "done": done,
        "step": run.at,
        "steps": steps,
        "question": run.question and {**plain(run.question), "seconds_left": left},
    }
    sentences = {"who": shown(run.entry.by), "text": shown(run.reason), "said": said_part(run.reason)}
    return {**plain(part, text=printable), **sentences}


class RobotMissions:
    """The missions of one robot. A stream of events takes them for a feed: `count` is that of the notices."""

    known, closed = True, False

    def __init__(self, chassis: Chassis, journal: Journal) -> None:
        self._chassis, self._journal = chassis, journal
        self._noted, self._noting = 0, threading.Lock()

    def connect(self) -> None:
        """Nothing, see `RobotMissions`."""

    @property
    def count(self) -> int:
        """See `RobotMissions`."""
        return sum(notice.number for notice in self._chassis.missions.state.notices[-1:])

    def file(self, name: str) -> StoredMission:
        """One file. Raises Problem without one of that name."""
        found = next((one for one in self._chassis.missions.list() if one.file == name), None)
        if found is None:
            raise Problem(404, "there is no mission {name!r} in the folder of this server", name=name)
        return found

    def part(self) -> dict[str, Any]:
        """The last runs, the one under way, and the queue; why this server cannot carry them out."""
        try:
            self._chassis.missions.open()
            problem = self._chassis.missions.state.disk
        except StoreInUse as error:
            problem = sentence_of(error)
        self.note_runs()
        runs = self._parts(MAX_ENDED)
        return {"paused": self._chassis.missions.state.paused, "problem": said_part(problem), "runs": runs}

    def _parts(self, ended: int) -> list[dict[str, Any]]:
        state = self._chassis.missions.state
        queue = [run_part(Run(entry), queued=True) for entry in state.queue]
        return [run_part(run) for run in state.runs[-ended - 1 :]] + queue

    def run(self, number: str) -> dict[str, Any]:
        """One run, or a mission in the queue. Raises Problem without one, or if it is not kept any more."""
        found = next((part for part in self._parts(MAX_HISTORY) if part["id"] == number), None)
        if found is None:
            raise Problem(404, "run {number!r} was not found; the last 50 are kept", number=number[:20])
        return found

    def note_runs(self) -> None:
        """Note the begin and the end of runs in the journal, also of those of other programs."""
        with self._noting:
            for notice in self._chassis.missions.state.notices:
                new, self._noted = notice.number > self._noted, max(notice.number, self._noted)
                run = self._chassis.missions.find(notice.run)
                if new and run is not None and notice.kind in ("start", "interrupted", "end"):
                    state = notice.values.get("phase") or notice.kind.replace("start", "begun")
                    what = command("mission", mission=notice.mission)
                    self._journal.note(run.entry.by, what, state, notice.text, notice.at)
