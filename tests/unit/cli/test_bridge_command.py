"""`rosproto bridge`: one line that says where it serves and what is open; errors as sentences; every option."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

from rosproto import Master, Node
from rosproto.cli import CommandError, main
from rosproto.cli.gateway import limits_of
from rosproto.codec import message_class
from rosproto.gateway import GatewayLimits
from tests.support.rosbridge_client import RosbridgeClient
from tests.support.waiting import until

pytest.importorskip("websockets", reason="websockets is not installed")
String = message_class("std_msgs/String")
ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture
def master() -> Iterator[Master]:
    with Master() as master:
        yield master


def served(master: Master, *options: str) -> subprocess.Popen[str]:
    words = [sys.executable, "-m", "rosproto", "bridge", "--master", master.uri, "--port", "0", *options]
    return subprocess.Popen(
        words, cwd=ROOT, stdout=subprocess.PIPE, text=True, env={**os.environ, "PYTHONPATH": str(ROOT)}
    )


@pytest.mark.slow
def test_a_large_map_is_taken_where_it_was_asked_for(master: Master) -> None:
    """2 MB of JSON with a million values, with the option; without it, the connection ends."""
    cells = '{"op":"publish","topic":"/map","msg":{"data":[' + "0," * 999_999 + "0]}}"
    write = ["--allow-write", "topic:/map"]
    with Node("/robot", master_uri=master.uri) as robot:
        got = robot.subscriber("/map", "nav_msgs/OccupancyGrid")
        for options in ([], ["--message-bytes", "10000100"]):
            with served(master, *write, *options) as process:
                try:
                    assert process.stdout is not None
                    with RosbridgeClient(process.stdout.readline().split()[3]) as client:
                        client.send(op="advertise", topic="/map", type="nav_msgs/OccupancyGrid")
                        got.wait_for_connection(60)  # what is published before is lost
                        client.send_raw(cells)
                        if options:
                            assert len(got.next(60).data) == 1_000_000
                        else:
                            assert client.closed()[0] == 1009
                finally:
                    process.terminate()
                    process.wait(20)


@pytest.mark.slow
def test_it_serves_until_interrupted(master: Master) -> None:
    """What the patterns open, behind a token; and it leaves nothing at the master."""
    options = ["--token", "kd83&hsa2", "--allow-write", "topic:/chat", "--deny", "/secret", "--allow", "/*"]
    with Node("/robot", master_uri=master.uri) as robot, served(master, *options) as process:
        try:
            assert process.stdout is not None
            line = process.stdout.readline()
            assert "writing: topic:/chat" in line
            url = line.split()[3]
            assert url.endswith("/?token=kd83%26hsa2")
            got = robot.subscriber("/chat", String)
            with RosbridgeClient(url) as client:
                client.send(op="advertise", topic="/chat", type="std_msgs/String")
                client.send(op="publish", topic="/chat", msg={"data": "hello"})
                assert got.next(20).data == "hello"
                client.send(op="subscribe", topic="/secret", id="s")
                assert client.op("status")["id"] == "s"
            with pytest.raises(Exception, match="401"):
                RosbridgeClient(url.partition("?")[0])
        finally:
            process.terminate()
            assert process.wait(20) in (0, 143)
        assert not robot.master.get_system_state().publishers.get("/chat")


def test_off_this_computer_it_makes_a_token(master: Master, capsys: pytest.CaptureFixture[str]) -> None:
    """And prints it; reading only unless something is opened."""
    words = ["bridge", "--master", master.uri, "--port", "0", "--for", "0.1"]
    assert main([*words, "--bind", "0.0.0.0"]) == 0
    line = capsys.readouterr().out
    assert len(line.split("?token=")[1].split()[0]) >= 20
    assert "read only: --allow-write" in line
    assert main([*words, "--read-only", "--allow-write", "*", "--origin", "https://a.example"]) == 0
    assert "(read only)" in capsys.readouterr().out


def test_what_is_wrong_is_a_sentence(
    master: Master, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A port that is taken, a certificate that is none, a pattern of no kind, a package that is missing."""
    words = ["bridge", "--master", master.uri]
    assert main([*words, "--port", str(master.port)]) == 1
    assert "another --port" in capsys.readouterr().err
    (tmp_path / "cert").write_text("nothing")
    assert main([*words, "--port", "0", "--tls-cert", str(tmp_path / "cert")]) == 1
    assert "--tls-cert" in capsys.readouterr().err
    assert main([*words, "--port", "0", "--tls-key", "x"]) == 1
    assert "--tls-cert" in capsys.readouterr().err
    assert main([*words, "--port", "0", "--allow-write", "robot:/x"]) == 2
    assert "not a kind" in capsys.readouterr().err
    monkeypatch.setitem(sys.modules, "websockets.asyncio.server", None)
    assert main([*words, "--port", "0"]) == 1
    assert 'pip install ".[bridge]"' in capsys.readouterr().err


