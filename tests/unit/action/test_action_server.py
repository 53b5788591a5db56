"""The action server over a graph of its own: policies, cancels, ends, errors of the program."""

from __future__ import annotations

import threading

import pytest

from rosproto.action import ActionServer, GoalStatus
from rosproto.errors import CodecError, LocalProtocolError
from rosproto.time import Time
from tests.unit.action.fakegraph import (
    ACTION,
    ActionGoal,
    FakeNode,
    Feedback,
    Goal,
    GoalID,
    Graph,
    Result,
    SteppedClock,
)

G = GoalStatus
SECONDS = 20.0


class Bench:
    """A server, and the client's side of it."""

    def __init__(self, handler=None, **options) -> None:
        self.graph = Graph()
        self.node = FakeNode(self.graph, "/srv")
        self.clock = SteppedClock()
        self.changed = threading.Condition()
        self.results = []
        self.graph.subscribers.append(_Tap(self, "/act/result", self._on_result))
        self.graph.subscribers.append(_Tap(self, "/act/status", self._on_status))
        self.server = ActionServer(
            self.node, "/act", ACTION, handler or self.patient, clock=self.clock, **options
        )

    def _on_result(self, message) -> None:
        with self.changed:
            self.results.append((message.status.goal_id.id, G(message.status.status), message.status.text))
            self.changed.notify_all()

    def _on_status(self, message) -> None:
        with self.changed:
            self.changed.notify_all()

    def patient(self, goal) -> None:
        """Works until it is told to stop."""
        if not goal.wait_for_cancel(SECONDS):
            raise RuntimeError("nobody cancelled")
        goal.preempted(text="stopped")

    def send(self, goal_id, stamp=1, mode=0) -> None:
        goal = ActionGoal(goal_id=GoalID(id=goal_id, stamp=Time(stamp)), goal=Goal(mode=mode))
        self.graph.deliver("/act/goal", goal, "/client")

    def cancel(self, goal_id="", stamp=0) -> None:
        self.graph.deliver("/act/cancel", GoalID(id=goal_id, stamp=Time(stamp)), "/client")

    def wait_results(self, count):
        with self.changed:
            assert self.changed.wait_for(lambda: len(self.results) >= count, SECONDS), self.results
            return list(self.results)

    def wait_active(self, goal_id) -> None:
        """Wait until a status says that a goal is under way."""
        with self.changed:
            assert self.changed.wait_for(lambda: (goal_id, G.ACTIVE) in self.statuses()[-1], SECONDS)

    def statuses(self):
        return [
            [(s.goal_id.id, G(s.status)) for s in m.status_list]
            for m in list(self.graph.publishers["/act/status"].sent)
        ]


class _Tap:
    def __init__(self, bench, topic, callback) -> None:
        self.node, self.topic, self.callback = bench.node, topic, callback


@pytest.fixture
def make():
    benches = []

    def make(handler=None, **options):
        benches.append(Bench(handler, **options))
        return benches[-1]

    yield make
    for bench in benches:
        bench.server.close()


@pytest.mark.promise("Clients wait for a status before they take")
def test_status_is_published_at_once_latched_and_again_when_nothing_happens(make):
    bench = make()
    assert bench.statuses()[0] == []
    assert bench.graph.publishers["/act/status"].latch
    seen = threading.Event()
    bench.graph.subscribers.append(_Tap(bench, "/act/status", lambda m: seen.set()))
    assert seen.wait(SECONDS)


def test_a_goal_succeeds_with_result_feedback_and_texts(make):
    def handler(goal):
        assert (goal.id, goal.goal.mode, goal.client, goal.status) == ("a", 7, "/client", G.ACTIVE)
        goal.publish_feedback(Feedback(percent=0.5))
        goal.succeed(Result(percent=1.0), "there")

    bench = make(handler)
    bench.send("a", mode=7)
    assert bench.wait_results(1) == [("a", G.SUCCEEDED, "there")]
    (feedback,) = bench.graph.publishers["/act/feedback"].sent
    assert (feedback.feedback.percent, feedback.status.goal_id.id, feedback.status.status) == (0.5, "a", 1)
    (result,) = bench.graph.publishers["/act/result"].sent
    assert result.result.percent == 1.0
    assert [("a", G.ACTIVE)] in bench.statuses()


