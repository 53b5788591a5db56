"""`woosh web` as a process: several robots, https, and an orderly end under open pages."""

from __future__ import annotations

import json
import os
import shutil
import signal
import socket
import ssl
import subprocess
import urllib.request
from argparse import Namespace
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("fastapi", reason="needs the extra `web`")
pytest.importorskip("uvicorn", reason="needs the extra `web`")
pytest.importorskip("websockets", reason="needs the extra `web`")

from tests.support.certificates import certificate
from tests.support.robot_pool import RobotPool
from tests.support.ros import free_port
from tests.support.waiting import until
from tests.support.web import PageClient, Served
from tests.support.woosh_command import woosh_process
from woosh_pure import Chassis, SimulatedChassis
from woosh_pure.cli.commands.web import _first, _further, page_of
from woosh_pure.cli.entry import parser_for
from woosh_pure.cli.output import Output
from woosh_pure.maps.marks import MarkFile

TOKEN = "made-by-chance"


# -- which robots --------------------------------------------------------------------------------------------


def chosen(*words: str) -> tuple[str, list[tuple[str, str]], str | None]:
    """Name of the first robot, names and addresses of the others, and the address of the first."""
    args: Namespace = parser_for(words).parse_args(words)
    more = _further(args)
    return _first(args, alone=not more), more, args.chassis


@pytest.mark.parametrize(
    ("words", "first", "more"),
    [
        (["web"], "robot", []),
        (["web", "--chassis", "10.0.0.1"], "robot", []),
        (["web", "--chassis", "hall=10.0.0.1"], "hall", []),
        (["web", "--chassis", "10.0.0.1", "--chassis", "10.0.0.2"], "10.0.0.1", [("10.0.0.2", "10.0.0.2")]),
        (["web", "--chassis", "a=10.0.0.1", "--chassis", "b=10.0.0.2"], "a", [("b", "10.0.0.2")]),
        (["--chassis", "10.0.0.1", "web", "--chassis", "b=10.0.0.2"], "10.0.0.1", [("b", "10.0.0.2")]),
        (["web", "--chassis", "h:11311", "--chassis", "h:11312"], "h", [("h:11312", "h:11312")]),
        (["web", "--chassis", "http://h:5/", "--robot", "b=c"], "h:5", [("b", "c")]),
        (["--sim", "web", "--robot", "b=10.0.0.2"], "sim", [("b", "10.0.0.2")]),
        (["web", "--robot", "b=10.0.0.2"], "robot", [("b", "10.0.0.2")]),
    ],
)
def test_each_chassis_is_a_robot_with_a_name(
    words: list[str], first: str, more: list[tuple[str, str]]
) -> None:
    assert chosen(*words)[:2] == (first, more)


def test_the_first_chassis_is_the_one_of_the_plain_paths() -> None:
    assert chosen("web", "--chassis", "a=10.0.0.1", "--chassis", "b=10.0.0.2")[2] == "10.0.0.1"


def test_to_other_commands_the_last_chassis_is_the_one_and_its_name_is_no_matter() -> None:
    words = ["--chassis", "10.0.0.1", "status", "--chassis", "hall=10.0.0.2"]
    assert parser_for(words).parse_args(words).chassis == "10.0.0.2"


@pytest.mark.parametrize(
    "words", [["--chassis", "a", "--chassis", "b="], ["--robot", "b"], ["--robot", "=c"]]
)
def test_an_address_that_is_missing_is_told(words: list[str]) -> None:
    with pytest.raises(ValueError, match=r"=192\.168\.1\.20"):
        chosen("web", *words)


# -- the process ---------------------------------------------------------------------------------------------


@dataclass
class Command:
    """A running one."""

    process: subprocess.Popen[str]
    record: dict[str, Any]
    cert: str
    trust: ssl.SSLContext

    @property
    def url(self) -> str:
        return str(self.record["url"])

    @property
    def port(self) -> int:
        return int(self.record["port"])

    def log_in(self) -> str:
        """What a browser keeps."""
        body, kind = json.dumps({"token": TOKEN}).encode(), {"content-type": "application/json"}
        request = urllib.request.Request(self.url + "api/v1/login", body, kind, method="POST")
        with urllib.request.urlopen(request, timeout=20, context=self.trust) as answer:
            return str(answer.headers["set-cookie"]).partition(";")[0]

    def get(self, path: str) -> Any:
        request = urllib.request.Request(self.url + path, headers={"authorization": f"Bearer {TOKEN}"})
        with urllib.request.urlopen(request, timeout=20, context=self.trust) as answer:
            return json.loads(answer.read())


