"""`woosh mission`: check, run and watch named lists of steps, from any terminal of this computer."""

from __future__ import annotations

import json
import os
from argparse import ArgumentParser, Namespace
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from dataclasses import asdict
from typing import TYPE_CHECKING

from rosproto.sentence import both, led, say
from woosh_pure.cli.arguments import add_watchdog
from woosh_pure.cli.connection import chosen, connect, watchdog_of
from woosh_pure.cli.output import Output

if TYPE_CHECKING:
    from woosh_pure.missions.file import MissionFiles
    from woosh_pure.missions.machine import Notice
    from woosh_pure.missions.mission import Mission
    from woosh_pure.missions.missions import MissionHandle, Missions

BY = "woosh mission"
"""The name of who asks by these commands."""


def add_mission(parser: ArgumentParser) -> None:
    verbs = parser.add_subparsers(dest="verb", metavar="VERB", required=True)
    run = verbs.add_parser("run", help="start a mission, and show its steps until it ends")
    check = verbs.add_parser("check", help="say whether a file is a valid mission; moves nothing")
    verbs.add_parser("list", help="list the folder of missions")
    show = verbs.add_parser("show", help="print a mission as it is saved, without comments")
    queue = verbs.add_parser("queue", help="show or change what comes next")
    verbs.add_parser("pause", help="pause the running mission and the queue")
    resume = verbs.add_parser("resume", help="let a paused or interrupted mission go on")
    verbs.add_parser("stop", help="stop the robot, end the mission, and pause the queue")
    answer = verbs.add_parser("answer", help="answer the question of the running mission")
    answer.add_argument("answer", metavar="ANSWER", help="one of its answers")
    verbs.add_parser("status", help="show the running mission, or the last one")
    for named in (run, check, show):
        named.add_argument("file", metavar="FILE", help="a file, or a name in the folder of missions")
    for carries in (run, resume):
        add_webhook(carries)
        add_watchdog(carries)
    change = queue.add_mutually_exclusive_group()
    change.add_argument("--append", metavar="FILE", help="append a mission")
    change.add_argument("--remove", metavar="ID", help="remove an entry")
    change.add_argument("--first", metavar="ID", help="move an entry to the first place")
    change.add_argument("--clear", action="store_true", help="remove all entries")
    for starts in (run, queue):
        starts.add_argument(
            "--set", action="append", default=[], metavar="NAME=VALUE", help="set a parameter"
        )


def add_webhook(parser: ArgumentParser) -> None:
    parser.add_argument(
        "--webhook",
        metavar="URL",
        help="post start, steps, questions and end there, signed with $WOOSH_WEBHOOK_SECRET",
    )


def use_webhook(missions: Missions, args: Namespace) -> None:
    """Add the webhook of the option, if it is given."""
    if args.webhook:
        missions.add_webhook(args.webhook, os.environ.get("WOOSH_WEBHOOK_SECRET", ""))


def run_mission(args: Namespace, out: Output) -> None:
    from woosh_pure.missions.file import MissionFiles
    from woosh_pure.missions.missions import Missions

    if args.verb in _FILES:
        _FILES[args.verb](args, out, MissionFiles())
    elif args.verb in ("run", "resume"):
        with watchdog_of(args) as watchdog, connect(args, out, watchdog=watchdog) as chassis:
            _carry_out(args, out, chassis.missions)
    elif args.verb == "stop":
        with connect(args, out) as chassis, closing(Missions(chassis, carries=False)) as missions:
            out.line(str(missions.stop(by=BY)))
            _tell(missions, out)
    else:
        from woosh_pure.chassis import Chassis

        address, host = chosen(args)  # without a connection to the robot
        with closing(Missions(Chassis(address, host=host, robot_api=False), carries=False)) as missions:
            (_queue if args.verb == "queue" else _ask)(args, out, missions)


def _carry_out(args: Namespace, out: Output, missions: Missions) -> None:
    from woosh_pure.missions.missions import MissionHandle

    mission = missions.load(args.file) if args.verb == "run" else None
    use_webhook(missions, args)
    state = missions.state
    seen = state.notices[-1].number if state.notices else 0
    if mission is not None:
        handles = [missions.run(args.file, _given(args.set, mission), by=BY)]
    else:
        missions.resume(by=BY)
        under_way = [state.active.entry] if state.active else []
        handles = [MissionHandle(missions, entry.id) for entry in (*under_way, *state.queue)]
    for handle in handles:
        follow_mission(handle, missions, seen, out, alone=args.sim)


