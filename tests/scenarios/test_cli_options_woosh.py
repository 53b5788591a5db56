"""Every command, option and choice of `woosh`, run for real on one simulated chassis; what is left out is named.

What the commands mean in depth is in test_cli_verbs.py; here each option must show an effect.
"""

from __future__ import annotations

import inspect
import json
import math
import sys
import time
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from types import SimpleNamespace

import pytest

from tests.support.options import (
    Case,
    Result,
    covered,
    every_pair,
    leaves,
    offers_json,
    path_of,
    run,
    run_until,
)
from tests.support.png import read_png
from woosh_pure import SimulatedChassis
from woosh_pure.enums import NavDirection, NavigationMode
from woosh_pure.geometry import Pose2D, Velocity
from woosh_pure.maps.gridmap import GridMap
from woosh_pure.sim.site import built_in_site

pytestmark = pytest.mark.whole


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Iterator[SimpleNamespace]:
    """A fast simulated chassis that can go sideways, and a folder with files."""
    from woosh_pure.sim import Settings
    from woosh_pure.sim.body import BodyLimits

    folder = tmp_path_factory.mktemp("woosh")
    built_in_site().grid.save(folder / "hall.yaml")
    steps = '[guards]\nnot_known = "go"\n[[step]]\ndo = "move"\nmetres = "$way"\n'
    (folder / "m.mission.toml").write_text(f'mission = 1\nname = "m"\n[parameters]\nway = 0.1\n{steps}')
    (folder / "marks.json").write_text('{"M": {"x": 2.0, "y": 0.5, "yaw": 1.5}}')
    settings = Settings(limits=BodyLimits(omnidirectional=True))
    with SimulatedChassis(speed=10.0, full_graph=False, settings=settings) as sim:
        yield SimpleNamespace(sim=sim, folder=folder, uri=sim.master_uri)


