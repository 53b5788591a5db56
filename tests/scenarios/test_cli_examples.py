"""Every example that a `--help` shows, and every line of the pages that needs no robot or runs a program, is run as it
stands there, on a simulated chassis: each does what it promises.

Only addresses are put in (a chassis at 169.254.128.2 is on nobody's test machine) and ports that may be taken.
"""

from __future__ import annotations

import contextlib
import re
import shlex
import threading
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

import rosproto
from rosproto.bag import BagWriter
from rosproto.cli.entry import EXAMPLES as ROSPROTO
from tests.support.extras import needs
from tests.support.options import run, run_apart, run_until
from tests.support.robot_api_peer import ApiPeer
from tests.support.robot_pool import Robot
from tests.support.tunable import Tunable
from tests.test_documentation import commands
from woosh_pure import Chassis, SimulatedChassis
from woosh_pure.cli.entry import EXAMPLES as WOOSH
from woosh_pure.geometry import Pose2D
from woosh_pure.maps.marks import MarkFile
from woosh_pure.sim.site import built_in_site


@dataclass(frozen=True)
class Way:
    """What an example needs and shows, where that is not simply exit code 0.

    Attributes:
        until: It goes on until Ctrl-C; this is on stdout or stderr by then ("received": the message).
        shows: Is on stdout at the end.
        writes: Files that it leaves.
        more: Words put behind it: ports of its own.
        stdin: What is typed.
        code: Exit code.
        first: What is done before, by other commands.
        during: "task": one is started while the command listens.
        lasts: Seconds that it goes on for, after `until`.
    """

    until: str = ""
    shows: str = ""
    writes: tuple[str, ...] = ()
    more: tuple[str, ...] = ()
    stdin: str = ""
    code: int = 0
    first: tuple[str, ...] = ()
    during: str = ""
    lasts: float = 0.0


WAYS: dict[str, Way] = {
    "woosh sim --speed 4": Way(until="woosh", more=("--port", "0"), code=130),
    "woosh sim --port 0 --at 10=estop --at 20=release": Way(until="woosh", code=130),
    "woosh connect --show": Way(first=("woosh connect 169.254.128.2",), shows="127.0.0.1"),
    "woosh scan --png scan.png": Way(shows="ahead", writes=("scan.png",)),
    "woosh camera": Way(writes=("camera-*.png",)),
    "woosh camera --depth --png depth.png": Way(writes=("depth.png",)),
    "woosh ready --wait 120": Way(shows="ready", during="task"),
    "woosh faults": Way(shows="not known: no code was heard", code=5),
    "woosh camera -o now.png": Way(writes=("now.png",)),
    "woosh --sim plan A1": Way(shows="points, "),
    "woosh goto A1": Way(shows="arrived after"),
    "woosh mission check round.mission.toml": Way(shows="1 steps, no fault"),
    "woosh --sim mission run round.mission.toml": Way(shows="round: done"),
    "woosh map save hall": Way(writes=("hall.yaml", "hall.pgm", "hall.png")),
    "woosh plan 3 1 0 --png way.png": Way(writes=("way.png",)),
    "woosh task pause": Way(shows="pause", during="task"),
    "woosh record -O drive.bag --duration 10m": Way(
        until="recording",
        lasts=3.0,  # exit code 1 while a topic has sent nothing
        writes=("drive.bag",),
    ),
    "woosh --sim web": Way(until="openapi.json", more=("--port", "0", "--no-browser"), code=130),
    "woosh web --bind 0.0.0.0 --token Kd83-hsa2-Pq": Way(
        until="openapi.json", more=("--port", "0", "--no-browser"), code=130
    ),
    "woosh foxglove --sim": Way(until="ws://", lasts=1.0, more=("--port", "0")),
    "woosh --sim status": Way(shows="battery"),
    "woosh --sim goto A1": Way(shows="arrived after"),
    "woosh --sim shell": Way(stdin="print(chassis)\n"),
    "rosproto topic echo /odom/pose/pose/position/x --plot": Way(until="/odom", code=130),
    "rosproto topic echo /scan --noarr --filter 'm.range_max > 10'": Way(shows="ranges", more=("-n", "2")),
    "rosproto topic hz /odom /scan": Way(until="/scan  ", code=130),
    "rosproto topic pub -r 10 /cmd_vel geometry_msgs/Twist '{linear: {x: 0.1}}'": Way(
        until="received", code=130
    ),
    "rosproto bag record /odom /scan -O drive.bag --lz4": Way(until="recording", writes=("drive.bag",)),
    "rosproto bag record -a --split --duration 5m --max-splits 12": Way(
        until="recording", writes=("2*.bag",)
    ),
    "rosproto topic echo /odom/twist/twist/linear/x /odom/twist/twist/angular/z --plot": Way(
        until="now", code=130
    ),
    "rosproto tf frames -o frames.svg": Way(writes=("frames.svg",)),
    "rosproto tf monitor map base_link -n 1": Way(shows="/woosh_localization"),
    "rosproto log echo --level warn --node '/move_base*'": Way(until="the way is blocked", code=130),
    "rosproto graph -o graph.svg": Way(writes=("graph.svg",)),
    "rosproto bridge": Way(until="ws://", more=("--port", "0")),
    "rosproto bridge --bind 0.0.0.0 --token Kd83-hsa2-Pq --allow-write 'topic:/chatter' --deny 'param:*'": Way(
        until="ws://", more=("--port", "0")
    ),
    "rosproto run program.py _speed:=0.2": Way(shows="speed 0.2"),
    "woosh run --sim program.py _speed:=0.2": Way(shows="speed 0.2"),
    "rosproto master --host 0.0.0.0 --advertise 169.254.128.20": Way(
        until="http://169.254.128.20:", more=("--port", "0")
    ),
}
for line in commands():
    if line.startswith("woosh sim"):
        more = () if "--port" in line else ("--port", "0")
        if "--robots" in line:
            more += ("--page-port", "0")
        WAYS[line] = Way(until="woosh --master http", more=more, code=130)
    elif line.startswith("woosh --sim web"):
        WAYS.setdefault(line, Way(until="openapi.json", more=("--port", "0", "--no-browser"), code=130))
