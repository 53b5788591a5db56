"""The action client over a graph of its own: order, races, lost servers, deadlines."""

from __future__ import annotations

import threading
from contextlib import suppress

import pytest

from rosproto.action import ActionClient, CommState, GoalStatus, goal_tracker
from rosproto.codec import encode
from rosproto.errors import CodecError, ConnectionLost, DefinitionError, LocalProtocolError, RosTimeout
from rosproto.time import Time
from tests.support.clock import FakeClock
from tests.unit.action.fakegraph import ACTION, FakeNode, Goal, Graph, Result

PENDING, ACTIVE, PREEMPTED, SUCCEEDED, ABORTED = 0, 1, 2, 3, 4
PREEMPTING = 6


@pytest.fixture
def live(graph):
    """A client whose waits are real: for callbacks, which come from another thread."""
    with ActionClient(FakeNode(graph, "/me"), "act", ACTION) as client:
        yield client


@pytest.mark.promise("A goal id whose stamp is zero")
def test_a_goal_goes_out_with_a_unique_id_and_no_stamp_of_this_computers_clock(graph, client):
    one, two = client.send_goal(Goal(mode=1)), client.send_goal(Goal(mode=2))
    first, second = graph.publishers["/act/goal"].sent
    assert (first.goal_id.id, second.goal_id.id) == (one.goal_id, two.goal_id)
    assert one.goal_id != two.goal_id
    assert one.goal_id.startswith("/me-")
    assert (first.goal_id.stamp, first.header.stamp) == (Time(), Time(100))
    one.cancel()
    assert graph.publishers["/act/cancel"].sent[0].stamp == Time()
    assert (first.goal.mode, second.goal.mode) == (1, 2)


def test_neither_goal_nor_cancel_is_latched(graph, client):
    assert not graph.publishers["/act/goal"].latch
    assert not graph.publishers["/act/cancel"].latch


def test_the_handle_is_known_before_the_goal_is_published(graph, client):
    publisher = graph.publishers["/act/goal"]
    plain = publisher.publish

    def publish_and_answer(message):
        plain(message)
        graph.result(message.goal_id.id, SUCCEEDED, "at once")

    publisher.publish = publish_and_answer
    handle = client.send_goal(Goal())
    assert handle.done
    assert handle.wait(0).percent == 1.0
    assert handle.text == "at once"


def test_a_goal_runs_and_its_result_is_waited_for(graph, client):
    handle = client.send_goal(Goal())
    assert handle.state is CommState.WAITING_FOR_GOAL_ACK
    graph.status((handle.goal_id, ACTIVE, "on it"))
    assert (handle.state, handle.status, handle.text, handle.server) == (
        CommState.ACTIVE, GoalStatus.ACTIVE, "on it", "/srv",
    )  # fmt: skip
    graph.result(handle.goal_id, SUCCEEDED, "there")
    result = handle.wait(1)
    assert isinstance(result, Result)
    assert handle.result is result
    assert handle.status is GoalStatus.SUCCEEDED


def test_transitions_and_feedback_come_in_order_in_one_thread_and_the_end_before_waiters_wake(graph, live):
    seen = []
    gate = threading.Event()

    def transition(handle):
        seen.append((handle.state.name, threading.current_thread().name))
        gate.wait(20)

    handle = live.send_goal(
        Goal(), transition=transition, feedback=lambda h, f: seen.append((f.percent, h.goal_id))
    )
    graph.status((handle.goal_id, ACTIVE))
    graph.feedback(handle.goal_id, 0.5)
    graph.result(handle.goal_id, PREEMPTED)
    woken = []
    waiter = threading.Thread(target=lambda: (handle.wait(20), woken.append(len(seen))))
    waiter.start()
    gate.set()
    waiter.join(20)
    names = [entry[0] for entry in seen]
    assert names == ["ACTIVE", 0.5, "PREEMPTING", "WAITING_FOR_RESULT", "DONE"]
    assert {entry[1] for entry in seen if entry[0] != 0.5} == {"rosproto:action callbacks /act"}
    assert woken == [5]


@pytest.fixture
def no_threads(monkeypatch):
    """A function after which no thread can be started."""

    def refuse(thread):
        raise RuntimeError("can't start new thread")

    return lambda: monkeypatch.setattr(threading.Thread, "start", refuse)