def follow_mission(
    handle: MissionHandle, missions: Missions, seen: int, out: Output, *, alone: bool = True
) -> None:
    """Print what happens until the mission ends. `alone`: no other terminal can answer its questions."""

    def over() -> bool:
        nonlocal seen
        run = handle.run  # before its notices, so that none is missed
        for notice in missions.state.notices:
            if notice.number > seen and notice.run == handle.id:
                _say(notice, out, alone)
            seen = max(seen, notice.number)
        return run is not None and run.phase.over

    missions.wait_for(over, None)
    handle.wait(0.0)


def _say(notice: Notice, out: Output, alone: bool) -> None:
    text = notice.text
    if notice.kind == "step":
        text = say("step {number}: {text}", number=notice.step + 1, text=notice.text)
    elif notice.kind == "question":
        how = "answer with `woosh mission answer ...`, one of: {names}"
        if alone:
            how = (
                "nobody can answer, as this command simulates the robot; use `woosh sim` in another terminal"
            )
        text = both(notice.text, say(how, names=notice.values["answers"]))
    elif notice.kind == "end":
        text = both(str(notice.values["phase"]), *([notice.text] if notice.text else []))
    out.line(f"{notice.mission}: {notice.kind}" if not text else led(notice.mission, text))
    out.record(asdict(notice))


def _given(texts: Sequence[str], mission: Mission) -> dict[str, object]:
    """The parameters of --set, each of the type of its default."""
    found: dict[str, object] = {}
    for text in texts:
        name, equals, value = text.partition("=")
        if not equals:
            raise ValueError(say("--set {text}: expected NAME=VALUE", text=text))
        default = mission.parameters.get(name)
        try:
            found[name] = value if default is None or isinstance(default, str) else json.loads(value)
        except ValueError:
            found[name] = value  # refused with what is expected
    return found


def _check(args: Namespace, out: Output, files: MissionFiles) -> None:
    mission = files.load(args.file)
    out.line("{name}: {count} steps, no fault", name=mission.name, count=len(mission.steps))
    out.result({"ok": True, "name": mission.name, "steps": len(mission.steps)})


def _list(args: Namespace, out: Output, files: MissionFiles) -> None:
    found = files.list()
    for each in found:
        name = each.error if each.mission is None else f"{each.mission.name}. {each.mission.description}"
        out.line(out.cell(each.file, 32), name)
    if not found:
        out.line("no missions in {folder}", folder=files.files)
    out.result([{"file": each.file, "error": each.error} for each in found])


def _show(args: Namespace, out: Output, files: MissionFiles) -> None:
    from woosh_pure.missions.file import text_of

    mission = files.load(args.file)
    out.answer(mission.data(), text_of(mission).rstrip())


_FILES: Mapping[str, Callable[[Namespace, Output, MissionFiles], None]] = {
    "check": _check, "list": _list, "show": _show,
}  # fmt: skip


def _queue(args: Namespace, out: Output, missions: Missions) -> None:
    if args.append:
        missions.append(args.append, _given(args.set, missions.load(args.append)), by=BY)
    elif args.remove:
        missions.unqueue(args.remove, by=BY)
    elif args.first:
        missions.reorder(args.first, 0, by=BY)
    elif args.clear:
        missions.clear(by=BY)
    state = missions.state
    for entry in state.queue:
        out.line(f"{entry.id}: {entry.mission.name}")
    if not state.queue:
        out.line("the queue is empty")
    elif state.paused:
        out.line("the queue is paused; `woosh mission resume` lets it go on")
    out.result({"paused": state.paused, "queue": [entry.to_json() for entry in state.queue]})


def _ask(args: Namespace, out: Output, missions: Missions) -> None:
    if args.verb == "pause":
        missions.pause(by=BY)
    elif args.verb == "answer":
        missions.answer(args.answer, by=BY)
    _tell(missions, out)


def _tell(missions: Missions, out: Output) -> None:
    """Print the run."""
    state = missions.state
    run = state.run
    if run is None:
        out.line("no mission has run yet")
    else:
        number, phase = min(run.at + 1, len(run.steps) or 1), say("paused" if run.paused else run.phase.value)
        name, count = run.entry.mission.name, len(run.steps)
        where = "{name}: {phase}, step {number} of {count}"
        out.line(where, name=name, phase=phase, number=number, count=count)
        if run.question is not None:
            asked = "{text} Answer with one of: {names}"
            out.line(asked, text=run.question.text, names=list(run.question.answers))
        for text in filter(None, (run.reason, state.disk)):
            out.line(text)
    told = {"run": run and run.to_json(), "queue": len(state.queue)}
    out.result({**told, "paused": state.paused, "disk": state.disk})