OF_PAGES = [line for line in commands() if re.search(r"^woosh sim|--sim\b|\w\.py\b", line)]
"""What a reader without a robot copies."""
ELSEWHERE = ("--watch", "--sim drive")  # in test_cli_run.py, and on a terminal in test_cli_terminal.py
LINES = [line for examples in (WOOSH, ROSPROTO) for lines in examples.values() for line in lines]
LINES = [line for line in dict.fromkeys([*LINES, *OF_PAGES]) if not any(each in line for each in ELSEWHERE)]


@pytest.fixture(scope="module")
def robot() -> Iterator[Robot]:
    """A simulated chassis with all of its graph."""
    with SimulatedChassis(speed=8.0, latch_status=False) as running:
        yield Robot(running)


@pytest.fixture
def sim(robot: Robot) -> SimulatedChassis:
    """In a hurry, and where it was switched on: an example that docks leaves no room for one that moves."""
    robot.renew(8.0)
    return robot.sim


@pytest.fixture
def lamp(sim: SimulatedChassis) -> Iterator[None]:
    """The service of the examples, a node that logs, and one that can be reconfigured."""

    def switch(request: object) -> dict[str, object]:
        return {"success": True, "message": ""}

    with rosproto.Node("/lamp_of_the_examples", master_uri=sim.master_uri) as node:
        node.service_server("/lamp", "std_srvs/SetBool", switch)
        Tunable(node, "/camera")
        line = rosproto.message_class("rosgraph_msgs/Log")(
            level=4, name="/move_base", msg="the way is blocked"
        )
        node.publisher("/rosout_agg", "rosgraph_msgs/Log", latch=True).publish(line)
        yield


