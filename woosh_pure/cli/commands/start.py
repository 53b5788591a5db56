"""Commands to begin with: demo, connect, doctor, selftest, shell, completion."""

from __future__ import annotations

import json
import math
import platform
import socket
import sys
import time
from argparse import ArgumentParser, Namespace
from collections.abc import Callable, Mapping
from contextlib import ExitStack, closing
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any

import rosproto
from rosproto.cli import add_completion_arguments, answer_completion, seconds, unguarded
from rosproto.errors import ConnectionLost, RosError, RosTimeout
from rosproto.profile import Profile, forget, load, profile_file, save
from rosproto.sentence import both, say, sentence_of
from rosproto.version import __version__
from woosh_pure.cli.arguments import enum_words, robot_marks
from woosh_pure.cli.connection import address_of, connect, names, robot_api_of
from woosh_pure.cli.follow_goal import follow
from woosh_pure.cli.output import Output
from woosh_pure.enums import LedState
from woosh_pure.maps.marks import MarkFile, mark_file, with_robot_marks

if TYPE_CHECKING:
    from woosh_pure.doctor.checks import Finding


_DEMO_SPEED = 2.0


def add_demo(parser: ArgumentParser) -> None:
    parser.add_argument("--mark", default="A1", help="mark to drive to (default A1)")
    parser.add_argument(
        "--mission", action="store_true", help="carry a mission out instead: steps, a question"
    )


def run_demo(args: Namespace, out: Output) -> int:
    if args.master or args.chassis:
        raise ValueError("the demo drives only its own simulated chassis; omit --master and --chassis")
    args.sim = True
    began = time.monotonic()
    from woosh_pure.sim.site import built_in_site

    marks = built_in_site().marks
    if args.mark not in marks:
        wrong = "mark {mark!r} is not in the demo's hall; it has {names}"
        raise ValueError(say(wrong, mark=args.mark, names=", ".join(marks)))
    out.line("woosh demo: a simulated robot; nothing outside this computer moves")
    if args.mission:
        _demo_mission(args, out)
        return 0
    with connect(args, out, sim_speed=_DEMO_SPEED) as chassis:
        start = chassis.pose.wait()
        battery = say("the battery has {percent} %", percent=chassis.battery.wait().percent)
        out.line("it is at {pose}; {battery}", pose=start, battery=battery)

        follow(chassis.move(0.5, speed=0.3), out, "it moves 0.5 m forward", 20.0)
        chassis.measured_velocity.wait_for(lambda v: v.is_standing())
        moved = chassis.pose.wait()
        way = start.distance_to(moved)
        out.line(" ", say("asked for 0.500 m, measured {way:.3f} m", way=way))

        follow(chassis.rotate(90, degrees=True, speed=0.8), out, "it turns 90° to the left", 20.0)
        chassis.measured_velocity.wait_for(lambda v: v.is_standing())
        turned = chassis.pose.wait()
        angle = math.degrees(moved.angle_to(turned))
        out.line(" ", say("asked for 90.0°, measured {angle:.1f}°", angle=angle))

        target = marks[args.mark].pose
        handle = chassis.go_to_mark(args.mark)
        follow(handle, out, say("it drives to mark {mark}", mark=args.mark), 60.0)
        end = chassis.pose.wait()
        off, off_angle = end.distance_to(target), math.degrees(end.angle_to(target))
        out.line(
            " ",
            say(
                "arrived, {millimetres:.0f} mm and {degrees:.1f}° from the mark; driven {metres:.1f} m",
                millimetres=off * 1000,
                degrees=off_angle,
                metres=chassis.odometer.wait(),
            ),
        )
    good = abs(way - 0.5) < 0.05 and abs(angle - 90.0) < 5.0 and off < 0.1 and abs(off_angle) < 5.0
    seconds = time.monotonic() - began
    if good:
        out.line("done in {seconds:.0f} s: the software works on this computer", seconds=seconds)
        out.line("next, a simulated robot in your browser: {command}", command="woosh --sim web")
    else:
        out.line(
            "FAILED: what was measured is too far from what was asked, after {seconds:.1f} s", seconds=seconds
        )
    out.result(
        {
            "ok": good,
            "seconds": round(seconds, 2),
            "moved": {"asked_m": 0.5, "measured_m": round(way, 4)},
            "rotated": {"asked_degrees": 90.0, "measured_degrees": round(angle, 2)},
            "mark": {"name": args.mark, "off_m": round(off, 4), "off_degrees": round(off_angle, 2)},
        }
    )
    return 0 if good else 1


def _demo_mission(args: Namespace, out: Output) -> None:
    from woosh_pure.cli.commands.mission import follow_mission
    from woosh_pure.missions import mission_of

    answers = {"yes": "next", "no": "end"}
    ask = {"do": "ask", "text": "Go on to the mark?", "answers": answers, "timeout": 2, "default": "yes"}
    steps = [{"do": "move", "metres": 0.5}, ask, {"do": "go_to_mark", "mark": args.mark}]
    with connect(args, out, sim_speed=_DEMO_SPEED) as chassis:
        demo = mission_of({"mission": 1, "name": "demo", "step": steps})
        follow_mission(chassis.missions.run(demo, by="woosh demo"), chassis.missions, 0, out)


