"""The missions of a chassis, awaited: `robot.missions`."""

from __future__ import annotations

from collections.abc import Sequence

from rosproto.aio import SameProperty
from woosh_pure.aio.calls import ThreadCalls
from woosh_pure.aio.chassis import answer as awaited
from woosh_pure.missions import Entry, State
from woosh_pure.missions import Missions as Threaded
from woosh_pure.stopping.report import StopReport


class Missions:
    """The missions of one robot, see `woosh_pure.missions.Missions`. A handle is awaited for its end.

        handle = await robot.missions.run("round.mission.toml")
        run = await handle

    Attributes:
        api: The underlying threaded `Missions`.
    """

    def __init__(self, api: Threaded, calls: ThreadCalls) -> None:
        self.api, self._calls = api, calls

    async def stop(self, *, by: str = "program") -> StopReport:
        """Stop the robot, end the run as stopped, and pause the queue. It completes once it is called."""
        return await self._calls.finish(lambda: self.api.stop(by=by))

    state = SameProperty[State](Threaded.state, "api")
    queue = SameProperty[Sequence[Entry]](Threaded.queue, "api")
    list = awaited(Threaded.list)
    path = awaited(Threaded.path)
    load = awaited(Threaded.load)
    check = awaited(Threaded.check)
    save = awaited(Threaded.save)
    remove = awaited(Threaded.remove)
    run = awaited(Threaded.run)
    append = awaited(Threaded.append)
    unqueue = awaited(Threaded.unqueue)
    clear = awaited(Threaded.clear)
    reorder = awaited(Threaded.reorder)
    pause = awaited(Threaded.pause)
    resume = awaited(Threaded.resume)
    answer = awaited(Threaded.answer)
    status = awaited(Threaded.status)
    find = awaited(Threaded.find)
    since = awaited(Threaded.since)
    wait_for = awaited(Threaded.wait_for)
    add_webhook = awaited(Threaded.add_webhook)