@pytest.fixture(autouse=True)
def place(
    request: pytest.FixtureRequest, sim: SimulatedChassis, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A folder with what the examples name; nothing of the user's."""
    monkeypatch.setenv("WOOSH_CONFIG_DIR", str(tmp_path / "config"))
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    monkeypatch.setenv("ROS_MASTER_URI", sim.master_uri)
    monkeypatch.chdir(tmp_path)
    odometry = rosproto.message_class("nav_msgs/Odometry")
    if " record " not in request.node.name:  # which overwrites no bag
        with BagWriter(tmp_path / "drive.bag") as bag:
            bag.write("/odom", odometry(), 1000.0)
            bag.write("/odom", odometry(), 1000.2)
    (tmp_path / "token.txt").write_text("Kd83-hsa2-Pq")
    (tmp_path / "token.txt").chmod(0o600)
    if "hall.yaml" in request.node.name:
        built_in_site().grid.save(tmp_path / "hall.yaml")
        marks = MarkFile(tmp_path / "my-marks.json")
        marks.put("shelf", Pose2D(2.0, 0.5))
        marks.save()
    (tmp_path / "first.py").write_text("from woosh_pure import Chassis\nprint(Chassis().battery.wait())\n")
    (tmp_path / "round.mission.toml").write_text(
        'mission = 1\nname = "round"\n[parameters]\ntarget = "A1"\n[[step]]\ndo = "move"\nmetres = 0.1\n'
    )
    (tmp_path / "program.py").write_text(
        "import rospy\nrospy.init_node('program')\nprint('speed', rospy.get_param('~speed', 0.1))\n"
    )


def words_of(line: str, sim: SimulatedChassis) -> list[str]:
    address = sim.master_uri.removeprefix("http://").rstrip("/")
    line = line.removeprefix('eval "$(').removesuffix(')"').replace("169.254.128.2 ", f"{address} ")
    if line.endswith("169.254.128.2"):
        line = line.replace("169.254.128.2", address)
    return shlex.split(line)


EXTRAS = {
    "bridge": "bridge",
    "foxglove": "foxglove",
    "web": "web",
    "--robots": "web",
    "--robot-api": "api",
    "mcp": "mcp",
}
"""Words of a command, and the extra that it needs."""


@pytest.fixture
def api() -> Iterator[ApiPeer]:
    with ApiPeer() as peer:
        yield peer


@pytest.mark.slow
@pytest.mark.parametrize("line", LINES)
def test_an_example_of_help_does_what_it_promises(
    line: str, sim: SimulatedChassis, lamp: None, tmp_path: Path, api: ApiPeer
) -> None:
    """It ends with 0, or goes on and shows something until Ctrl-C."""
    way = WAYS.get(line, Way())
    for word in line.split():
        if word in EXTRAS:
            needs(EXTRAS[word])
    for before in way.first:
        prog, *words = words_of(before, sim)
        assert run(prog, words).code == 0
    prog, *words = words_of(line, sim)
    if way.until == "received":
        with (
            rosproto.Node("/listener_of_the_examples", master_uri=sim.master_uri) as node,
            node.subscriber("/cmd_vel", "geometry_msgs/Twist") as twists,
        ):
            result = run_until(lambda _: twists.latest is not None, prog, words)
            assert twists.latest.linear.x == 0.1
    elif way.until:
        result = run_until(lambda shown: way.until in shown, prog, [*words, *way.more], way.lasts)
        assert way.until in result.out + result.err
    else:
        with task_begun(sim) if way.during else contextlib.nullcontext():
            apart = (
                words[0] == "run" or "mcp" in words
            )  # loads ROS's layer into the process; reads its own stdin
            command = run_apart if apart else run
            more = ("--api-address", api.address) if words[0] == "api" else way.more
            result = command(prog, [*words, *more], way.stdin)
    assert result.code == way.code, result.err
    assert way.shows in result.out
    if words[0] != "completion":  # that prints a program
        assert "\\n" not in result.out + result.err, "a line end of ours became an escape"
    for pattern in way.writes:
        found = list(tmp_path.glob(pattern))
        assert found, f"no {pattern}: {sorted(p.name for p in tmp_path.iterdir())}"
        assert all(file.stat().st_size > 100 for file in found)


@contextlib.contextmanager
def task_begun(sim: SimulatedChassis) -> Iterator[None]:
    """A task starts as soon as one more listens to `/robot_status`, which is sent on change only."""
    publisher = next(p for (_, topic), p in sim.graph.publishers.items() if topic == "/robot_status")
    over = threading.Event()
    with Chassis(sim.master_uri) as other:
        before = publisher.connections

        def start() -> None:
            while publisher.connections <= before and not over.wait(0.01):
                pass
            other.go_to_mark("B1")

        thread = threading.Thread(target=start, daemon=True)
        thread.start()
        try:
            yield
        finally:
            over.set()
            thread.join(5.0)
            other.stop()