@pytest.fixture(autouse=True)
def private(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """No test reads or writes what the user has saved, or a master of the environment."""
    monkeypatch.setenv("WOOSH_CONFIG_DIR", str(tmp_path / "config"))
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    monkeypatch.delenv("ROS_MASTER_URI", raising=False)
    monkeypatch.chdir(tmp_path)


def has(*parts: str):
    """All of these are in the output."""
    return lambda result: all(part in result.out for part in parts)


def doc(check):
    """The output is one JSON document that passes."""
    return lambda result: check(result.document)


def refused(*parts: str):
    """All of these are in the sentence on stderr."""
    return lambda result: all(part in result.err for part in parts)


def picture(name: str, depth: int = 3):
    """The file is a PNG of some size."""
    return lambda result, place: read_png((place.folder / name).read_bytes()).size > 1000


def navigation(**wanted: object):
    """What the simulated navigation was told."""

    def check(result: Result, place: SimpleNamespace) -> bool:
        with place.sim.lock:
            told = place.sim.world.navigation
            return all(getattr(told, name) == value for name, value in wanted.items())

    return check


def near(place: SimpleNamespace, x: float, y: float, degrees: float) -> bool:
    there = Pose2D(x, y, math.radians(degrees))
    return place.sim.pose.distance_to(there) < 0.1 and abs(place.sim.pose.angle_to(there)) < 0.1


READING = [
    Case("status --wait 0.5", has("battery", "ready")),
    Case("status --wait 0.5 --json", doc(lambda d: d["ready"] is True)),
    Case("ready --listen 2", has("ready: ")),
    Case("ready --wait 5 --json", doc(lambda d: d["ready"] is True)),
    Case("battery --wait 3", has("battery ", "voltage ")),
    Case("battery --below 100", code=1),
    Case("battery --below 5 --json", doc(lambda d: d["percent"] > 5)),
    Case("faults --listen 0.5", has("none")),
    Case("faults 7", has("task_state completed")),
    Case("faults --code 110201000013 --json", doc(lambda d: d[0]["level"] == "SEVERE")),
    Case("faults --find emergency", has("110201000013")),
    Case("faults --code 110201000013 --chinese", has("急停")),
    Case("imu --wait 3", has("rates ", "yaw ")),
    Case("imu --count 2 --json", lambda r: [json.loads(line)["frame"] for line in r.out.splitlines()] == ["imu"] * 2),
    Case("scan --wait 3 --png {folder}/scan.png", picture("scan.png")),
    Case("scan --png {folder}/map.png --map --json", doc(lambda d: d["file"].endswith("map.png"))),
    Case("camera --wait 3 --png {folder}/color.png", picture("color.png")),
    Case("camera -o {folder}/o.png", picture("o.png")),
    Case("scan --width 0.5 --json", doc(lambda d: d["lane_width"] == 0.5 and d["nearest_distance"] > 0)),
    Case("camera --depth --millimetres --png {folder}/mm.png", picture("mm.png", 1)),
    Case("camera --no-file --depth --json", doc(lambda d: d["encoding"] == "16UC1" and d["nearest"] > 0)),
    Case("cloud --wait 3 --ply {folder}/c.ply", lambda r, p: (p.folder / "c.ply").read_bytes().startswith(b"ply\n")),
    Case("cloud --obstacles --json", doc(lambda d: d["points"] > 0)),
    Case("watch --for 0.5 --rate 10 --lines", has(" in map  ")),
    Case("watch --for 0.5 --rate 5 --no-map --ascii --json", lambda r: json.loads(r.out.splitlines()[-1])["pose"] is not None),
    Case("doctor --listen 0.5 --json", doc(lambda d: d["findings"][0]["level"] == "ok")),
    Case("doctor --listen 0.5 --report {folder}/report.json", has("the report is in ")),
    Case("learn --dry-run --all --timeout 20 --parallel 2", has("as bundled")),
    Case("learn --folder {folder}/learned --json", doc(lambda d: d["folder"].endswith("learned") and d["findings"])),
]  # fmt: skip
MOVING = [
    Case("goto P1 --timeout 60", has("arrived")),
    Case("goto --pose 1 0.5 90 --json", lambda r, p: near(p, 1.0, 0.5, 90.0) and r.document["ok"]),
    Case("move 0.3 --speed 0.4", lambda r, p: near(p, 0.3, 0.0, 0.0)),
    Case("move 0.3 --left --json", lambda r, p: near(p, 0.0, 0.3, 0.0) and r.document["outcome"] == "arrived"),
    Case("move -0.2 --no-avoid", lambda r, p: near(p, -0.2, 0.0, 0.0) and not p.avoiding),
    Case("rotate 45 --speed 60", lambda r, p: near(p, 0.0, 0.0, 45.0)),
    Case("rotate -30 --no-avoid --json", lambda r, p: near(p, 0.0, 0.0, -30.0) and not p.avoiding),
    *(Case(f"task {kind} {{mark}} --timeout 60 --type-number 4 --custom 3{more} --json", doc(lambda d: d["ok"] and d["task_id"]))
      for kind, more in (("pick", ""), ("park", ""), ("charge", ""), ("carry", " --load"))),
    *(Case(f"task {kind}{more} --pose 0.5 0 0 --pose 1 0.4 0", lambda r, p: near(p, 1.0, 0.4, 0.0))
      for kind, more in (("pick", ""), ("park", ""), ("carry", " --unload"))),
    Case("task charge C1 --pose 99 99 0", lambda r: "does not end at mark 'C1'" in r.err, code=3),
    *(Case(f"task {verb} --id 99999", has("REFUSED"), code=3) for verb in ("pause", "resume", "cancel", "interrupt-wait")),
    *(Case(f"task {verb} --id 99999 --json", doc(lambda d: d["ok"] is False), code=3)
      for verb in ("pause", "resume", "cancel", "interrupt-wait")),
    Case("charge C1 --timeout 60", has("charging")),
    Case("charge C1 --json", doc(lambda d: d["battery"]["charge_status"] == "CHARGING")),
    Case("mission check {folder}/m.mission.toml --json", doc(lambda d: d["ok"] and d["steps"] == 1)),
    Case("mission list", has("no missions in ")),
    Case("mission list --json", doc(lambda d: d == [])),
    Case("mission show {folder}/m.mission.toml --json", doc(lambda d: d["parameters"] == {"way": 0.1})),
    Case("mission run {folder}/m.mission.toml --json", lambda r, p: '"phase": "done"' in r.out.splitlines()[-1]),
    Case("mission show {folder}/m.mission.toml", has('name = "m"', "[[step]]")),
    Case("mission run {folder}/m.mission.toml --set way=0.3 --no-watchdog", lambda r, p: "done" in r.out and near(p, 0.3, 0.0, 0.0)),
    Case("mission run {folder}/m.mission.toml --webhook http://127.0.0.1:9/", refused("WOOSH_WEBHOOK_SECRET"), code=2),
    Case("mission queue --append {folder}/m.mission.toml --set way=0.1 --json", doc(lambda d: d["paused"] and d["queue"])),
    Case("mission queue --remove 999", refused("no mission 999"), code=3),
    Case("mission queue --first 999", refused("no mission 999"), code=3),
    Case("mission queue --clear", has("the queue is empty")),
    Case("mission pause"),
    Case("mission pause --json", doc(lambda d: d["paused"])),
    Case("mission resume --no-watchdog"),
    Case("mission resume --json"),
    Case("mission resume --webhook http://127.0.0.1:9/", refused("WOOSH_WEBHOOK_SECRET"), code=2),
    Case("mission stop", has("stands still")),
    Case("mission stop --json", doc(lambda d: d["paused"])),
    Case("mission answer yes", refused("there is no question"), code=3),
    Case("mission answer yes --json", doc(lambda d: "there is no question" in d["error"]), code=3),
    Case("mission status --json", doc(lambda d: d["disk"] == "")),
    Case("stop --timeout 3", has("stands still")),
    Case("stop --json", doc(lambda d: d["standing"] is True)),
    Case("stop --end-drivers --json", doc(lambda d: d["standing"] is True)),
]  # fmt: skip
TELLING = [
    Case("localization show --wait 3", has("1 sigma")),
    Case("localization show --json", doc(lambda d: len(d["deviation"]) == 3)),
    Case("localization start", has("localisation: start")),
    Case("localization start --json", doc(lambda d: d["done"] == "start")),
    Case("localization stop", has("localisation: stop")),
    Case("localization stop --json", doc(lambda d: d["done"] == "stop")),
    Case("localization pose 0.1 0 5 --deviation 0.1 --yaw-deviation 4 --wait 5 --json", doc(lambda d: d["told"]["x"] == 0.1)),
    Case("map show --json", doc(lambda d: d["width"] == 240)),
    Case("map save {folder}/out --listen 1", lambda r, p: GridMap.load(p.folder / "out.yaml").width == 240 and picture("out.png")(r, p)),
    Case("map save {folder}/bare --no-png --json", lambda r, p: len(r.document["files"]) == 2 and not (p.folder / "bare.png").exists()),
    Case("map set {folder}/hall.yaml --pose 0 0 0", has("the chassis accepted it")),
    Case("map set {folder}/hall.yaml --json", doc(lambda d: d["height"] == 160)),
    Case("plan 1 0 0 --start -0.5 0 0 --tolerance 0.1 --png {folder}/plan.png", picture("plan.png")),
    Case("plan 1 0 0 --json", doc(lambda d: d["ok"] and d["length"] > 0.9)),
    *(Case(f"costmap {what} --json", doc(lambda d, what=what: d["done"] == what)) for what in ("off", "clear", "on")),
    Case("footprint --rectangle 0.8 0.6 --padding 0.05 --json", doc(lambda d: d["points"][0] == [0.45, 0.35])),
    Case("footprint --circle 0.4 --local", has("corners")),
    Case("footprint --points 0.4,0.3,0.1", refused("corner '0.4,0.3,0.1'"), code=2),
    Case("footprint --points '0.4,0.3 -0.4,0.3 -0.4,-0.3 0.4,-0.3' --global --json", doc(lambda d: d["local"] is False)),
    Case("mode fuzzy-avoidance --max-speed 0.4 --timeout 5", navigation(mode=NavigationMode.FUZZY_AVOIDANCE)),
    Case("mode precise-avoidance --passage 3 --permitted --capacity 2 --json", navigation(mode=NavigationMode.PRECISE_AVOIDANCE)),
    Case("mode stop-and-wait", navigation(mode=NavigationMode.STOP_AND_WAIT)),
    Case("mode wait-then-avoid --waiting-timeout 3", navigation(mode=NavigationMode.WAIT_THEN_AVOID, waiting_timeout=3.0)),
    *(Case(f"mode fuzzy-avoidance --direction {name.lower().replace('_', '-')}", has("navigation mode")) for name in NavDirection.__members__),
    Case("marks --file {folder}/m.json add X1 --pose 1 2 90 --note shelf", lambda r, p: "shelf" in (p.folder / "m.json").read_text()),
    Case("marks add mine --pose 1 0 0", has("mine: ")),
    Case("marks add B1 --on-chassis --pose 1 0 0 --json", doc(lambda d: d[0]["on_chassis"])),
    Case("marks add NAME --no-pose --json", doc(lambda d: d[0]["pose"] is None)),
    Case("marks add HERE --wait 3", has("x 0.0")),
    Case("marks add HERE --here --wait 3 --json", doc(lambda d: d[0]["pose"]["x"] == pytest.approx(0.0, abs=0.05))),
    Case("marks list", has("A1", "W1")),
    Case("marks list --json", doc(lambda d: {mark["name"] for mark in d} >= {"A1", "W1"})),
    Case("marks remove X9 --json", doc(lambda d: d["ok"] is False), code=1),
    Case("api", has("woosh.robot.Battery", "woosh.map.SceneList")),
    Case('api SceneData {{\\"name\\":\\"hall\\"}} --timeout 1 --api-address 127.0.0.1:1 --json', doc(lambda d: d["exit_code"] == 4), code=4),
    Case("led idle --strip base --module 2 --urgency", has("base strip: idle")),
    Case("led warning --color ff8000 --strip shelf --abnormal --json", doc(lambda d: d["color"] == 0xFF8000)),
    Case("led red --json", doc(lambda d: (d["state"], d["color"]) == ("none", 0xFF0000))),
    Case("led none --strip both", has("both strip: none")),
    Case("led --list --json", doc(lambda d: len(d) > 15)),
    Case("say mind your feet", has("said: mind your feet")),
    Case("say hello --json", doc(lambda d: d["said"] == "hello")),
    Case("shell", has("3"), more=("-c", "print(1 + 2)")),
    *(Case(f"completion {shell}", has("woosh completion _words")) for shell in ("bash", "zsh", "fish", "powershell")),
]  # fmt: skip
RECORDING = [
    Case("record /battery --duration 2 --output-name {folder}/a.bag --force --lz4 --quiet --json", doc(lambda d: d)),
    Case("record /scan --limit 2 --duration 2 --output-prefix {folder}/b --bz2", lambda r, p: list(p.folder.glob("b*.bag"))),
    Case("record --all --exclude '/rosout|/tf.*' --duration 2 -O {folder}/c.bag --uncompressed --buffsize 16 --chunksize 64",
         lambda r, p: (p.folder / "c.bag").stat().st_size > 10_000),
    Case("record --camera --duration 2 --size 50 --publish --repeat-latched --min-space 1 -O {folder}/d.bag", lambda r, p: (p.folder / "d.bag").exists()),
    Case("record /battery --duration 1 --format bag -O {folder}/f.bag", lambda r, p: (p.folder / "f.bag").exists()),
    Case("record /battery --duration 1 --format mcap -O {folder}/g.mcap",
         lambda r, p: ".[mcap]" in r.err or (p.folder / "g.mcap").exists(),
         code=int(find_spec("mcap") is None)),
    Case("record /scan --split --duration 1 --max-splits 2 --no-repeat-latched -O {folder}/e.bag",
         lambda r, p: list(p.folder.glob("e*.bag"))),
]  # fmt: skip
ALONE = [
    Case("demo --mission", has("Go on to the mark?", "nobody can answer", "demo: done")),
    Case("demo --mark Z9 --json", doc(lambda d: "A1, A2, B1" in d["error"]), code=2),
    Case("connect {host} --unchecked --host 127.0.0.1 --json", doc(lambda d: d["host"] == "127.0.0.1")),
    Case("connect --show --json", doc(lambda d: d["chassis"] is None), code=1),
    Case("connect --forget", has("no chassis was saved")),
    Case("selftest --no-ros --json", doc(lambda d: d["ok"] and len(d["checks"]) == 7)),
    Case("sim --port 0 --bind 127.0.0.1 --speed 5 --seed 3 --map {folder}/hall.yaml --omni --lost --for 0.2 --json",
         doc(lambda d: "A1" in d["marks"] and "N" not in d["marks"])),
    Case("sim --port 0 --mark N=1,0.5,90 --marks {folder}/marks.json --for 0 --json",
         doc(lambda d: {"A1", "N", "M"} <= set(d["marks"]))),
    Case("sim --port 0 --robot-api 0 --for 0 --json",
         lambda r, p: "ws://127.0.0.1:" in r.out or ".[api]" in r.err, code=int(find_spec("websockets") is None)),
    Case("sim --port 0 --firmware 1.1.0 --status-on-change --status-code-once --stops-on-silence --at 0=estop --for 0.3",
         has("those of firmware 1.1.0", "now: estop")),
]  # fmt: skip
DRIVE = (
    "--linear 0.15 --angular 20 --direct --feedback-timeout 2 --share --acknowledged --no-watchdog"
).split()
TABLE = [*READING, *MOVING, *TELLING, *RECORDING]
ALL = [*TABLE, *ALONE]
NEEDS_A_TERMINAL = {"woosh drive"}
SERVERS = ("woosh web", "woosh foxglove", "woosh robot-api", "woosh vda5050", "woosh run", "woosh mcp")
"""In test_web_command.py and test_web_dead_man.py, tests/unit/cli/test_foxglove_command.py, test_robot_api_commands.py,
tests/interop/fleet, test_mcp_hosts.py;
`run`, which loads the layer for ROS's programs into its process, in test_sim_options.py."""
OF_THE_PAGE = {("woosh sim", option) for option in ("--robots", "--page-port", "--token", "--token-file")}
"""They need the extra `web`; in test_web_command.py."""


def run_case(case: Case, words: list[str], place: SimpleNamespace) -> None:
    """From a known place: exit code, no traceback, and what the case demands."""
    sim = place.sim
    with sim.lock:
        sim.world.body.pose = Pose2D(0.0, 0.0, 0.0)
        sim.world.body.velocity = Velocity(0.0, 0.0, 0.0)
        sim.world.localization.running = True
        assert sim.world.initial_pose(Pose2D(0.0, 0.0, 0.0))
    if "--split" in words:  # goes on until somebody ends it
        result = run_until(lambda _: (place.folder / "e_1.bag").exists(), "woosh", words)
    else:
        result = run("woosh", words, case.stdin)
    shown = f"{' '.join(words)}\n{result.out}\n{result.err}"
    assert result.code == case.code, shown
    assert "Traceback" not in result.err, shown
    wanted = [p for p in inspect.signature(case.check).parameters.values() if p.default is p.empty]
    assert case.check(*[result, place][: len(wanted)]), shown


def words_of(case: Case, place: SimpleNamespace, *common: str) -> list[str]:
    mark = next((m for kind, m in (("charge", "C1"), ("park", "P1")) if f"task {kind}" in case.line), "A1")
    words = case.words(folder=place.folder, mark=mark, host="127.0.0.1:1")
    return [words[0], *common, *words[1:]]


@pytest.fixture
def watched(place: SimpleNamespace, monkeypatch: pytest.MonkeyPatch) -> SimpleNamespace:
    """`avoiding`: whether the last step was told to avoid obstacles."""
    plain = place.sim.world.step_control

    def step_control(steps, *, avoid):
        place.avoiding = avoid
        return plain(steps, avoid=avoid)

    monkeypatch.setattr(place.sim.world, "step_control", step_control)
    return place


@pytest.mark.parametrize("case", TABLE, ids=lambda case: case.line)
def test_command(case: Case, watched: SimpleNamespace) -> None:
    """It does what it says."""
    run_case(case, words_of(case, watched, "--master", watched.uri), watched)


@pytest.mark.parametrize(
    "case",
    [pytest.param(case, marks=pytest.mark.slow if case.line == "demo --mission" else ()) for case in ALONE],
    ids=lambda case: case.line,
)
def test_command_without_a_chassis(case: Case, place: SimpleNamespace) -> None:
    """Those that choose a chassis, or are one."""
    run_case(case, words_of(case, place), place)


FIRST = {
    path_of("woosh", case.words(folder="x", mark="A1", host="x")): case
    for case in reversed(TABLE)
    if case.code in (0, 3) and not case.line.startswith("mission answer")
}
"""One case of each command, without those that --debug lets raise what they refuse."""


@pytest.mark.parametrize("path", FIRST)
def test_what_every_command_takes(path: str, watched: SimpleNamespace) -> None:
    """--chassis, --host, --api-address off, --msg-path, --no-learned, --lang en, --debug change nothing of what it does."""
    (watched.folder / "pkg" / "msg").mkdir(parents=True, exist_ok=True)
    (watched.folder / "pkg" / "msg" / "Depth.msg").write_text("float64 depth\n")
    common = ["--chassis", watched.uri.removeprefix("http://").rstrip("/"), "--host", "127.0.0.1"]
    common += ["--msg-path", str(watched.folder / "pkg"), "--no-learned", "--debug", "--lang", "en"]
    common += ["--api-address", "off"]
    run_case(FIRST[path], words_of(FIRST[path], watched, *common), watched)


@pytest.mark.parametrize("line", ["move 0.1", "doctor --listen 0.2", "learn --dry-run"])
def test_sim_starts_one_for_the_command(line: str) -> None:
    """--sim and --sim-speed, in front of the command and behind it; doctor, learn and record do it in their own way."""
    result = run("woosh", ["--sim", *line.split(), "--sim-speed", "10"])
    assert result.code in (0, 1 if "doctor" in line else 0), result
    assert "a new simulated robot" in result.out
    assert "http://127.0.0.1:" in result.out


def test_no_command_and_no_option_is_left_out() -> None:
    """Every command, and every pair of one and an option, choice or optional argument, is in this file."""
    used = covered("woosh", ["drive", *DRIVE])
    paths = set(NEEDS_A_TERMINAL)
    for case in ALL:
        words = case.words(folder=".", mark="A1", host="x")
        used |= covered("woosh", words)
        paths.add(path_of("woosh", words))
    assert sorted(pair for pair in every_pair("woosh") - used - OF_THE_PAGE if pair[0] not in SERVERS) == []
    assert sorted(set(leaves("woosh")) - paths - set(SERVERS)) == []


def test_json_is_tested_wherever_it_is_offered() -> None:
    """Each command has a case that reads its JSON, or refuses to have any."""
    tested = {path_of("woosh", c.words(folder="x", mark="A1", host="x")) for c in ALL if "--json" in c.line}
    without = {"woosh drive", "woosh shell", "woosh completion", *SERVERS}
    assert sorted(offers_json("woosh") - tested - without) == []
    for name in ("drive", "shell"):
        assert run("woosh", [name, "--json"]).code == 2


@pytest.mark.skipif(sys.platform == "win32", reason="needs a pseudo-terminal")
def test_drive_with_every_option(place: SimpleNamespace, monkeypatch: pytest.MonkeyPatch) -> None:
    """It drives as fast as it was told, and no faster."""
    from tests.support.terminal import Terminal

    told: list[float] = []
    command = place.sim.world.command_velocity

    def command_velocity(velocity: Velocity, *, smooth: bool) -> None:
        told.append(velocity.vx)
        command(velocity, smooth=smooth)

    monkeypatch.setattr(place.sim.world, "command_velocity", command_velocity)
    with place.sim.lock:
        place.sim.world.body.pose = Pose2D(0.0, 0.0, 0.0)
    with Terminal("drive", "--master", place.uri, *DRIVE, columns=120) as terminal:
        terminal.wait_for("sent +0.00")
        terminal.send("+w+w+w")  # a change of the speed stops
        end = time.monotonic() + 30.0
        while sum(vx >= 0.15 - 1e-6 for vx in told) < 5:
            assert time.monotonic() < end, terminal.text
            terminal.send("w")
            time.sleep(0.05)
        terminal.send("q")
        assert terminal.exit_code() == 0
    assert max(told) <= 0.15 + 1e-6