def test_a_returned_result_is_success(make):
    bench = make(lambda goal: Result(percent=0.25))
    bench.send("a")
    assert bench.wait_results(1) == [("a", G.SUCCEEDED, "")]
    assert bench.graph.publishers["/act/result"].sent[0].result.percent == 0.25


def test_results_and_feedback_may_be_dicts_of_their_fields(make):
    def handler(goal):
        goal.publish_feedback({"percent": 0.5})
        if goal.id == "a":
            return {"percent": 0.25}
        goal.abort({"percent": 0.75}, "stuck")
        return None

    bench = make(handler, concurrent=True)
    bench.send("a")
    bench.send("b")
    bench.wait_results(2)
    results = bench.graph.publishers["/act/result"].sent
    assert {m.status.goal_id.id: m.result.percent for m in results} == {"a": 0.25, "b": 0.75}
    assert [m.feedback.percent for m in bench.graph.publishers["/act/feedback"].sent] == [0.5, 0.5]


def test_feedback_of_another_type_is_an_error_at_the_call(make):
    problems = []

    def handler(goal):
        with pytest.raises(
            CodecError, match="feedback of /act is a woosh_msgs/StepControlFeedback"
        ) as caught:
            goal.publish_feedback(Result())
        problems.append(caught.value)
        goal.succeed()

    bench = make(handler)
    bench.send("a")
    assert bench.wait_results(1) == [("a", G.SUCCEEDED, "")]
    assert len(problems) == 1
    assert bench.graph.publishers["/act/feedback"].sent == []


def test_an_exception_aborts_with_its_text(make, caplog):
    def handler(goal):
        raise OSError("the wheel is off")

    bench = make(handler)
    bench.send("a")
    assert bench.wait_results(1) == [("a", G.ABORTED, "OSError: the wheel is off")]
    assert "wheel" in caplog.text


@pytest.mark.parametrize(
    ("returned", "words"),
    [
        (None, "without ending the goal"),
        (Feedback(), "is a woosh_msgs/StepControlResult or a dict of its fields"),
        ({"percentage": 1.0}, "'percentage' is not a field"),
        ("done", "not a str"),
    ],
)
def test_a_handler_that_ends_nothing_or_returns_nonsense_aborts_the_goal(make, returned, words):
    bench = make(lambda goal: returned)
    bench.send("a")
    ((_, status, text),) = bench.wait_results(1)
    assert status is G.ABORTED
    assert words in text


def test_a_handler_that_just_returns_after_a_cancel_was_preempted(make):
    bench = make(lambda goal: goal.wait_for_cancel(SECONDS) and None)
    bench.send("a")
    bench.cancel("a")
    assert bench.wait_results(1)[0][:2] == ("a", G.PREEMPTED)


def test_a_goal_can_succeed_although_it_was_cancelled(make):
    def handler(goal):
        goal.wait_for_cancel(SECONDS)
        goal.succeed(text="was done already")

    bench = make(handler)
    bench.send("a")
    bench.cancel("a")
    assert bench.wait_results(1) == [("a", G.SUCCEEDED, "was done already")]
    assert [("a", G.PREEMPTING)] in bench.statuses()


def test_a_newer_goal_replaces_the_one_under_way(make, monkeypatch):
    """Its start is published at once, not with the next round. A cancel before would end it without its handler."""
    monkeypatch.setattr("rosproto.action.server.STATUS_SECONDS", 1e6)
    bench = make()
    bench.send("a", 1)
    bench.send("b", 2)
    assert bench.wait_results(1) == [("a", G.PREEMPTED, "stopped")]
    bench.wait_active("b")
    bench.cancel("b")
    assert bench.wait_results(2)[1] == ("b", G.PREEMPTED, "stopped")


