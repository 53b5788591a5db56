"""`Missions`: the missions of one chassis, their queue and the current run, as `chassis.missions`.

One thread applies events to the machine, saves the state, and then begins what follows. The state is a file
that one program at a time has open: the first call that changes something opens it. Another program on this
computer reads it, and leaves its requests in a folder beside it, which that thread looks into.
"""

from __future__ import annotations

import json
import os
import queue
import re
import threading
import time
import uuid
from collections.abc import Callable, Generator, Mapping
from concurrent.futures import Future
from concurrent.futures import TimeoutError as TimedOut  # not the built-in one before Python 3.11
from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rosproto.errors import RosError, RosTimeout
from rosproto.files import read_text, save_file
from rosproto.logs import get_logger
from rosproto.sentence import both, say, sentence_of
from woosh_pure.connection.call_scope import CallScope
from woosh_pure.enums import TaskState
from woosh_pure.errors import ChassisError
from woosh_pure.missions import machine
from woosh_pure.missions.file import MissionFiles
from woosh_pure.missions.machine import Phase, Refused, Run, State
from woosh_pure.missions.mission import Mission, MissionError, Value, mission_of
from woosh_pure.missions.steps import InputAnswers, StepRunner
from woosh_pure.missions.webhooks import Webhook
from woosh_pure.motion.task_list import stored_task_list
from woosh_pure.reasons import Ready, ReasonKey
from woosh_pure.state_file import Store, StoreInUse, default_folder
from woosh_pure.stopping.other_clients import hear_stops
from woosh_pure.stopping.report import StopReport

if TYPE_CHECKING:
    from woosh_pure.chassis import Chassis

_log = get_logger("woosh_pure.missions")
PROGRAM = "program"
"""Name of who asks, where none is given."""
Named = str | Path | Mission
Given = Mapping[str, object] | None
_LOOK, _DISK_SECONDS, _ASK_SECONDS, _LISTS_SECONDS = 0.1, 1.0, 10.0, 2.0
_LEASE_SECONDS = 60.0
_Asked = tuple[str, Mapping[str, Any], Future[str], CallScope]


class MissionFailed(ChassisError):
    """A mission failed or was stopped: `run` says why."""

    exit_code = 1

    def __init__(self, run: Run) -> None:
        name = run.entry.mission.name
        text = "mission {name}: {phase} at step {number}: {reason}"
        super().__init__(say(text, name=name, phase=run.phase, number=run.at + 1, reason=say(run.reason)))
        self.run = run


class MissionHandle:
    """A mission that was started or appended; `id` is that of its run."""

    def __init__(self, missions: Missions, id: str) -> None:
        self.id, self._missions = id, missions

    def __repr__(self) -> str:
        return f"<MissionHandle {self.id}>"

    @property
    def run(self) -> Run | None:
        """Its run; None while it is in the queue, and when it was removed."""
        return self._missions.find(self.id)

    def wait(self, timeout: float | None = None, *, raises: bool = True) -> Run:
        """Wait for its end.

        Raises:
            MissionFailed: It failed or was stopped, unless `raises` is false.
            MissionError: It was removed from the queue.
            RosTimeout: It has not ended in time; it goes on.
        """

        def over() -> bool:
            run = self.run
            if run is None and self.id not in [entry.id for entry in self._missions.state.queue]:
                raise MissionError(say("mission {id} was removed from the queue", id=self.id))
            return run is not None and run.phase.over

        self._missions.wait_for(over, timeout)
        run = self.run
        assert run is not None
        if raises and run.phase is not Phase.DONE:
            raise MissionFailed(run)
        return run

    def __await__(self) -> Generator[Any, None, Run]:
        """In asyncio: `run = await handle` is `wait()`; cancelling the task leaves the mission running."""
        return self._awaited().__await__()

    async def _awaited(self) -> Run:
        import asyncio

        while True:  # in parts: a cancelled task leaves its thread behind for one of them at most
            with suppress(RosTimeout):
                return await asyncio.to_thread(self.wait, 1.0)