@pytest.fixture
def command(robots: RobotPool, tmp_path: Path) -> Iterator[Command]:
    """Two robots, one of them by a name, over TLS."""
    pytest.importorskip("cryptography", reason="makes the certificate")
    cert, key = certificate(tmp_path)
    with ExitStack() as stack:
        two = []
        for _ in range(2):
            robot = robots.take(8.0)
            stack.callback(robots.give_back, robot)
            two.append(robot.sim.master_uri)
        process = woosh_process(
            *("--json", "web", "--chassis", f"hall={two[0]}", "--chassis", two[1], "--port", "0"),
            *("--no-browser", "--token", TOKEN, "--tls-cert", cert, "--tls-key", key),
        )
        stack.callback(process.communicate, timeout=20)
        stack.callback(process.kill)
        assert process.stdout is not None
        record = json.loads(process.stdout.readline())
        yield Command(process, record, cert, ssl.create_default_context(cafile=cert))


@pytest.mark.slow
def test_two_robots_over_https_and_an_orderly_end_under_their_pages(command: Command) -> None:
    """One process for all of it: it takes two seconds to start."""
    assert command.url.startswith("https://127.0.0.1:")
    first, second = command.record["robots"]
    assert first == "hall"
    assert second.startswith("127.0.0.1:")
    assert [robot["name"] for robot in command.get("api/v1/robots")] == [first, second]
    for name in (first, second):
        assert command.get(f"robots/{name}/api/v1/status")["robot"] == name
    who_is_it(command)
    with_curl(command)

    cookie = {"cookie": command.log_in()}
    with (
        PageClient(command.port, ssl=command.trust, additional_headers=cookie) as page,
        PageClient(
            command.port, f"/robots/{second}/api/v1/live", ssl=command.trust, additional_headers=cookie
        ) as other,
        command.trust.wrap_socket(
            socket.create_connection(("127.0.0.1", command.port), timeout=20), server_hostname="127.0.0.1"
        ) as stream,
    ):
        assert page.of("hello")["robots"] == [first, second]
        assert other.of("hello")["robot"] == second
        stream.sendall(
            f"GET /api/v1/feeds/pose/stream?rate=0.1 HTTP/1.1\r\nHost: 127.0.0.1\r\nAuthorization: Bearer {TOKEN}"
            "\r\n\r\n".encode()
        )
        assert b"text/event-stream" in stream.recv(4096)
        if os.name != "posix":
            return
        command.process.send_signal(signal.SIGTERM)
        _, errors = command.process.communicate(timeout=20)
        assert command.process.returncode == 143
        assert errors.splitlines() == ["woosh: terminated"], "no trace, and no word of an error"
        page._reader.join(5)
        assert page.socket.close_code in (1000, 1012)


