"""Names that a client advertises, and the requests that wait for its answers."""

from __future__ import annotations

from typing import Any

import pytest

from rosproto.gateway.access import Refused
from rosproto.gateway.rosbridge.advertised_by_client import GONE, AdvertisedByClient, PendingRequest
from rosproto.gateway.rosbridge.operations import ServiceResponse

Request = PendingRequest[ServiceResponse]


class Provided(AdvertisedByClient[str, Request]):
    """Names whose servers are texts."""

    kind, prefix = "call", "request"

    def __init__(self) -> None:
        unused: Any = None
        super().__init__(unused, unused, unused)
        self.ended: list[str] = []

    def end(self, server: str) -> None:
        self.ended.append(server)


@pytest.fixture
def provided() -> Provided:
    made = Provided()
    made.add("/a", "server of a")
    made.add("/b", "server of b")
    return made


def answer(id: Any, text: str) -> ServiceResponse:
    return ServiceResponse(id, "", text)


def test_an_answer_goes_to_its_request_once(provided: Provided) -> None:
    """By the id; a second answer, or one to nothing, is refused."""
    first, second = Request("/a"), Request("/a")
    assert provided.begin(first) is None
    assert provided.begin(second) is None
    assert first.id != second.id
    yes = answer(second.id, "yes")
    provided.answer(yes)
    assert (second.answer, second.done.is_set(), first.done.is_set()) == (yes, True, False)
    for id in (second.id, "other", None):
        with pytest.raises(Refused, match="no call with the id"):
            provided.answer(answer(id, "again"))
    assert second.answer is yes
    assert provided.waiting(first.id) is first
    assert provided.waiting(second.id) is None


def test_a_name_that_ends_ends_its_requests(provided: Provided) -> None:
    """Without an answer, and those of other names stay."""
    ended, stays = Request("/a"), Request("/b")
    assert provided.begin(ended) is provided.begin(stays) is None
    provided.remove("/a")
    provided.remove("/a")
    assert provided.ended == ["server of a"]
    assert (ended.done.is_set(), ended.answer, stays.done.is_set()) == (True, None, False)
    assert provided.begin(Request("/a")) == GONE


def test_no_more_wait_than_may(provided: Provided) -> None:
    """One that has ended makes room."""
    first = Request("/a")
    assert provided.begin(first, 1) is None
    assert "too many" in str(provided.begin(Request("/b"), 1))
    provided.forget(first)
    assert provided.begin(Request("/b"), 1) is None


def test_a_client_that_has_gone(provided: Provided) -> None:
    """Its servers are closed, everything ends, and nothing begins."""
    waiting = Request("/b")
    assert provided.begin(waiting) is None
    provided.close()
    assert provided.ended == ["server of a", "server of b"]
    assert waiting.done.is_set()
    provided.add("/c", "late")
    assert provided.ended[2:] == ["late"]
    assert provided.begin(Request("/c")) == GONE
    provided.close()
    assert len(provided.ended) == 3
