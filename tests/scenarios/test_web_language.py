"""The sentences in answers of the REST API are in the language of the request, `Accept-Language`."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("fastapi", reason="needs the extra `web`")
pytest.importorskip("uvicorn", reason="needs the extra `web`")

from tests.support.web import Served, serving
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
    for said in sentences(answers):
        assert not english_left(said), said
    text = " ".join(sentences(answers))
    for words in ("直行 5.000 米", "直行 5.00 米", "已取消", "机器人已停稳", "127.0.0.1 上的程序停止了机器人"):
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
    for said in sentences(refused.json):
        assert not english_left(said.replace("nowhere", "")), said
    journal = web.get("journal", headers=CHINESE).json[-1]
    assert journal["what"] == "前往“nowhere”"
    assert web.get("journal").json[-1]["what"] == "go to nowhere"


@pytest.mark.structure
def test_each_command_of_the_journal_has_its_chinese() -> None:
    assert [text for text in COMMANDS.values() if not translator_for("zh").has(key_of(text))] == []