def test_callbacks_need_no_thread_that_is_started_after_the_goal_was_sent(graph, live, no_threads):
    """The server answers when the system starts no more threads."""
    seen = []
    handle = live.send_goal(Goal(), transition=lambda h: seen.append(h.state.name))
    no_threads()
    graph.status((handle.goal_id, ACTIVE))
    graph.result(handle.goal_id, SUCCEEDED)
    assert handle.wait(20).percent == 1.0
    assert seen == ["ACTIVE", "WAITING_FOR_RESULT", "DONE"]


def test_a_goal_whose_callbacks_get_no_thread_is_not_sent(graph, live, no_threads):
    no_threads()
    with pytest.raises(RuntimeError, match="can't start new thread"):
        live.send_goal(Goal(), transition=lambda h: None)
    assert graph.publishers["/act/goal"].sent == []
    assert live._goals.followed == {}
    assert live.send_goal(Goal()).state is CommState.WAITING_FOR_GOAL_ACK  # nobody is called for this one


def test_a_callback_may_wait_for_its_own_goal_and_cancel_it(graph, live):
    results = []
    handle = live.send_goal(
        Goal(), transition=lambda h: results.append(h.wait(1).percent) if h.done else None
    )
    graph.result(handle.goal_id, SUCCEEDED)
    handle.wait(20)
    assert results
    assert set(results) == {1.0}


def test_a_callback_that_raises_is_logged_and_the_goal_goes_on(graph, live, caplog):
    def bad(handle):
        raise RuntimeError("mine")

    handle = live.send_goal(Goal(), transition=bad)
    graph.result(handle.goal_id, SUCCEEDED)
    assert handle.wait(20)
    assert "mine" in caplog.text


def test_feedback_is_iterated_until_the_end(graph, client):
    handle = client.send_goal(Goal())
    for percent in (0.25, 0.5):
        graph.feedback(handle.goal_id, percent)
    graph.result(handle.goal_id, SUCCEEDED)
    assert [f.percent for f in handle.feedback()] == [0.25, 0.5]


def test_feedback_keeps_the_latest_hundred_and_counts_the_others(graph, client):
    handle = client.send_goal(Goal())
    for number in range(130):
        graph.feedback(handle.goal_id, number)
    graph.result(handle.goal_id, SUCCEEDED)
    assert [f.percent for f in handle.feedback()] == list(range(30, 130))
    assert handle.feedback_dropped == 30


def test_feedback_after_the_end_and_from_another_server_is_ignored(graph, client):
    handle = client.send_goal(Goal())
    graph.status((handle.goal_id, ACTIVE))
    graph.feedback(handle.goal_id, 0.1, server="/other")
    graph.result(handle.goal_id, SUCCEEDED)
    graph.feedback(handle.goal_id, 0.9)
    assert list(handle.feedback()) == []


def test_cancel_names_the_goal_and_waits_for_the_server(graph, client):
    handle = client.send_goal(Goal())
    graph.status((handle.goal_id, ACTIVE))
    assert handle.cancel()
    assert handle.state is CommState.WAITING_FOR_CANCEL_ACK
    (message,) = graph.publishers["/act/cancel"].sent
    assert (message.id, message.stamp) == (handle.goal_id, Time())
    graph.status((handle.goal_id, PREEMPTING))
    assert not handle.cancel(), "the server is cancelling it already"
    graph.result(handle.goal_id, PREEMPTED)
    handle.wait(1)
    assert not handle.cancel()
    assert len(graph.publishers["/act/cancel"].sent) == 1


def test_cancel_all_and_cancel_before_a_time(graph, client):
    client.cancel_all()
    client.cancel_before(Time(7, 5))
    assert [(m.id, m.stamp) for m in graph.publishers["/act/cancel"].sent] == [("", Time()), ("", Time(7, 5))]


def test_goals_and_cancels_that_nobody_would_receive_are_errors(graph, client):
    handle = client.send_goal(Goal())
    graph.fake_subscribers.clear()
    with pytest.raises(ConnectionLost, match="wait_for_server"):
        client.send_goal(Goal())
    for cancel in (handle.cancel, client.cancel_all):
        with pytest.raises(ConnectionLost, match="may still be running"):
            cancel()


def test_a_goal_of_another_type_is_refused(client):
    with pytest.raises(
        CodecError, match=r"a goal of /act is a woosh_msgs/StepControlGoal .*StepControlResult"
    ):
        client.send_goal(Result())


