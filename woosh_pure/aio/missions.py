"""The missions of a chassis, awaited: `robot.missions`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from rosproto.aio import SameProperty
from rosproto.errors import RosTimeout
from woosh_pure.aio.calls import ThreadCalls
from woosh_pure.aio.chassis import answer as awaited
from woosh_pure.missions import Entry, Mission, Run, State
from woosh_pure.missions import MissionHandle as ThreadedHandle
from woosh_pure.missions import Missions as Threaded
from woosh_pure.missions.missions import PROGRAM
from woosh_pure.stopping.report import StopReport

_SLICE = 1.0


class MissionHandle:
    """A mission that was started or appended.

    Attributes:
        api: The underlying threaded `MissionHandle`.
        id: Of its run.
    """

    def __init__(self, api: ThreadedHandle, calls: ThreadCalls) -> None:
        self.api, self.id, self._calls = api, api.id, calls

    @property
    def run(self) -> Run | None:
        """Its run; None while it is in the queue, and when it was removed."""
        return self.api.run

    async def wait(self, timeout: float | None = None, *, raises: bool = True) -> Run:
        """Wait for its end. Cancelling the task leaves the mission running: `robot.missions.stop()` ends it.

        Raises:
            MissionFailed: It failed or was stopped, unless `raises` is false.
            MissionError: It was removed from the queue.
            RosTimeout: It has not ended in time; it goes on.
        """
        while True:
            part = _SLICE if timeout is None else min(_SLICE, timeout)
            timeout = None if timeout is None else timeout - part
            try:
                return await self._calls.call(lambda seconds=part: self.api.wait(seconds, raises=raises))
            except RosTimeout:
                if timeout == 0.0:
                    raise


class Missions:
    """The missions of one robot, see `woosh_pure.missions.Missions`.

    Attributes:
        api: The underlying threaded `Missions`.
    """

    def __init__(self, api: Threaded, calls: ThreadCalls) -> None:
        self.api, self._calls = api, calls

    async def run(
        self,
        mission: str | Path | Mission,
        parameters: Mapping[str, object] | None = None,
        *,
        by: str = PROGRAM,
    ) -> MissionHandle:
        """Start a mission now, also while the queue is paused."""
        begun = await self._calls.call(lambda: self.api.run(mission, parameters, by=by))
        return MissionHandle(begun, self._calls)

    async def stop(self, *, by: str = PROGRAM) -> StopReport:
        """Stop the robot, end the run as stopped, and pause the queue. It completes once it is called."""
        return await self._calls.finish(lambda: self.api.stop(by=by))

    async def append(
        self,
        mission: str | Path | Mission,
        parameters: Mapping[str, object] | None = None,
        *,
        by: str = PROGRAM,
    ) -> MissionHandle:
        """Append a mission to the queue; it begins when it is the first one and the queue is not paused."""
        added = await self._calls.call(lambda: self.api.append(mission, parameters, by=by))
        return MissionHandle(added, self._calls)

    state = SameProperty[State](Threaded.state, "api")
    queue = SameProperty[Sequence[Entry]](Threaded.queue, "api")
    list = awaited(Threaded.list)
    load = awaited(Threaded.load)
    check = awaited(Threaded.check)
    save = awaited(Threaded.save)
    remove = awaited(Threaded.remove)
    unqueue = awaited(Threaded.unqueue)
    clear = awaited(Threaded.clear)
    reorder = awaited(Threaded.reorder)
    pause = awaited(Threaded.pause)
    resume = awaited(Threaded.resume)
    answer = awaited(Threaded.answer)
    add_webhook = awaited(Threaded.add_webhook)
    status = awaited(Threaded.status)
    find = awaited(Threaded.find)
    since = awaited(Threaded.since)
    wait_for = awaited(Threaded.wait_for)
