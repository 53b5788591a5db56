"""Each operation of /openapi.json with what its schema does not foresee: never a 500, always a problem in words."""

from __future__ import annotations

import json
import logging
import random
from collections.abc import Iterator
from contextlib import ExitStack
from typing import Any
from urllib.parse import quote

import pytest

pytest.importorskip("fastapi", reason="needs the extra `web`")
pytest.importorskip("uvicorn", reason="needs the extra `web`")
pytest.importorskip("websockets", reason="needs the extra `web`")

from tests.support.web import Answer, Served, serving
from woosh_pure import Chassis

EACH, EACH_OF_ROBOT = 10, 4
HOSTILE: list[Any] = [
    *(None, True, False, 0, -1, 1, 2**31, 2**63, 2**70, -(10**30), 0.5, -0.0, 1e308, 1e-320),
    *(
        "",
        " ",
        "x",
        "0",
        "null",
        "A1",
        "a" * 5000,
        "\x00",
        "\n\r\t",
        "../..",
        "%00%2e",
        "{}",
        "<script>",
        "'; --",
    ),
    *(
        "\u202e",
        "\ud800",
        "😀" * 200,
        "中文",
        [],
        [[]],
        [1, "x", None],
        {},
        {"": {}},
        {"kind": []},
        {"__class__": 1},
    ),
]
RAW = [
    *(b"", b"{", b"[", b'"', b"\xff\xfe", b"\x00" * 100, b"nul", b"NaN", b'{"x":NaN}', b'{"x":1e999}'),
    *(b"[" * 20_000, b'{"a":' * 5_000, b'{"kind":"mark","kind":1,"mark":"A1","mark":""}', b"1" * 60_000),
]
PLACES = [  # parts of an address
    *(
        "x",
        "0",
        "-1",
        "1",
        "999999999999999999999",
        "..",
        ".",
        " ",
        "%",
        "\x00",
        "\n",
        "😀",
        "中",
        "a" * 300,
        "a/b",
        "a?b",
    ),
    *("pose", "color", "depth", "jpg", "robot", "{goal}", "null", "True", "1e3", "%2e%2e"),
]
ENDLESS = ("/stream", "/wait")
"""These may take their time when what they are asked for is there."""


@pytest.fixture
def web(chassis: Chassis, monkeypatch: pytest.MonkeyPatch) -> Iterator[Served]:
    """A server that counts no orders: each shall be looked at."""
    with serving(chassis, marks=[]) as served:
        monkeypatch.setattr(served.app.state.context.access, "check_rate", lambda *_: None)  # type: ignore[attr-defined]
        yield served


class Guesses:
    """Makes requests from a description, most of them wrong in one place."""

    def __init__(self, document: dict[str, Any], seed: int) -> None:
        self._parts = document["components"]["schemas"]
        self._chance = random.Random(seed)

    def valid(self, schema: dict[str, Any]) -> Any:
        """Something that fits."""
        if "$ref" in schema:
            return self.valid(self._parts[schema["$ref"].rsplit("/", 1)[1]])
        for choice in ("oneOf", "anyOf"):
            if choice in schema:
                return self.valid(self._chance.choice(schema[choice]))
        if "const" in schema:
            return schema["const"]
        if "enum" in schema:
            return self._chance.choice(schema["enum"])
        kind = schema.get("type")
        if kind == "object":
            return {name: self.valid(part) for name, part in schema.get("properties", {}).items()}
        low = schema.get("minimum", schema.get("exclusiveMinimum", 0))
        made = {"boolean": True, "integer": low, "number": low + 0.5, "string": "x", "array": []}
        return made.get(str(kind))

    def body(self, schema: dict[str, Any]) -> bytes:
        """Of what fits, one part replaced; or something else altogether."""
        way = self._chance.random()
        if way < 0.25:
            return self._chance.choice(RAW)
        if way < 0.45:
            return json.dumps(self._chance.choice(HOSTILE)).encode()
        value = self.valid(schema)
        if isinstance(value, dict) and way < 0.95:
            key = self._chance.choice([*value, "more"])
            value[key] = self._chance.choice(HOSTILE)
        return json.dumps(value).encode()

    def request(self, path: str, operation: dict[str, Any]) -> tuple[str, bytes | None, dict[str, str]]:
        """Address, body and headers."""
        query = []
        for parameter in operation.get("parameters", ()):
            name, guess = parameter["name"], self._chance.choice(PLACES)
            if parameter["in"] == "path":
                path = path.replace(f"{{{name}}}", quote(guess, safe=""))
            else:
                query.append(f"{name}={quote(guess)}")
        content = operation.get("requestBody", {}).get("content", {}).get("application/json")
        headers = {
            "content-type": self._chance.choice(["application/json"] * 6 + ["text/plain", "x", "a/b;" * 50])
        }
        if self._chance.random() < 0.1:
            headers["x-woosh-session"] = self._chance.choice(["x", "é", "a" * 500, "null"])
        body = self.body(content["schema"]) if content else None
        return path + ("?" + "&".join(query) if query else ""), body, headers


def judge(asked: tuple[Any, ...], answer: Answer) -> None:
    """Whatever it was: a value, or a problem in words that is none of the server's own."""
    assert answer.status < 500 or answer.status in (501, 502, 503, 504), (asked, answer)
    if answer.status >= 400:
        assert answer.problem, (asked, answer)


def operations(document: dict[str, Any]) -> list[tuple[str, str, dict[str, Any]]]:
    """Method, path and description of each."""
    return [
        (method.upper(), path, operation)
        for path, found in document["paths"].items()
        for method, operation in found.items()
    ]


@pytest.mark.slow
def test_no_guess_brings_an_error_that_nobody_foresaw(web: Served, caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.WARNING)
    document = web.get("/openapi.json").json
    guesses, asked = Guesses(document, 20), 0
    for method, path, operation in operations(document):
        for _ in range(EACH_OF_ROBOT if "{robot}" in path else EACH):
            address, body, headers = guesses.request(path, operation)
            if address.partition("?")[0].endswith(ENDLESS) and "/pose/" in address:
                continue
            judge((method, address, body, headers), web.ask(method, address, body, headers=headers))
            asked += 1
    assert asked > 400
    assert [r.getMessage() for r in caplog.records if "unforeseen" in r.message or "ASGI" in r.message] == []
    assert web.post("stop").json["stands_still"] is True


def test_what_the_description_calls_fitting_is_taken(web: Served) -> None:
    """Otherwise the guesses are all refused for the same reason, and show nothing."""
    document = web.get("/openapi.json").json
    guesses = Guesses(document, 1)
    with ExitStack() as undo:
        undo.callback(web.post, "stop")
        for path in ("/api/v1/lease", "/api/v1/stop", "/api/v1/pose"):
            content = document["paths"][path]["post"]["requestBody"]["content"]["application/json"]
            body = guesses.valid(content["schema"])
            if "theta" in body:
                body["theta"] = (
                    0.5  # its limit, one turn, is told by the library, which asks whether it is in degrees
                )
            answer = web.post(path, body)
            assert answer.status == 200, answer
