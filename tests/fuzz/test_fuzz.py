"""The fuzz targets on their corpus and on a fixed handful of mutations: fast enough for every test run."""

from __future__ import annotations

import pytest

from tests.fuzz import harness

TARGETS, TOKENS = harness.load()


@pytest.mark.promise("gives a value or a documented error on *that one* connection")
@pytest.mark.parametrize("name", sorted(TARGETS))
def test_the_corpus_gives_values_or_documented_errors(name: str) -> None:
    inputs = harness.seeds(name)
    assert len(inputs) > 1, f"no seeds in tests/fuzz/corpus/{name}"
    kinds = {harness.run_one(name, TARGETS[name], data) for data in inputs}
    assert len(kinds) > 1, "seeds should reach a value and an error"


@pytest.mark.promise("nothing it sends raises an exception outside the protocol code")
@pytest.mark.parametrize("name", sorted(TARGETS))
def test_a_fixed_handful_of_mutations_finds_nothing(name: str) -> None:
    assert harness.fuzz(name, TARGETS[name], TOKENS.get(name, []), seed=1, runs=300) == 300


@pytest.mark.promise("every input that once broke one is kept as a test")
def test_every_corpus_belongs_to_a_target() -> None:
    folders = {path.name for path in harness.CORPUS.iterdir() if path.is_dir()}
    assert folders <= set(TARGETS)


def test_the_loop_finds_a_planted_bug() -> None:
    def planted(data: bytes) -> str:
        if b"\xff\xff\xff\xff" in data:
            raise KeyError("planted")
        return "fine"

    with pytest.raises(harness.Finding, match="planted") as caught:
        harness.fuzz("header", planted, [], seed=1, runs=20_000)
    assert b"\xff\xff\xff\xff" in caught.value.data
