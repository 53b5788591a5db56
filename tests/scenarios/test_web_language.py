"""The sentences in answers of the REST API are in the language of the request, `Accept-Language`."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("fastapi", reason="needs the extra `web`")
pytest.importorskip("uvicorn", reason="needs the extra `web`")

from tests.support.web import PageClient, Served, serving
from tools.templates import english_left
from woosh_pure import Chassis, SimulatedChassis
from woosh_pure.language.table import key_of, translator_for
from woosh_pure.web.goals import COMMANDS

CHINESE = {"accept-language": "zh-CN,zh;q=0.9"}
SENTENCES = ("text", "description", "progress", "what", "detail", "error")


@pytest.fixture
def web(chassis: Chassis, tmp_path: Path) -> Iterator[Served]:
    """A server for one robot."""
    with serving(chassis, recordings=tmp_path) as served:
        yield served


def sentences(document: Any) -> list[str]:
    """The sentences of an answer; a pair of `text` and `text_zh` has both languages."""
    if isinstance(document, list):
        return [each for part in document for each in sentences(part)]
    if not isinstance(document, dict):
        return []
    said = [
        document[name]
        for name in SENTENCES
        if isinstance(document.get(name), str) and "text_zh" not in document
    ]
    return said + [each for part in document.values() for each in sentences(part)]


def test_no_answer_to_a_chinese_request_has_english_sentences(web: Served, sim: SimulatedChassis) -> None:
    def ask(method: str, path: str, body: Any = None) -> Any:
        answer = web.ask(method, path, body, headers=CHINESE)
        assert answer.status < 400, answer
        return answer.json

    move = ask("POST", "goals", {"kind": "move", "distance": 5.0})
    number = move["id"]
    ask("POST", f"goals/{number}/pause")
    answers = [
        move,
        ask("GET", "goals"),
        ask("GET", "snapshot"),
        ask("GET", "status"),
        ask("GET", "readiness"),
    ]
    answers += [ask("GET", "faults"), ask("POST", "stop"), ask("GET", f"goals/{number}/wait")]
    answers += [ask("POST", "pose", {"x": 1.0, "y": 0.5}), ask("GET", "journal")]
    for said in sentences(answers) + chinese(answers):
        assert not english_left(said), said
    text = " ".join(sentences(answers))
    for words in (
        "直行 5.000 米",
        "直行 5.00 米",
        "已取消",
        "机器人已停稳",
        "127.0.0.1 上的程序停止了机器人",
    ):
        assert words in text, (words, text)
    english = " ".join(sentences([web.get("journal").json, web.get("goals").json, web.post("stop").json]))
    assert english.isascii()
    assert "the robot stands still" in english


def test_the_reasons_of_a_refusal_are_in_the_language_of_the_request(
    web: Served, sim: SimulatedChassis
) -> None:
    sim.press_emergency_stop()
    refused = web.post("goals", {"kind": "mark", "mark": "nowhere"}, headers=CHINESE)
    assert refused.status == 409
    assert refused.json["detail"].startswith("前往“nowhere”")  # by us, or by a chassis that knew it sooner
    journal = web.get("journal", headers=CHINESE).json[-1]
    assert journal["what"] == "前往“nowhere”"
    assert web.get("journal").json[-1]["what"] == "go to nowhere"
    step = web.post("goals", {"kind": "move", "distance": 0.2}, headers=CHINESE)
    assert step.json["detail"].startswith("直行 0.200 米被拒绝，没有发送任何命令；急停")
    for said in sentences([refused.json, step.json]):
        assert not english_left(said.replace("nowhere", "")), said


def chinese(document: Any) -> list[str]:
    """The Chinese sentence of each pair of `text` and `text_zh`."""
    if isinstance(document, list):
        return [each for part in document for each in chinese(part)]
    if not isinstance(document, dict):
        return []
    pair = [document["text_zh"]] if "text_zh" in document else []
    return pair + [each for part in document.values() for each in chinese(part)]


def test_the_end_before_an_obstacle_is_told_once_and_in_the_language_of_its_field(
    web: Served, sim: SimulatedChassis
) -> None:
    sim.add_obstacle(1.0, 0.0)
    goal = web.post("goals", {"kind": "move", "distance": 3.0}, headers=CHINESE).json
    ended = web.get(f"goals/{goal['id']}/wait", headers=CHINESE).json
    assert ended["state"] == "failed"
    assert ended["text"].count("130701000032") == 1
    assert ended["said"] == {
        "text": "step movement: obstacle wait timed out",
        "text_zh": "单步移动等待障碍物超时",
    }
    for said in sentences(ended) + chinese(ended):
        assert not english_left(said), said


def test_what_a_request_is_refused_for_is_told_without_python(web: Served) -> None:
    here = {"name": "门口", "x": 1.0, "y": 1.0}
    assert web.post("marks", here, headers=CHINESE).status < 300
    web.post("goals", {"kind": "move", "distance": 5.0})
    second = web.post("goals", {"kind": "rotate", "angle": 1.0}, headers=CHINESE).json
    assert "replace=True" not in json.dumps(second)
    refused = [
        web.post("marks", here, headers=CHINESE).json,
        second,
        web.post("goals", b'{"kind": ', headers=CHINESE).json,
    ]
    for said in sentences(refused):
        assert not english_left(said), said


def test_a_page_is_named_in_the_language_of_the_request(web: Served, chassis: Chassis) -> None:
    """For programs its name is the same in each language."""
    with PageClient(web.port) as page:
        name = page.of("hello")["you"]
        page.say(t="lease", op="ask")
        page.of("lease", yours=True)
        refused = web.post("goals", {"kind": "move", "distance": 1.0}, headers=CHINESE).json
        assert refused["detail"].startswith("127.0.0.1 上的网页 1 正在控制这台机器人")
        assert refused["holder"] == name == "page 1 at 127.0.0.1"
        assert web.get("lease", headers=CHINESE).json["holder"] == name


@pytest.mark.structure
def test_each_command_of_the_journal_has_its_chinese() -> None:
    assert [text for text in COMMANDS.values() if not translator_for("zh").has(key_of(text))] == []