@pytest.mark.promise("is then neither printed nor given to a browser's command line")
@pytest.mark.parametrize("command", ["bridge", "foxglove"])
def test_a_token_of_a_file_or_the_environment_is_not_printed(
    master: Master,
    tmp_path: Path,
    capfd: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    command: str,
) -> None:
    """The start line may end in a log that others read. One that the command makes is printed: nobody knows it."""
    words = [command, "--master", master.uri, "--port", "0", "--for", "0.1"]
    file = tmp_path / "token"
    file.write_text("of-many-letters\n")
    file.chmod(0o600)
    assert main([*words, "--token-file", str(file)]) == 0
    monkeypatch.setenv("ROSPROTO_TOKEN", "of-many-letters")
    assert main(words) == 0
    said = "".join(capfd.readouterr())
    assert "of-many-letters" not in said
    assert said.count("/?token=... (") == 2
    assert main([*words, "--token", "kd83-hsa2"]) == 0
    assert "/?token=kd83-hsa2 (" in capfd.readouterr().out


def test_a_short_token_is_a_sentence(master: Master, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bridge", "--master", master.uri, "--port", "0", "--token", "secret"]) == 2
    assert "the token is too short (length 6); use at least 8 random characters" in capsys.readouterr().err


@pytest.mark.slow  # 200 clients
def test_as_many_clients_as_were_asked_for(master: Master) -> None:
    """All of them subscribe and get the message; one more is refused. They need few threads and bounded memory."""
    with (
        Node("/robot", master_uri=master.uri) as robot,
        served(master, "--max-clients", "200") as process,
        ExitStack() as stack,
    ):
        stack.callback(process.wait, 20)
        stack.callback(process.terminate)
        publisher = robot.publisher("/chat", String, latch=True)
        publisher.publish(String(data="hello"))
        assert process.stdout is not None
        url = process.stdout.readline().split()[3]
        clients = [stack.enter_context(RosbridgeClient(url)) for _ in range(200)]
        for client in clients:
            client.send(op="subscribe", topic="/chat")
        assert {client.op("publish")["msg"]["data"] for client in clients} == {"hello"}
        with pytest.raises(Exception, match="503"):
            RosbridgeClient(url)
        if sys.platform == "linux":

            def threads() -> int:
                status = Path(f"/proc/{process.pid}/status").read_text()
                return int(status.partition("Threads:")[2].split()[0])

            until(lambda: threads() < 50, what=threads)  # those of a busy moment end when they are idle


def test_limits_of_many_clients_take_no_more_memory_than_those_of_64() -> None:
    usual, many = GatewayLimits(), limits_of(None, 200)
    assert many.connections == 200
    assert 200 * many.outbox_bytes <= 64 * usual.outbox_bytes
    assert 200 * many.answer_bytes <= 64 * usual.answer_bytes
    assert (many.threads, usual.threads, GatewayLimits(connections=2).threads) == (256, 256, 8)
    assert limits_of(None, 64) == usual


@pytest.mark.skipif(sys.platform == "win32", reason="no limit of open files")
def test_more_clients_than_open_files_are_refused_at_the_start(monkeypatch: pytest.MonkeyPatch) -> None:
    from rosproto.transport import os_errors

    monkeypatch.setattr(os_errors, "allow_open_files", lambda count: None)
    monkeypatch.setattr(os_errors, "open_file_limit", lambda: 256)
    assert limits_of(None, 64).connections == 64, "as ever: each new connection replaces one"
    with pytest.raises(CommandError, match=r"--max-clients 200 needs 464 open files, .* allows 256"):
        limits_of(None, 200)