def add_connect(parser: ArgumentParser) -> None:
    parser.add_argument("address", nargs="?", metavar="HOST", help="host or master URI, e.g. 169.254.128.2")
    parser.add_argument("--show", action="store_true", help="show the saved address")
    parser.add_argument("--forget", action="store_true", help="remove the saved address")
    parser.add_argument("--unchecked", action="store_true", help="save it without connecting first")


def run_connect(args: Namespace, out: Output) -> int:
    address = args.address or args.master or args.chassis
    if sum((bool(address), args.show, args.forget)) != 1:
        raise ValueError("give the address of a chassis, or --show, or --forget")
    if args.sim:
        raise ValueError("--sim needs no `woosh connect`: use it with any other command")
    if args.show:
        return _show_profile(out)
    if args.forget:
        _forget_profile(out)
    else:
        _save_profile(address, args, out)
    return 0


def _save_profile(address: str, args: Namespace, out: Output) -> None:
    from woosh_pure.connection.arguments import master_uri_of

    uri = master_uri_of(address)
    if not args.unchecked:
        _require_master(uri, args, out)
    path = save(Profile(address, args.host))
    out.line("{uri} is now the default chassis (in {path})", uri=uri, path=path)
    out.result({"chassis": address, "master_uri": uri, "host": args.host, "file": str(path)})


def _require_master(uri: str, args: Namespace, out: Output) -> None:
    from rosproto import MasterClient
    from rosproto.transport import HostNames
    from woosh_pure.robot_api.api import robot_api_at

    try:
        hosts = HostNames(names(args))
        with out.working(say("looking for {uri}", uri=uri)):
            if uri.startswith("ws://"):
                with closing(robot_api_at(robot_api_of(args), uri, names(args))) as api:
                    api.request("RobotState")
                return
            with MasterClient(uri, "/woosh_connect", timeout=5.0, hosts=hosts) as master:
                master.get_pid()
    except (ConnectionLost, RosTimeout) as error:
        not_saved = say("nothing was saved: try `woosh doctor`, or add --unchecked")
        why = both(error.why, not_saved) if error.why else ""
        raise ConnectionLost(both(sentence_of(error), not_saved), peer=error.peer, why=why) from error


def _show_profile(out: Output) -> int:
    profile = load()
    if profile is None:
        out.line("no chassis is saved; `woosh connect HOST` saves one")
    else:
        shown = "{chassis}, our address {host} (in {path})" if profile.host else "{chassis} (in {path})"
        out.line(shown, chassis=profile.chassis, host=profile.host, path=profile_file())
    out.result(
        {
            "chassis": profile.chassis if profile else None,
            "host": profile.host if profile else None,
            "file": str(profile_file()),
        }
    )
    return 0 if profile else 1


def _forget_profile(out: Output) -> None:
    known = forget()
    out.line("forgotten" if known else "no chassis was saved")
    out.result({"forgotten": known})


def add_doctor(parser: ArgumentParser) -> None:
    parser.add_argument(
        "--listen", type=seconds, default=3.0, metavar="S", help="seconds to listen (default 3)"
    )
    parser.add_argument(
        "--report",
        type=Path,
        metavar="FILE",
        help="write it to a file, too, with versions and the graph, without addresses, hosts and folders",
    )


def run_doctor(args: Namespace, out: Output) -> int:
    from woosh_pure.connection.arguments import master_uri_of
    from woosh_pure.doctor.checks import Level
    from woosh_pure.doctor.examination import examine

    if args.report is not None and args.report.exists():
        raise ValueError(say("{path} already exists: give another name", path=args.report))
    with ExitStack() as stack:
        address, host = address_of(args, out, stack)
        findings = []
        found = examine(
            master_uri_of(address),
            host=host,
            listen=args.listen,
            resolve=names(args),
            robot_api=robot_api_of(args),
        )
        for finding in found:
            findings.append(finding)
            out.line(out.cell(finding.level.value, 8), finding.text)
            if finding.advice:
                out.line(out.cell("", 8), "->", finding.advice)
        if args.report is not None:
            _write_report(args.report, master_uri_of(address), names(args), findings)
    bad = sum(f.level is Level.PROBLEM for f in findings)
    if bad:
        out.line(say("{count} problem", count=bad) if bad == 1 else say("{count} problems", count=bad))
    else:
        out.line("no problem was found")
    if args.report is not None:
        out.line("the report is in {path}: look through it before you send it", path=args.report)
    out.result({"ok": bad == 0, "findings": [finding.document() for finding in findings]})
    return 1 if bad else 0


