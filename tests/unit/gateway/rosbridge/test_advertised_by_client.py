"""What a client provides to the graph, and the requests that wait for it."""

from __future__ import annotations

import pytest

from rosproto.gateway.access import Refused
from rosproto.gateway.rosbridge.advertised_by_client import GONE, ClientProvided, Request


@pytest.fixture
def provided() -> ClientProvided[str, Request[str]]:
    made: ClientProvided[str, Request[str]] = ClientProvided("request")
    assert made.add("/a", "server of a")
    assert made.add("/b", "server of b")
    return made


def test_an_answer_goes_to_its_request_once(provided: ClientProvided[str, Request[str]]) -> None:
    """By the id; a second answer, or one to nothing, is refused."""
    first, second = Request[str]("/a"), Request[str]("/a")
    assert provided.begin(first) is None
    assert provided.begin(second) is None
    assert first.id != second.id
    provided.answer(second.id, "yes", "call")
    assert (second.answer, second.done.is_set(), first.done.is_set()) == ("yes", True, False)
    for id in (second.id, "other", None):
        with pytest.raises(Refused, match="no call with the id"):
            provided.answer(id, "again", "call")
    assert second.answer == "yes"
    assert provided.waiting(first.id) is first
    assert provided.waiting(second.id) is None


def test_a_name_that_ends_ends_its_requests(provided: ClientProvided[str, Request[str]]) -> None:
    """Without an answer, and those of other names stay."""
    ended, stays = Request[str]("/a"), Request[str]("/b")
    assert provided.begin(ended) is provided.begin(stays) is None
    assert provided.remove("/a") == "server of a"
    assert provided.remove("/a") is None
    assert (ended.done.is_set(), ended.answer, stays.done.is_set()) == (True, None, False)
    assert provided.begin(Request("/a")) == GONE


def test_no_more_wait_than_may(provided: ClientProvided[str, Request[str]]) -> None:
    """One that has ended makes room."""
    first = Request[str]("/a")
    assert provided.begin(first, 1) is None
    assert "too many" in str(provided.begin(Request("/b"), 1))
    provided.end(first)
    assert provided.begin(Request("/b"), 1) is None


def test_a_client_that_has_gone(provided: ClientProvided[str, Request[str]]) -> None:
    """Its servers come back to be closed, everything ends, and nothing begins."""
    waiting = Request[str]("/b")
    assert provided.begin(waiting) is None
    assert provided.close() == ["server of a", "server of b"]
    assert waiting.done.is_set()
    assert not provided.add("/c", "late")
    assert provided.begin(Request("/c")) == GONE
    assert provided.close() == []
