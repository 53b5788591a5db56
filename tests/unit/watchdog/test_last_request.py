"""`RequestSender`: the answers of a server that lies, refuses or wants a password."""

from __future__ import annotations

import json
import threading
from typing import Any, NamedTuple

import pytest

from rosproto.watchdog import LastRequest
from rosproto.watchdog import process as module
from tests.support.robot_api_peer import ANSWERS, ApiPeer
from tests.support.waiting import until


class Response(NamedTuple):
    status: int
    body: bytes


class Server:
    """Answers by path; a text is sent as it is."""

    def __init__(self, **answers: Any) -> None:
        self.answers = answers
        self.asked: list[str] = []
        self.status = 200

    def post(self, doing: str, body: bytes, deadline: object, *, path: str) -> Response:
        self.asked.append(path)
        answer = self.answers[path]
        return Response(self.status, (answer if isinstance(answer, str) else json.dumps(answer)).encode())


def request(server: Server, monkeypatch: pytest.MonkeyPatch, *only_if: str) -> Any:
    monkeypatch.setattr(module, "HttpClient", lambda *_, **__: server)
    made = module.RequestSender(LastRequest("http://robot:5480", "cancel", "{}", "task", only_if))
    server.asked.clear()
    return made


OURS = {"ok": True, "body": {"id": "7"}}


@pytest.mark.parametrize(
    "lie", ["[]", "5", "", "{", "[" * 100_000, '{"ok": true, "body": 5}', '{"ok": true}']
)
def test_an_answer_that_tells_nothing_lets_the_cancel_be_sent(
    lie: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In doubt it is stopped."""
    server = Server(task=OURS, cancel={"ok": True})
    made = request(server, monkeypatch, "id", "7")
    server.answers["task"] = lie
    made.perform()
    assert (server.asked, made.done) == (["task", "cancel"], True)


def test_a_refused_cancel_is_sent_again(monkeypatch: pytest.MonkeyPatch) -> None:
    server = Server(task=OURS, cancel={"ok": False})
    made = request(server, monkeypatch, "id", "7")
    made.perform()
    assert not made.done
    server.answers["cancel"] = {"ok": True}
    made.perform()
    made.perform()
    assert (made.done, server.asked.count("cancel")) == (True, 2)


def test_a_cancel_that_is_to_be_sent_for_a_while_is_not_done_when_it_is_accepted(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """What it ended may be followed by more, as a task of a list by the next one."""
    server = Server(task=OURS, cancel={"ok": True})
    monkeypatch.setattr(module, "HttpClient", lambda *_, **__: server)
    made = module.RequestSender(LastRequest("http://robot:5480", "cancel", "{}", "task", seconds=60.0))
    made.send()
    until(lambda: "cancel" in server.asked)
    made.perform()  # waits for the one before
    assert not made.done
    assert server.asked.count("cancel") == 2


@pytest.mark.parametrize("only_if", [(), ("state", "2")])
def test_a_kept_connection_that_is_dead_is_left_for_a_new_one(only_if: tuple[str, ...]) -> None:
    """The server that was killed with the program, or a network that forgot the connection, never answers."""
    dead = threading.Event()

    def wait(request: str) -> None:
        if dead.is_set() and peer.connections == 1:
            peer.closing.wait(20.0)

    with ApiPeer({**ANSWERS, "woosh.robot.Twist": {}}, wait=wait) as peer:
        paths = "/woosh/robot/Twist", "{}", "/woosh/robot/RobotState"
        sender = module.RequestSender(LastRequest(f"http://127.0.0.1:{peer.port}", *paths, only_if))
        dead.set()
        sender.perform()
        assert sender.done
        assert peer.connections == 2
        sender.close()


def test_another_task_is_spared(monkeypatch: pytest.MonkeyPatch) -> None:
    server = Server(task={"ok": True, "body": {"id": 8}}, cancel={"ok": True})
    made = request(server, monkeypatch, "id", "7")
    made.perform()
    assert (server.asked, made.done) == (["task"], True)


def test_a_server_that_wants_a_password_is_told_before_it_matters(monkeypatch: pytest.MonkeyPatch) -> None:
    server = Server(task={"ok": False, "msg": "password"})
    server.status = 401
    with pytest.raises(ValueError, match="401"):
        request(server, monkeypatch)