def _write_report(path: Path, uri: str, resolve: Mapping[str, str], findings: list[Finding]) -> None:
    """Write the JSON report of `woosh_pure.doctor.report`."""
    from rosproto.transport import HostNames
    from woosh_pure.doctor.report import Redaction, report

    state, types = None, {}
    try:
        with rosproto.MasterClient(uri, "/woosh_doctor", timeout=3.0, hosts=HostNames(resolve)) as client:
            state, types = client.get_system_state(), client.get_topic_types()
    except RosError:
        pass  # the findings have the reason
    system = {
        "woosh-pure": __version__,
        "python": sys.version,
        "system": platform.platform(),
        "numpy": metadata.version("numpy"),
        "lz4": metadata.version("lz4"),
    }
    redact = Redaction([socket.gethostname(), *resolve], str(Path.home()))
    document = report(findings, state, types, system, redact)
    path.write_text(json.dumps(document, indent=1, ensure_ascii=False) + "\n", "utf-8")


def add_selftest(parser: ArgumentParser) -> None:
    parser.add_argument(
        "--no-ros", action="store_true", help="do not look for a real ROS on this machine, and start nothing"
    )


def run_selftest(args: Namespace, out: Output) -> int:
    if args.master or args.chassis:
        raise ValueError("the self-test is about this machine alone; for a chassis: woosh doctor")
    from rosproto.selftest import State, run
    from woosh_pure.selftest import CHECKS

    began = time.monotonic()
    outcomes = []
    for outcome in run(check for check in CHECKS if not (args.no_ros and check.name == "ros")):
        outcomes.append(outcome)
        mark = {State.FINE: "green", State.FAILED: "red", State.NOT_HERE: "dim"}[outcome.state]
        word, name = out.colour(outcome.state.value, mark, 9), out.cell(outcome.name, 13)
        out.line(word, name, f"{outcome.seconds:5.2f} s ", outcome.text)
    failed = [outcome.name for outcome in outcomes if outcome.state is State.FAILED]
    seconds = time.monotonic() - began
    if failed:
        out.line(
            "this machine is not fine: {names} failed ({seconds:.1f} s)",
            names=", ".join(failed),
            seconds=seconds,
        )
    else:
        out.line("this machine is fine ({seconds:.1f} s)", seconds=seconds)
    out.result(
        {
            "ok": not failed,
            "seconds": round(seconds, 2),
            "checks": [
                {
                    "name": o.name,
                    "state": o.state.value.lower(),
                    "seconds": round(o.seconds, 3),
                    "text": o.text,
                }
                for o in outcomes
            ],
        }
    )
    return 1 if failed else 0


_TRY = "Try: chassis.battery.wait()   chassis.readiness()   chassis.move(0.3).wait()   chassis.stop()"


def add_shell(parser: ArgumentParser) -> None:
    parser.add_argument("-c", dest="code", metavar="CODE", help="run this instead of asking for input")


def run_shell(args: Namespace, out: Output) -> int:
    if args.json:
        raise ValueError("--json: the shell prints what you print; use json.dumps inside")
    with connect(args, out) as chassis:
        names = _names(chassis)
        try:
            with unguarded():
                if args.code is not None:
                    _execute(args.code, names)
                else:
                    banner = (
                        say("Python with `chassis` ready, connected to {uri}.", uri=chassis.master_uri),
                        _TRY,
                        "Leaving (Ctrl-D, Ctrl-Z Enter on Windows) cancels what is still running.",
                    )
                    _interact(names, "\n".join(map(out.say, banner)))
        except SystemExit as leaving:
            return _exit_code(leaving.code)
    return 0


def _exit_code(code: object) -> int:
    """Return the exit code as Python does: None is 0, a text is printed and gives 1."""
    if code is None or isinstance(code, int):
        return int(code or 0)
    print(code, file=sys.stderr)
    return 1


def _execute(text: str, names: dict[str, object]) -> None:
    try:
        exec(compile(text, "<woosh shell>", "exec"), names)
    except (RosError, OSError):
        raise
    except Exception as error:
        raise RosError(say("your code: {name}: {error}", name=type(error).__name__, error=error)) from error


def _names(chassis: Any) -> dict[str, object]:
    import woosh_pure
    from woosh_pure import enums

    names = {name: getattr(woosh_pure, name) for name in woosh_pure.__all__}
    names.update({name: getattr(enums, name) for name in enums.__all__})
    return {**names, "chassis": chassis, "math": math, "__name__": "__console__"}


def _interact(names: dict[str, object], banner: str) -> None:
    import code

    if sys.platform != "win32":  # Windows' console has line editing of its own
        try:
            import readline
            import rlcompleter

            readline.set_completer(rlcompleter.Completer(names).complete)
            readline.parse_and_bind("tab: complete")
        except ImportError:
            pass  # a Python built without it
    code.interact(banner=banner, local=names, exitmsg="")


def add_completion(parser: ArgumentParser) -> None:
    add_completion_arguments(parser)


def run_completion(args: Namespace, out: Output) -> int:
    from woosh_pure.cli.entry import parser_for
    from woosh_pure.enums import COLOURS

    values: dict[str, Callable[[], list[str]]] = {
        "mark": lambda: sorted(
            mark.name for mark in with_robot_marks(MarkFile(mark_file()), robot_marks(args, timeout=0.7))
        ),
        "state": lambda: enum_words(LedState),
        "color": lambda: list(COLOURS),
    }
    return answer_completion("woosh", args, parser_for, values)
