"""JSON of clients: bounded before it is decoded, and one long text at a time."""

from __future__ import annotations

import importlib.util
import json
import sys
import threading
import time

import pytest

from rosproto import json_text
from rosproto.json_text import SHORT, SHORT_VALUES, JsonError, JsonReader, is_short


def refused(text: str | bytes, **limits: int) -> str:
    reader = JsonReader(limits.get("values", 100), limits.get("nesting", 10))
    with pytest.raises(JsonError) as problem:
        reader.read(text, limits.get("most", 1))
    return str(problem.value)


def test_what_is_read() -> None:
    """One text or several, as text or as UTF-8; nothing where there is nothing."""
    reader = JsonReader(100, 10)
    assert reader.read('{"a": [1, 2.5, null, "ü"]}') == [{"a": [1, 2.5, None, "ü"]}]
    assert reader.read('{"a": "ü"}'.encode()) == [{"a": "ü"}]
    assert reader.read(" {} [] 3\n", 3) == [{}, [], 3]
    assert reader.read(" \n") == []


def test_what_is_refused() -> None:
    """With a sentence that goes on after "the message"."""
    assert refused("{} {}") == "has more than 1 values in a row; send them one by one"
    assert refused('{"op": ') == "is not JSON: Expecting value at character 7"
    assert refused(b"\xff{}") == "is not UTF-8 text: invalid start byte at byte 0"
    assert refused("9" * 5000) == "is not JSON: a number has too many digits"
    for depth in (11, 40, 99):
        deep = "has more than 10 arrays and objects inside one another"
        assert refused("[" * depth + "]" * depth) == deep
    assert JsonReader(100, 10).read("[" * 10 + "]" * 10)
    deepest = "[" * 90_000 + "]" * 90_000
    assert "inside one another" in refused(deepest, values=100_000, nesting=64)


@pytest.mark.promise("A message is bounded in bytes, in nesting, and in its values and keys")
@pytest.mark.parametrize("one", ["0,", "[],", "{},", '"a",', '{"a":0},', "[[0]],"])
def test_values_are_counted_before_they_are_decoded(one: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Never fewer than there are."""

    class Decoder:
        def raw_decode(self, *given: object) -> None:
            raise AssertionError("decoded")

    monkeypatch.setattr(json_text, "_decoder", Decoder())
    assert "values and keys, and at most 100 are accepted" in refused("[" + one * 100 + "0]")
    assert "at most 100" in refused(("[" + one * 100 + "0]").encode())


@pytest.mark.promise("A message is bounded in bytes, in nesting, and in its values and keys")
def test_keys_count() -> None:
    """They take longer than anything else."""
    text = json.dumps({f"key {i}": 0 for i in range(60)})
    assert "values and keys" in refused(text)
    assert JsonReader(121, 10).read(text)


def test_long_numbers_on_early_pythons(monkeypatch: pytest.MonkeyPatch) -> None:
    """Python 3.10.0 to 3.10.6 read a number of any length, slowly: there we look first."""
    monkeypatch.delattr(sys, "get_int_max_str_digits", raising=False)
    spec = importlib.util.find_spec("rosproto.json_text")
    assert spec is not None
    assert spec.loader is not None
    early = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(early)
    reader = early.JsonReader(100, 10)
    with pytest.raises(early.JsonError, match="is not JSON: a number has too many digits"):
        reader.read("9" * 5000)
    assert reader.read("[12]") == [[12]]


def test_what_is_short() -> None:
    """By its length, and by its values."""
    assert is_short("x" * SHORT)
    assert not is_short("x" * (SHORT + 1))
    assert not is_short("0," * SHORT_VALUES)
    assert not is_short(b"0," * SHORT_VALUES)
    assert is_short(b'{"op": "publish"}')


@pytest.mark.promise("of all clients' long messages one is decoded at a time")
def test_one_long_text_is_decoded_at_a_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """While short ones pass: they take no time."""
    at_once: list[int] = []
    inside: list[int] = []
    begun, go_on = threading.Event(), threading.Event()
    real = json.JSONDecoder.raw_decode

    def raw_decode(decoder: json.JSONDecoder, text: str, at: int = 0) -> tuple[object, int]:
        if len(text) > SHORT:
            inside.append(1)
            at_once.append(len(inside))
            begun.set()
            go_on.wait(10)
            inside.pop()
        return real(decoder, text, at)

    monkeypatch.setattr(json.JSONDecoder, "raw_decode", raw_decode)
    reader = JsonReader(100, 10)
    long = json.dumps("x" * SHORT)
    threads = [threading.Thread(target=reader.read, args=(long,)) for _ in range(4)]
    for thread in threads:
        thread.start()
    assert begun.wait(10)
    began = time.monotonic()
    assert reader.read("[1]") == [[1]]
    assert time.monotonic() - began < 5
    go_on.set()
    for thread in threads:
        thread.join(10)
    assert at_once == [1, 1, 1, 1]