class Missions(MissionFiles):
    """The missions of one robot. Safe from any thread; nothing moves because this object is made.

        chassis.missions.run("round.mission.toml", {"target": "A1"}).wait()

    Args:
        chassis: The chassis.
        folder: Of the state; None for the user's.
        carries: False for a program that only leaves requests, and ends soon: with it nothing begins.

    Attributes:
        closing: `Chassis.close` sets it before it stops what runs: that interrupts the run.
    """

    def __init__(
        self, chassis: Chassis, folder: str | os.PathLike[str] | None = None, *, carries: bool = True
    ) -> None:
        super().__init__()
        self._chassis, self.carries = chassis, carries
        self.folder = default_folder("missions") if folder is None else Path(folder)
        robot = re.sub(r"^https?://|/$", "", chassis.master_uri)
        used = say("another program carries the missions of {robot} out already", robot=robot)
        self._store = Store(self.folder, "missions", robot, in_use=used)
        self._requests = self._store.path.with_suffix(".requests")
        self._opening, self._changed = threading.Lock(), threading.Condition()
        self._inbox: queue.SimpleQueue[_Asked | None] = queue.SimpleQueue()
        self._thread: threading.Thread | None = None
        self._state = State()  # of a program that has it open
        self._step: StepRunner | None = None
        self._inputs: InputAnswers | None = None
        self.closing = self._hears = self._holds = False
        self._due = {"disk": 0.0, "lease": 0.0}
        self._webhook: Webhook | None = None
        self._owner = ""

    def __repr__(self) -> str:
        return f"<Missions {self._store.path}>"

    # -- run and queue

    def run(self, mission: Named, parameters: Given = None, *, by: str = PROGRAM) -> MissionHandle:
        """Start a mission now, also while the queue is paused.

        Args:
            mission: A mission or a file, see `path`.
            parameters: For those that shall not have their defaults.
            by: The name of who starts it. If this one has the lease, the mission takes it over.

        Raises:
            MissionError: It is faulty; or another run has not ended (`append` it then).
        """
        return self._append(mission, parameters, by, start=True)

    def append(self, mission: Named, parameters: Given = None, *, by: str = PROGRAM) -> MissionHandle:
        """Append a mission to the queue; it begins when it is the first one and the queue is not paused.

        Raises:
            MissionError: It is faulty, or the queue is full.
        """
        return self._append(mission, parameters, by, start=False)

    def _append(self, mission: Named, given: Given, by: str, *, start: bool) -> MissionHandle:
        found, file = (mission, "") if isinstance(mission, Mission) else (self.load(mission), str(mission))
        filled = found.filled(given or {})
        id = self._ask("append", mission=found, parameters=filled, by=by, file=file, start=start)
        return MissionHandle(self, id)

    def unqueue(self, id: str, *, by: str = PROGRAM) -> None:
        """Remove an entry of the queue. Raises MissionError if it is not there."""
        self._ask("change_queue", by=by, id=id or "-")

    def clear(self, *, by: str = PROGRAM) -> None:
        """Remove all entries of the queue."""
        self._ask("change_queue", by=by)

    def reorder(self, id: str, place: int, *, by: str = PROGRAM) -> None:
        """Move an entry of the queue to a place, from 0. Raises MissionError if it is not there."""
        self._ask("change_queue", by=by, id=id or "-", place=place)

    def pause(self, *, by: str = PROGRAM) -> None:
        """Pause the run and the queue. A step that cannot pause goes on to its end."""
        self._ask("pause", by=by)

    def resume(self, *, by: str = PROGRAM) -> None:
        """Let a paused or interrupted run, and the queue, go on. It may move the robot."""
        self._ask("resume", by=by)

    def stop(self, *, by: str = PROGRAM) -> StopReport:
        """Stop the robot, end the run as stopped, and pause the queue."""
        if opened := self._thread is not None:
            self._put("stop", by=by)
        report = self._chassis.stop(everything=True)
        if not opened:
            self._ask("stop", by=by)
        return report

    def answer(self, answer: str, *, by: str = PROGRAM, run: str = "") -> None:
        """Answer the question. Raises MissionError without one (of this run), or if it has no such answer."""
        self._ask("answer", answer=answer, by=by, run=run)

    # -- what happens

    @property
    def state(self) -> State:
        """Everything: the queue, the run, the last runs and notices. Waits for the disk at most.

        A run that no program carries out any more is shown as interrupted.
        """
        if self._thread is not None:
            return self._state
        state = self._read()
        if state.active:
            with suppress(OSError):  # StoreInUse: another program carries it out
                self._store.lock()
                self._store.unlock()
                state = machine.step(state, "restarted", 0.0, time.time())
        return state

    def find(self, id: str) -> Run | None:
        """A run by its id: the current one, or one of the last 50."""
        return next((run for run in self.state.runs if run.entry.id == id), None)

    @property
    def owner(self) -> str:
        """The name by which the run under way holds the lease; "" while there is none."""
        return self._owner

    def wait_for(self, accept: Callable[[], bool], timeout: float | None = 60.0) -> None:
        """Wait until `accept()` is true; it is called after each change.

        Raises:
            RosTimeout: It was not in time.
        """
        end = None if timeout is None else time.monotonic() + timeout
        while not accept():
            if end is not None and time.monotonic() >= end:
                why = say("the missions did not come so far")
                raise RosTimeout(why, what="missions", seconds=timeout or 0.0)
            with self._changed:
                self._changed.wait(_LOOK)

    def add_webhook(self, url: str, secret: str) -> None:
        """Send each start, step, question and end of a mission to a URL, signed with the secret.

        Raises:
            ValueError: The URL or the secret is not one.
            MissionError: Another program carries the missions out.
        """
        self.open()
        self._webhook = Webhook(url, secret, lambda: self.state, partial(self._put, "delivered"))

    def close(self) -> None:
        """Cancel what runs: the run is interrupted, and can be resumed. Idempotent, bounded."""
        self.closing = True
        if self._step is not None:
            self._step.want(None)  # at once
        with self._opening:
            if self._thread is None:
                return
        self._inbox.put(None)
        self._thread.join(_ASK_SECONDS)
        if self._step is not None:
            self._step.want(None)  # one that was begun meanwhile
            self._step.ended.wait(_ASK_SECONDS)
        if self._inputs is not None:
            self._inputs.off()
        if self._webhook is not None:
            self._webhook.close()
        self._chassis.lease.release(self._owner)
        self._store.unlock()

    # -- requests

    def _ask(self, event: str, **values: Any) -> str:
        """Have the thread apply an event, or the other program that has the state open; the new id."""
        try:
            self.open()
        except StoreInUse:
            return self._ask_other(event, values)
        try:
            return self._put(event, **values).result(_ASK_SECONDS)
        except TimedOut as late:
            why = say("the missions do not answer")
            raise RosTimeout(why, what="missions", seconds=_ASK_SECONDS) from late

    def _put(self, event: str, **values: Any) -> Future[str]:
        """Have the thread apply an event; what it returns need not be waited for."""
        done: Future[str] = Future()
        self._inbox.put((event, values, done, self._chassis.request()))
        return done

    def open(self) -> None:
        """Carry the missions out in this program, as with the first request. Nothing moves by it.

        Raises:
            StoreInUse: Another program does, which gets what is asked for here.
        """
        with self._opening:
            if self.closing:
                raise MissionError(say("the missions of this Chassis are closed"))
            if self._thread is None:
                self._store.lock()
                self._state = self._read()
                self._apply("restarted", carries=self.carries)
                self._thread = threading.Thread(target=self._work, name="woosh:missions", daemon=True)
                self._thread.start()

    def _read(self) -> State:
        kept = self._store.load()
        try:
            return machine.state_of(kept[0]) if kept else State()
        except (ValueError, KeyError, TypeError, AttributeError) as error:
            self._store.put_aside(f"{type(error).__name__}: {error}")
            return State()

    def _ask_other(self, event: str, values: Mapping[str, Any]) -> str:
        path = self._requests / f"{uuid.uuid4()}.json"
        reply = path.with_suffix(".reply")
        save_file(path, json.dumps({"event": event, **values}, default=Mission.data).encode())
        try:
            self.wait_for(reply.exists, _ASK_SECONDS)
            answer = json.loads(read_text(reply))
        finally:
            path.unlink(missing_ok=True)
            reply.unlink(missing_ok=True)
        if "error" in answer:
            raise Refused(answer["error"])
        return str(answer["id"])

    def _take_requests(self, stopped: bool) -> None:
        for path in sorted(self._requests.glob("*.json")) if self._requests.is_dir() else ():
            try:
                values = json.loads(read_text(path))
                if "mission" in values:
                    values["mission"] = mission_of(values["mission"])
                if (event := values.pop("event")) not in machine.REQUESTS:
                    raise ValueError(event)
                answer = {"id": self._carry_out(event, values, stopped)}
            except (ValueError, KeyError, TypeError, OSError) as error:
                answer = {"error": str(error)}
            path.unlink(missing_ok=True)
            with suppress(OSError):  # of a full disk: the other program's time runs out
                save_file(path.with_suffix(".reply"), json.dumps(answer).encode())

    # -- the thread

    def _work(self) -> None:
        checked = self._chassis.request()
        while True:
            try:
                asked = self._inbox.get(timeout=_LOOK)
            except queue.Empty:
                asked = None
            # A stop before this moment ends the run first; a later one prevents the motion that begins now.
            now = checked.renewed()
            stopped, checked = checked.overtaken_at(now.stops), now
            if self.closing:  # after the look: a stop by `close`, which sets it before, interrupts the run
                return
            try:
                with now:
                    if stopped and self._state.active:
                        self._apply("stop", by=say("a stop of the robot"))
                    if asked is not None:
                        event, values, done, request = asked
                        try:
                            done.set_result(self._carry_out(event, values, request.overtaken))
                        except Refused as refusal:
                            done.set_exception(refusal)
                    self._take_requests(stopped)
                    self._heed_inputs()
                    self._on_time(time.monotonic())
            except Exception:
                _log.exception("! an internal error of the missions; they go on")

    def _carry_out(self, event: str, values: Mapping[str, Any], stopped: bool) -> str:
        """Apply an event, unless the robot was stopped since somebody asked for it: it must not go on."""
        if stopped and event in ("append", "resume", "answer"):
            raise Refused(say("somebody stopped the robot meanwhile; look, and ask again"))
        new = str(self._state.next_id)
        if event == "append":
            self._require_lists(**values)
        if event == "resume":
            self._settle()
        self._apply(event, **values)
        return new

    def _require_lists(self, mission: Mission, parameters: Mapping[str, Value], **_: object) -> None:
        """Refuse a mission with task lists that the robot does not have, or could not stop."""
        for step in (*mission.steps, *mission.on_abort):
            if step.do == "task_list":
                try:
                    name = step.value("list", parameters)
                    stored_task_list(self._chassis.robot_api, name, timeout=_LISTS_SECONDS)
                except (RosError, ValueError) as error:
                    raise Refused(say("task_list: {error}", error=sentence_of(error))) from error

    def _apply(self, event: str, **values: Any) -> None:
        """Apply an event: end what must end, save the state, and then begin what follows."""
        before, now, at = self._state, time.monotonic(), time.time()
        after = machine.step(before, event, now, at, **values)
        if self._step is not None:
            self._step.want(after.running)
        if after is not before and not before.disk:
            try:
                self._store.save(after.to_json())
            except OSError as error:
                text = "the state of the missions cannot be kept: {error}; nothing begins until it can"
                problem = say(text, error=error.strerror or error)
                _log.error("! %s (%s)", problem, error)
                self._due["disk"] = now + _DISK_SECONDS
                self._state = machine.step(before, "disk", now, at, problem=problem)
                after = machine.step(self._state, event, now, at, **values)
        self._state, run = after, after.running
        with self._changed:
            self._changed.notify_all()
        if run is not None and (self._step is None or self._step.token != run.token):
            pictures = self.folder / "pictures"
            self._step = StepRunner(self._chassis, run, self._chassis.request(), self._put, pictures)

    def _on_time(self, now: float) -> None:
        if self._state.disk and now >= self._due["disk"]:
            self._due["disk"] = now + _DISK_SECONDS
            with suppress(OSError):
                self._store.save(replace(self._state, disk="").to_json())
                self._apply("disk", problem="")
        run = self._state.run
        if run is not None and run.deadline is not None and now >= run.deadline:
            self._apply("tick")
        reason = self._keep_lease(now)
        run = self._state.run
        if run is None or run.phase.over or run.phase is Phase.INTERRUPTED or run.paused:
            return
        hindrance = self._hindrance(run)
        reason = reason or hindrance
        if self._state.needs_ready:
            battery = self._chassis.battery.open().known
            if battery is None and run.entry.mission.guard("battery_below"):
                reason = reason or say("the charge of the battery is not known yet")
            self._apply("ready", reason=reason, battery=None if battery is None else battery.value.percent)

    def _heed_inputs(self) -> None:
        """Let an input of the robot answer the question, where its step names some."""
        run = self._state.active
        question = None if run is None else run.question
        if self._inputs is not None and question is not self._inputs.question:
            self._inputs.off()
            self._inputs = None
        if run is None or question is None or question.unknown or not run.value("inputs"):
            return
        if self._inputs is None:
            self._inputs = InputAnswers(self._chassis, run)
        if self._inputs.answer:
            by = say("input {number}", number=self._inputs.number)
            self._apply("answer", answer=self._inputs.answer, by=by)

    def _hindrance(self, run: Run) -> str:
        """Why nothing may move now, "" if it may.

        An emergency stop pauses the run: its release must not move the robot.
        """
        try:
            if not self._hears:
                hear_stops(self._chassis.node, self._chassis.request())
                self._hears = True
            readiness = self._chassis.readiness()
        except RosError as error:
            return str(error)
        if any(reason.key == ReasonKey.EMERGENCY_STOP and reason.blocking for reason in readiness.reasons):
            self._apply("pause", by=say("the emergency stop"))
        if self._step is not None and not self._step.ended.is_set():
            return say("the last step has not ended yet")
        if readiness.answer is not Ready.UNKNOWN:
            return "" if readiness.ready else str(readiness)
        if run.entry.mission.guard("not_known") == "go":
            return ""
        return both(str(readiness), 'a mission with not_known = "go" in its [guards] does not wait for this')

    def _keep_lease(self, now: float) -> str:
        """Hold the lease while a run is under way; who has it instead, "" if nobody has.

        Who takes it over pauses the run: to give it back must not move the robot.
        """
        lease, run = self._chassis.lease, self._state.run
        under_way = run is not None and not run.phase.over and run.phase is not Phase.INTERRUPTED
        owner = f"mission {run.entry.mission.name}"[:200] if run is not None and under_way else ""
        if self._owner != owner:  # also from one mission of the queue to the next one
            lease.release(self._owner)
            self._owner, self._holds = owner, False
        holder = lease.holder
        if run is None or not under_way:
            return ""
        if holder == owner:
            if now >= self._due["lease"]:
                self._due["lease"] = now + _LEASE_SECONDS / 3.0
                lease.renew(owner, _LEASE_SECONDS)
            return ""
        if self._holds and holder is not None:
            self._apply("pause", by=str(holder))
        self._holds = False
        if self._state.run is not None and self._state.run.paused:
            return ""  # its person drives by hand, perhaps
        if holder == run.entry.by and lease.request(owner):
            lease.grant(holder, owner, _LEASE_SECONDS)
        if lease.acquire(owner, _LEASE_SECONDS):
            self._holds = True
            return ""
        return say("{who} commands the robot now", who=holder)

    def _settle(self) -> None:
        """Ask the robot's own history what became of the task that was interrupted."""
        run = self._state.run
        if run is None or not run.task or run.phase is not Phase.INTERRUPTED:
            return
        try:
            history = self._chassis.robot_api.task_history()
        except RosError as error:
            _log.debug("= the robot does not tell its tasks: %s", error)
            return
        found = [task for task in history if task.task_id % 2**64 == run.task and task.time > run.after]
        if found and found[-1].state in (TaskState.COMPLETED, TaskState.FAILED):
            self._apply("settled", token=run.token, done=found[-1].state is TaskState.COMPLETED)
