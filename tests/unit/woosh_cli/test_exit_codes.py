"""What an error of each kind is to somebody who types commands: one sentence, and the exit code."""

from __future__ import annotations

import pytest

from rosproto.cli import explain
from rosproto.errors import ConnectionLost, MasterError, RosError, RosTimeout, ServiceError
from rosproto.sentence import Sentence, advice, both, say
from rosproto.transport.xmlrpc_client import XmlRpcClient
from tests.support.ports import unused_port
from tools.templates import advice_places, places_of
from woosh_pure.cli.entry import ADVICE
from woosh_pure.errors import ChassisError, GoalFailed, MotionRefused
from woosh_pure.outcome import Outcome, OutcomeKind
from woosh_pure.web.http_errors import ADVICE as FOR_CLIENTS


@pytest.mark.parametrize(
    ("error", "code"),
    [
        (RosError("x"), 1),
        (RosTimeout("x"), 1),
        (ServiceError("/s", "x"), 1),
        (MasterError("lookupNode", 0, "x"), 1),
        (ConnectionLost("x"), 4),
        (ChassisError("x"), 1),
        (MotionRefused("x"), 3),
        (type("OfTheUser", (MotionRefused,), {})("x"), 3),
        (GoalFailed(Outcome(OutcomeKind.FAILED, "mark A1")), 1),
        (GoalFailed(Outcome(OutcomeKind.CONNECTION_LOST, "mark A1")), 4),
        (ValueError("x"), 2),
        (OSError("x"), 1),
        (KeyError("x"), 1),
        (RuntimeError("x"), 1),
    ],
    ids=lambda value: type(value).__name__,
)
def test_the_exit_code_is_the_error_s(error: Exception, code: int) -> None:
    assert explain(error)[1] == code


def test_a_lost_connection_says_where_and_what_not_who_called_what() -> None:
    uri = f"http://127.0.0.1:{unused_port()}/"
    with XmlRpcClient(uri, timeout=5.0) as client, pytest.raises(ConnectionLost) as lost:
        client.call("getUri", "/me")
    text, code = explain(lost.value)
    assert text.startswith(f"{uri}: connection refused")
    assert code == 4
    assert f"getUri at {uri}" in str(lost.value)


def test_what_the_api_advises_is_said_for_commands() -> None:
    outcome = Outcome(OutcomeKind.FAILED, "mark A1", text="status code 110201000013")
    text, _ = explain(GoalFailed(outcome))
    assert isinstance(text, Sentence)
    assert text.endswith("see chassis.readiness() and chassis.faults")
    assert "status code 110201000013 (emergency stop" in text
    assert text.advised(ADVICE).endswith("see `woosh ready` and `woosh faults`")
    wrapped = RosError(say("{what}: {why}", what="x", why=GoalFailed(outcome)))
    assert isinstance(said := explain(wrapped)[0], Sentence)
    assert said.advised(ADVICE).endswith("see `woosh ready` and `woosh faults`")


def test_a_name_that_reads_like_advice_stays() -> None:
    """Nothing is replaced in a text."""
    name = "use go_to for longer distances"
    sentence = both(say("mark {name} is not known", name=name), advice(name, key="far"))
    assert (
        sentence.advised(ADVICE)
        == f"mark {name} is not known; for longer distances: woosh goto --pose X Y DEGREES"
    )


@pytest.mark.structure
@pytest.mark.parametrize("table", [ADVICE, FOR_CLIENTS], ids=["commands", "clients"])
def test_every_advice_is_for_a_sentence_that_somebody_says(table: dict[str, str]) -> None:
    """A key that nobody uses is a slip; a value that the sentence does not have could not be filled in."""
    places = advice_places()
    assert table.keys() <= places.keys()
    assert [key for key, text in table.items() if not places_of(text) <= places[key]] == []