def who_is_it(command: Command) -> None:
    """Who does not know the certificate does not go on; who speaks no TLS gets nothing."""
    with pytest.raises(ssl.SSLCertVerificationError):
        PageClient(command.port, ssl=ssl.create_default_context())
    with socket.create_connection(("127.0.0.1", command.port), timeout=20) as plain:
        plain.sendall(b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n")
        assert not plain.recv(100).startswith(b"HTTP")


def with_curl(command: Command) -> None:
    """The cookie of the page goes over TLS only."""
    curl = shutil.which("curl")
    if curl is None:
        return
    ask = [curl, "-sS", "--cacert", command.cert, "-i", "-H", "content-type: application/json"]
    done = subprocess.run(
        [*ask, "-d", json.dumps({"token": TOKEN}), command.url + "api/v1/login"],
        capture_output=True,
        text=True,
        timeout=30,
    )
    assert done.returncode == 0, done.stderr
    assert " 200" in done.stdout.splitlines()[0]
    assert "Secure" in done.stdout
    untrusting = subprocess.run([curl, "-sS", command.url], capture_output=True, text=True, timeout=30)
    assert untrusting.returncode == 60, "curl: the certificate is not known"


# -- a robot that is off -------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.promise("neither printed nor given to a browser's command line")
def test_a_robot_that_is_off_is_waited_for(private_config: Path, until: Callable[..., None]) -> None:
    """Its page is served meanwhile and says so, STOP is answered, and marks can be saved. The token of a file
    is not printed.
    """
    file, port = private_config.parent / "token", free_port()
    file.write_text(TOKEN)
    file.chmod(0o600)
    process = woosh_process(
        *("--chassis", f"127.0.0.1:{port}", "web", "--port", "0", "--no-browser", "--token-file", str(file))
    )
    with ExitStack() as stack:
        stack.callback(process.communicate, timeout=20)
        stack.callback(process.kill)
        assert process.stdout is not None
        waits, page_line = process.stdout.readline(), process.stdout.readline()
        assert "waiting for it" in waits
        assert page_line.startswith("the page: http://127.0.0.1:")
        assert TOKEN not in page_line
        web = Served(int(page_line.rpartition(":")[2].strip(" /\n")), TOKEN)
        away = web.get("status")
        assert (away.status, away.json["type"]) == (503, "urn:woosh:not-connected"), away
        assert web.post("goals", {"kind": "mark", "mark": "A1"}).status == 503
        stopped = web.post("stop")
        assert (stopped.status, stopped.json["stands_still"]) == (200, None), (
            "it is tried, and said to be unknown"
        )
        assert web.post("marks", {"name": "A1", "on_chassis": True}).status == 201
        assert MarkFile(private_config / "marks.json").names == ["A1"]
        with PageClient(web.port, additional_headers={"authorization": f"Bearer {TOKEN}"}) as page:
            page.of("lost", key="not-connected")
            page.of("marks")
            with SimulatedChassis(port=port):
                page.wait(lambda d: d["t"] == "lost" and d["text"] is None, 30.0)
                page.of("pose")
                until(lambda: web.get("status").status == 200, what="the robot being reached")
                assert "connected" in process.stdout.readline() + process.stdout.readline()


def pose_at(address: str) -> Any:
    with urllib.request.urlopen(address, timeout=20) as answer:
        return json.load(answer)["pose"]


@pytest.mark.slow
def test_a_simulated_robot_may_be_driven_and_each_pupil_has_one() -> None:
    """`woosh sim --robots 2`: one process, an address each, one page with all, and driving by hand is on."""
    process = woosh_process("sim", "--robots", "2", "--port", "0", "--page-port", "0")
    try:
        assert process.stdout is not None
        said = [process.stdout.readline() for _ in range(7)]
        uris = [line.split()[4].rstrip(",") for line in said if ": simulated chassis at " in line]
        assert [line.split(":")[0] for line in said if ": simulated" in line] == ["robot1", "robot2"]
        assert not any("for others" in line for line in said), "nobody else reaches 127.0.0.1"
        pages = [line.split()[-1] for line in said if line.startswith("the page of robot")]
        assert [page.rpartition("/robots/")[2] for page in pages] == ["robot1/", "robot2/"]
        with Chassis(uris[1]) as second:
            second.move(0.3).wait(timeout=20)
        found = [f"{page}api/v1/snapshot" for page in pages]
        until(lambda: all(map(pose_at, found)), 20.0)  # the server listens from the first request on
        assert (pose_at(found[0])["x"] < 0.1, pose_at(found[1])["x"] > 0.2) == (True, True)
    finally:
        process.kill()
        process.communicate(timeout=10)


@pytest.mark.parametrize(
    ("words", "driving"),
    [
        ((), False),
        (("--allow-driving",), True),
        (("--sim",), True),
        (("--sim", "--robot", "b=127.0.0.1:9"), False),
    ],
)
def test_driving_is_on_in_a_simulation_and_off_where_a_real_robot_is(
    words: tuple[str, ...], driving: bool, sim: SimulatedChassis
) -> None:
    """A real robot beside the simulated one counts: the server has one switch."""
    args = parser_for(["web"]).parse_args(["web", "--port", "0", "--no-browser", *words])
    robots = {"sim": Chassis(sim.master_uri), **({"b": Chassis("127.0.0.1:9")} if "--robot" in words else {})}
    simulators = {"sim": sim} if args.sim else {}
    with page_of(robots, args, Output(as_json=True), [], simulators) as (server, _):
        assert server.app.state.context.allow_driving is driving