def test_a_goal_may_be_a_dict_of_its_fields(graph, client):
    handle = client.send_goal({"mode": 2, "useAvoid": True})
    (sent,) = graph.publishers["/act/goal"].sent
    assert (sent.goal.mode, sent.goal.useAvoid, sent.goal.stepControl) == (2, True, [])
    assert handle.goal == Goal(mode=2, useAvoid=True)


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"mod": 2}, "'mod' is not a field"),
        ({1: 2}, "keywords must be strings"),
        ("fast", r"a dict of its fields \(mode, useAvoid, stepControl\), not a str"),
        (None, "not a NoneType"),
        ([2, True, []], "not a list"),
    ],
)
def test_what_is_no_goal_is_an_error_that_says_what_is(graph, client, wrong, words):
    with pytest.raises(CodecError, match=words) as caught:
        client.send_goal(wrong)
    assert "/act" in str(caught.value)
    assert caught.value.type_name == "woosh_msgs/StepControlGoal"
    assert graph.publishers["/act/goal"].sent == []


def test_a_type_that_is_no_action_is_refused(graph):
    with pytest.raises(DefinitionError, match="no action"):
        ActionClient(FakeNode(graph, "/me"), "/act", Goal)
    with pytest.raises(DefinitionError):
        ActionClient(FakeNode(graph, "/me"), "/act", "std_msgs/String")


def test_a_restarted_server_that_knows_nothing_loses_the_goal(graph, client):
    handle = client.send_goal(Goal())
    graph.status((handle.goal_id, ACTIVE))
    graph.status()
    assert handle.done
    assert handle.status is GoalStatus.LOST
    with pytest.raises(ConnectionLost, match="restarted"):
        handle.wait(1)


def test_an_array_older_than_the_goal_does_not_lose_it(graph, client):
    handle = client.send_goal(Goal())
    graph.status()
    assert handle.state is CommState.WAITING_FOR_GOAL_ACK


def test_a_second_server_on_the_name_neither_loses_nor_ends_the_goal(graph, client):
    handle = client.send_goal(Goal())
    graph.status((handle.goal_id, ACTIVE))
    graph.status(server="/second")
    graph.status((handle.goal_id, ABORTED), server="/second")
    graph.result(handle.goal_id, ABORTED, server="/second")
    assert handle.state is CommState.ACTIVE
    graph.result(handle.goal_id, SUCCEEDED)
    assert handle.wait(1)
    assert handle.status is GoalStatus.SUCCEEDED


def test_a_silent_server_ends_the_wait_but_not_the_goal(graph, client, clock):
    handle = client.send_goal(Goal())
    graph.status((handle.goal_id, ACTIVE))
    before = clock.monotonic()
    with pytest.raises(ConnectionLost, match=r"no status from /srv for 5\.\d s.*may still be running"):
        handle.wait(timeout=None)
    assert 5.0 <= clock.monotonic() - before < 5.6
    assert not handle.done
    assert isinstance(handle.connection_error, ConnectionLost)
    with pytest.raises(ConnectionLost):
        next(handle.feedback(timeout=None))
    graph.status((handle.goal_id, ACTIVE))
    assert handle.connection_error is None
    graph.result(handle.goal_id, SUCCEEDED)
    assert handle.wait(1)


def test_a_result_that_was_sent_into_a_dead_connection_is_not_waited_for(graph, client, clock):
    """It is sent once; the server says for five seconds more that the goal succeeded, then forgets it."""
    handle = client.send_goal(Goal())
    graph.status((handle.goal_id, SUCCEEDED))
    assert handle.state is CommState.WAITING_FOR_RESULT
    clock.advance(5.0)
    graph.status((handle.goal_id, SUCCEEDED))
    clock.advance(4.5)
    graph.status()
    assert not handle.done
    clock.advance(0.6)
    graph.status()
    assert handle.status is GoalStatus.LOST
    with pytest.raises(ConnectionLost, match=r"says it ended \(SUCCEEDED\), but its result did not come"):
        handle.wait(timeout=None)


def test_a_goal_that_no_server_ever_mentions_is_noticed_too(graph, client):
    handle = client.send_goal(Goal())
    with pytest.raises(ConnectionLost, match="no status from any server"):
        handle.wait(timeout=None)


def test_silence_can_be_allowed(graph, clock):
    with ActionClient(FakeNode(graph, "/me"), "/act", ACTION, status_timeout=None, clock=clock) as client:
        handle = client.send_goal(Goal())
        with pytest.raises(RosTimeout):
            handle.wait(100)