def test_of_waiting_goals_only_the_newest_is_kept(make):
    release = threading.Event()

    def handler(goal):
        if goal.id == "a":
            release.wait(SECONDS)
        goal.succeed()

    bench = make(handler)
    for name, stamp in (("a", 1), ("b", 2), ("c", 3)):
        bench.send(name, stamp)
    assert bench.results == [("b", G.RECALLED, "canceled: another goal was received")]
    release.set()
    assert bench.wait_results(3)[1:] == [("a", G.SUCCEEDED, ""), ("c", G.SUCCEEDED, "")]


def test_a_goal_older_than_the_last_one_is_recalled_also_when_that_one_has_ended(make):
    bench = make()
    bench.send("a", 5)
    bench.send("late", 4)
    assert bench.results == [("late", G.RECALLED, "canceled: another goal was received")]
    bench.cancel()
    assert bench.wait_results(2)[1][:2] == ("a", G.PREEMPTED)
    bench.send("still late", 4)
    assert bench.results[2:] == [("still late", G.RECALLED, "canceled: another goal was received")]


def test_goals_without_a_stamp_follow_each_other_by_the_servers_clock(make):
    bench = make(lambda goal: Result())
    for number, clock in enumerate((50, 50, 51)):
        bench.node.clock.time = Time(clock)
        bench.send(str(number), 0)
        assert bench.wait_results(number + 1)[number][1] is G.SUCCEEDED
    bench.send("ahead", 60)
    bench.wait_results(4)
    bench.send("before that", 0)
    assert bench.results[4][1] is G.RECALLED
    bench.node.clock.time = Time(60)
    bench.send("after that", 0)
    assert bench.wait_results(6)[5][1] is G.SUCCEEDED


def test_a_goal_without_a_stamp_is_not_cancelled_by_an_earlier_cancel_by_time(make):
    bench = make(lambda goal: Result())
    bench.cancel(stamp=1000)
    bench.send("a", 999)
    bench.send("b", 0)
    assert [r[1] for r in bench.wait_results(2)] == [G.RECALLED, G.SUCCEEDED]


def test_a_waiting_goal_that_is_cancelled_ends_preempted_in_its_turn_and_is_never_started(make):
    started = []
    release = threading.Event()

    def handler(goal):
        started.append(goal.id)
        release.wait(SECONDS)
        goal.succeed()

    bench = make(handler)
    bench.send("a", 1)
    bench.send("b", 2)
    bench.cancel("b")
    assert bench.statuses()[-1] == [("a", G.ACTIVE), ("b", G.RECALLING)]
    release.set()
    assert bench.wait_results(2)[1] == ("b", G.PREEMPTED, "canceled before it was started")
    bench.send("c", 3)
    bench.wait_results(3)
    assert started == ["a", "c"]


def test_concurrent_goals_run_side_by_side_and_are_cancelled_by_id_time_or_all(make):
    bench = make(concurrent=True)
    for name, stamp in (("a", 1), ("b", 2), ("c", 3), ("d", 4)):
        bench.send(name, stamp)
    assert [g.id for g in bench.server.goals] == ["a", "b", "c", "d"]
    bench.cancel("c")
    assert bench.wait_results(1)[0][0] == "c"
    bench.cancel(stamp=1)
    assert bench.wait_results(2)[1][0] == "a"
    bench.cancel()
    assert {r[0] for r in bench.wait_results(4)} == {"a", "b", "c", "d"}
    assert bench.server.goals == []


def test_a_cancel_before_its_goal_recalls_it(make):
    bench = make()
    bench.cancel("a")
    assert [("a", G.RECALLING)] in bench.statuses()
    bench.send("a")
    assert bench.results == [("a", G.RECALLED, "canceled before the goal arrived")]


