"""Names that a client advertises, and the requests that wait for its answers."""

from __future__ import annotations

import pytest

from rosproto.gateway.access import Refused
from rosproto.gateway.rosbridge.advertised_by_client import GONE, AdvertisedByClient, PendingRequest


@pytest.fixture
def provided() -> AdvertisedByClient[str, PendingRequest[str]]:
    made: AdvertisedByClient[str, PendingRequest[str]] = AdvertisedByClient("request")
    assert made.add("/a", "server of a")
    assert made.add("/b", "server of b")
    return made


def test_an_answer_goes_to_its_request_once(provided: AdvertisedByClient[str, PendingRequest[str]]) -> None:
    """By the id; a second answer, or one to nothing, is refused."""
    first, second = PendingRequest[str]("/a"), PendingRequest[str]("/a")
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


def test_a_name_that_ends_ends_its_requests(provided: AdvertisedByClient[str, PendingRequest[str]]) -> None:
    """Without an answer, and those of other names stay."""
    ended, stays = PendingRequest[str]("/a"), PendingRequest[str]("/b")
    assert provided.begin(ended) is provided.begin(stays) is None
    assert provided.remove("/a") == "server of a"
    assert provided.remove("/a") is None
    assert (ended.done.is_set(), ended.answer, stays.done.is_set()) == (True, None, False)
    assert provided.begin(PendingRequest("/a")) == GONE


def test_no_more_wait_than_may(provided: AdvertisedByClient[str, PendingRequest[str]]) -> None:
    """One that has ended makes room."""
    first = PendingRequest[str]("/a")
    assert provided.begin(first, 1) is None
    assert "too many" in str(provided.begin(PendingRequest("/b"), 1))
    provided.end(first)
    assert provided.begin(PendingRequest("/b"), 1) is None


def test_a_client_that_has_gone(provided: AdvertisedByClient[str, PendingRequest[str]]) -> None:
    """Its servers come back to be closed, everything ends, and nothing begins."""
    waiting = PendingRequest[str]("/b")
    assert provided.begin(waiting) is None
    assert provided.close() == ["server of a", "server of b"]
    assert waiting.done.is_set()
    assert not provided.add("/c", "late")
    assert provided.begin(PendingRequest("/c")) == GONE
    assert provided.close() == []
