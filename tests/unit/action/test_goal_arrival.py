"""Goals that never arrive, and goals that arrive after they were given up."""

from __future__ import annotations

import pytest

from rosproto.action import ActionClient, GoalStatus, sent_goal
from rosproto.errors import ConnectionLost
from rosproto.time import Time
from tests.unit.action.fakegraph import ACTION, FakeNode, Goal

ACTIVE, PREEMPTED, PREEMPTING = 1, 2, 6


def hear(graph, clock, seconds, *goals):
    """The server sends its status for a while, five times a second."""
    for _ in range(round(seconds * 5)):
        clock.advance(0.2)
        graph.status(*goals)


def test_a_goal_sent_into_a_connection_that_had_ended_is_lost(graph, client, clock):
    """actionlib waits for ever: the server is heard, and knows nothing of it."""
    handle = client.send_goal(Goal())
    hear(graph, clock, 4.8)
    assert not handle.done
    assert not handle.acknowledged
    hear(graph, clock, 0.4)
    assert (handle.done, handle.status) == (True, GoalStatus.LOST)
    with pytest.raises(ConnectionLost, match=r"is lost: /srv has not mentioned it in 5\.\d s") as caught:
        handle.wait(timeout=None)
    assert caught.value.peer == "/srv"


def test_a_goal_of_a_killed_program_does_not_arrive_late(graph, client):
    assert not graph.publishers["/act/goal"].linger
    assert graph.publishers["/act/cancel"].linger


def test_only_a_server_that_was_connected_to_the_goal_topic_is_asked(graph, client, clock):
    handle = client.send_goal(Goal())
    for _ in range(30):
        clock.advance(0.2)
        graph.status(server="/other")
    assert not handle.done
    graph.fake_subscribers["/act/goal"] = ["/other"]  # its server has gone
    graph.status(server="/other")
    assert handle.status is GoalStatus.LOST


def test_a_server_heard_again_after_silence_has_time_for_the_goal(graph, client, clock):
    """The status may be back on its connection before TCP has repeated the goal on its own."""
    handle = client.send_goal(Goal())
    hear(graph, clock, 1)
    clock.advance(10)
    hear(graph, clock, 1.8)
    assert not handle.done
    graph.status((handle.goal_id, ACTIVE))
    hear(graph, clock, 5, (handle.goal_id, ACTIVE))
    assert (handle.acknowledged, handle.done) == (True, False)


def test_a_goal_that_arrives_after_it_was_lost_is_cancelled_until_the_server_reacts(graph, client, clock):
    handle = client.send_goal(Goal())
    hear(graph, clock, 5.2)
    sent = graph.publishers["/act/cancel"].sent
    assert sent == []
    hear(graph, clock, 1.0, (handle.goal_id, ACTIVE))
    assert [(m.id, m.stamp) for m in sent] == [(handle.goal_id, Time())]
    graph.fake_subscribers["/act/cancel"].remove("/srv")
    hear(graph, clock, 1.0, (handle.goal_id, ACTIVE))  # nobody takes it just now
    graph.fake_subscribers["/act/cancel"].append("/srv")
    hear(graph, clock, 1.0, (handle.goal_id, ACTIVE))
    assert len(sent) == 2
    hear(graph, clock, 3.0, (handle.goal_id, PREEMPTING))
    hear(graph, clock, 3.0, (handle.goal_id, PREEMPTED))
    assert len(sent) == 2
    assert handle.status is GoalStatus.LOST


def test_a_goal_is_given_up_only_while_nobody_has_mentioned_it(graph, client, clock):
    one, two = client.send_goal(Goal()), client.send_goal(Goal())
    two.cancel()
    three = client.send_goal(Goal())
    graph.status((three.goal_id, ACTIVE))
    assert one.give_up()
    assert two.give_up()
    assert not three.give_up()
    assert not one.give_up()
    assert [h.status for h in (one, two, three)] == [GoalStatus.LOST, GoalStatus.LOST, GoalStatus.ACTIVE]
    cancelled = graph.publishers["/act/cancel"].sent
    hear(graph, clock, 0.4, (one.goal_id, ACTIVE), (three.goal_id, ACTIVE))
    assert [m.id for m in cancelled] == [two.goal_id, one.goal_id]


def test_goals_given_up_are_bounded_and_forgotten(graph, client, clock, monkeypatch):
    monkeypatch.setattr(sent_goal, "MAX_GIVEN_UP", 2)
    handles = [client.send_goal(Goal()) for _ in range(3)]
    for handle in handles:
        handle.give_up()
    clock.advance(0.1)
    graph.status(*[(handle.goal_id, ACTIVE) for handle in handles])
    sent = graph.publishers["/act/cancel"].sent
    assert [m.id for m in sent] == [handle.goal_id for handle in handles[1:]]
    clock.advance(121)
    graph.status(*[(handle.goal_id, ACTIVE) for handle in handles])
    assert len(sent) == 2


def test_waiting_for_ever_for_an_acknowledgement_can_be_chosen(graph, clock):
    with ActionClient(FakeNode(graph, "/me"), "/act", ACTION, ack_timeout=None, clock=clock) as client:
        handle = client.send_goal(Goal())
        hear(graph, clock, 30)
        assert not handle.done