def test_a_repeated_goal_is_worked_on_once(make):
    calls = []
    bench = make(lambda goal: calls.append(goal.id) or Result())
    bench.send("a")
    bench.wait_results(1)
    bench.send("a")
    assert len(bench.results) == 1
    assert calls == ["a"]


def test_goals_without_id_or_stamp_get_them(make):
    bench = make(lambda goal: Result())
    bench.node.clock.time = Time(50)
    bench.graph.deliver("/act/goal", ActionGoal(), "/client")
    bench.graph.deliver("/act/goal", ActionGoal(), "/client")
    ids = [r[0] for r in bench.wait_results(2)]
    assert len(set(ids)) == 2
    assert bench.graph.publishers["/act/result"].sent[0].status.goal_id.stamp == Time(50)


def test_ended_goals_stay_in_the_status_for_five_seconds(make):
    bench = make(lambda goal: Result())
    bench.send("a")
    bench.wait_results(1)
    bench.clock.now += 4.9
    bench.cancel(stamp=1)  # a status follows each cancel, also one that cancels nothing
    assert bench.statuses()[-1] == [("a", G.SUCCEEDED)]
    bench.clock.now += 0.2
    bench.cancel(stamp=1)
    assert bench.statuses()[-1] == []


def test_check_rejects_goals_with_its_reason(make, caplog):
    def check(goal):
        if goal.mode == 9:
            raise ValueError("odd")
        return None if goal.mode == 1 else "only mode 1"

    bench = make(lambda goal: Result(), check=check)
    for name, mode in (("a", 1), ("b", 2), ("c", 9)):
        bench.send(name, mode=mode)
    results = {r[0]: r[1:] for r in bench.wait_results(3)}
    assert results["a"][0] is G.SUCCEEDED
    assert results["b"] == (G.REJECTED, "only mode 1")
    assert results["c"] == (G.REJECTED, "the goal could not be checked: odd")


def test_more_goals_than_allowed_are_rejected(make):
    bench = make(concurrent=True, max_goals=2)
    for number in range(3):
        bench.send(str(number))
    assert bench.results == [("2", G.REJECTED, "more than 2 goals are under way")]


def test_mistakes_of_the_handler_are_told_to_it(make, monkeypatch):
    monkeypatch.setattr("rosproto.action.server._CLOSE_SECONDS", SECONDS)
    errors = []

    def handler(goal):
        for call in (lambda: goal.succeed(Feedback()), lambda: goal.succeed(text="ok"), goal.abort):
            try:
                call()
            except (CodecError, LocalProtocolError) as error:
                errors.append(type(error))
        try:
            goal.publish_feedback(Feedback())
        except LocalProtocolError as error:
            errors.append(type(error))

    bench = make(handler)
    bench.send("a")
    assert bench.wait_results(1) == [("a", G.SUCCEEDED, "ok")]
    bench.server.close()
    assert errors == [CodecError, LocalProtocolError, LocalProtocolError]


def test_closing_asks_handlers_to_stop_and_is_idempotent(make, monkeypatch):
    monkeypatch.setattr("rosproto.action.server._CLOSE_SECONDS", SECONDS)
    bench = make()
    bench.send("a")
    bench.server.close()
    bench.server.close()
    assert bench.results == [("a", G.PREEMPTED, "stopped")]
    assert bench.node.closers == []
    bench.send("b")
    assert len(bench.results) == 1


def test_closing_aborts_what_does_not_stop_in_time(make, monkeypatch):
    monkeypatch.setattr("rosproto.action.server._CLOSE_SECONDS", 0.05)
    release = threading.Event()
    bench = make(lambda goal: release.wait(SECONDS) and None)
    bench.send("a")
    bench.send("b", 2)
    bench.server.close()
    release.set()
    assert [(r[0], r[1]) for r in bench.results] == [("a", G.ABORTED), ("b", G.RECALLED)]