def test_waiting_has_a_deadline_and_says_how_far_the_goal_is(graph, client):
    handle = client.send_goal(Goal())
    with pytest.raises(RosTimeout, match="WAITING_FOR_GOAL_ACK after 2 s; the server has not mentioned it"):
        handle.wait(2)
    graph.status((handle.goal_id, ACTIVE, "half way"))
    with pytest.raises(RosTimeout, match=r"ACTIVE after 1 s \(ACTIVE: half way\)") as caught:
        handle.wait(1)
    assert caught.value.seconds == 1
    with pytest.raises(RosTimeout):
        next(handle.feedback(1))


@pytest.mark.parametrize("what", ["client", "node"])
def test_closing_ends_a_wait(node, client, what):
    handle = client.send_goal(Goal())
    if what == "client":
        client.close()
    else:
        node.closed = True
    with pytest.raises(ConnectionLost, match=f"the {what} was closed"):
        handle.wait(None)


def test_a_closed_client_refuses_and_closing_twice_is_fine(graph, node, client):
    client.close()
    client.close()
    for call in (lambda: client.send_goal(Goal()), client.cancel_all, client.wait_for_server):
        with pytest.raises(LocalProtocolError, match="closed"):
            call()
    assert node.closers == []
    assert graph.subscribers == []


def test_waiting_for_the_server_says_which_part_is_missing():
    graph = Graph()
    with ActionClient(FakeNode(graph, "/me"), "/act", ACTION, clock=FakeClock()) as client:
        with pytest.raises(RosTimeout, match="nobody publishes /act/status"):
            client.wait_for_server(1)
        graph.unreachable["/act/status"] = ["http://robot:1"]
        with pytest.raises(
            RosTimeout,
            match="/act/status is published, but its publisher is not connected: http://robot:1 is",
        ):
            client.wait_for_server(1)
        graph.fake_publishers["/act/status"] = ["/srv"]
        with pytest.raises(RosTimeout, match="/srv publishes /act/status, but no status message came"):
            client.wait_for_server(1)
        graph.status()
        with pytest.raises(
            RosTimeout, match="/srv sends status, but is not connected to /act/goal, /act/cancel, "
        ):
            client.wait_for_server(1)
        graph.status()
        graph.fake_subscribers = {"/act/goal": ["/srv"], "/act/cancel": ["/srv"]}
        graph.fake_publishers |= {"/act/result": ["/srv"], "/act/feedback": ["/another"]}
        with pytest.raises(RosTimeout, match=r"not connected to /act/feedback$"):
            client.wait_for_server(1)
        graph.fake_publishers["/act/feedback"].append("/srv")
        graph.status()
        client.wait_for_server(1)
        assert client.servers == ["/srv"]


def test_a_server_that_fell_silent_is_not_ready(graph, client, clock):
    graph.status()
    clock.advance(6)
    with pytest.raises(RosTimeout):
        client.wait_for_server(1)


def test_finished_goals_are_forgotten_and_followed_ones_are_bounded(graph, client, monkeypatch):
    monkeypatch.setattr(goal_tracker, "MAX_GOALS", 3)
    handles = [client.send_goal(Goal()) for _ in range(4)]
    assert handles[0].status is GoalStatus.LOST
    for handle in handles[1:]:
        graph.result(handle.goal_id, SUCCEEDED)
    assert repr(client).endswith(" 0 goals>")


def test_a_cancel_at_once_needs_no_lock_and_its_bytes_are_those_of_any_cancel(
    graph, client, clock, monkeypatch
):
    goal = client.send_goal(Goal())
    held, release = threading.Event(), threading.Event()

    def hold(condition, timeout):
        """Waits with the condition's lock, which an interrupted frame may hold."""
        held.set()
        release.wait(20.0)
        clock.advance(timeout)
        return condition.wait(0)

    def wait():
        with suppress(ConnectionLost):  # nobody mentions the goal
            goal.wait(20.0)

    monkeypatch.setattr(clock, "wait", hold)
    thread = threading.Thread(target=wait)
    thread.start()
    assert held.wait(20.0)
    goal.cancel_at_once()
    assert not release.is_set()
    release.set()
    thread.join(20.0)
    (at_once,) = graph.publishers["/act/cancel"].sent
    goal.cancel()
    assert at_once == encode(graph.publishers["/act/cancel"].sent[1])
