"""`RequestSender`: the answers of a server that lies, refuses or wants a password."""

from __future__ import annotations

import json
from typing import Any, NamedTuple

import pytest

from rosproto.watchdog import LastRequest
from rosproto.watchdog import process as module


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
