"""The machine of missions against a slow, obvious model, and what must hold whatever comes."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.support.mission_model import Model, No, events, missions
from woosh_pure.missions import machine


def same_as_the_model(data: st.DataObject) -> None:
    """Apply random events to both; they agree after each, and the machine keeps its promises."""
    state, model, now = machine.State(), Model(), 0.0
    may_go = under_way = False
    pool = data.draw(st.lists(missions(), min_size=1, max_size=2))
    for _ in range(30):
        event, passed = events(data.draw, state, pool)
        now += passed
        try:
            after, effects = machine.step(state, event, now, 1e9)
        except machine.Refused:
            with pytest.raises(No):
                model.apply(event, now)
            continue
        model.apply(event, now)
        run = after.run
        one = None
        if run is not None:
            one = (run.entry.id, run.phase.value, run.at, bool(run.failure), run.paused, run.charging)
        assert (one, after.paused, [entry.id for entry in after.queue]) == model.seen(), event
        plain = [
            ("carry", each.step.do) if isinstance(each, machine.Carry)
            else ("hold", each.held) if isinstance(each, machine.Hold) else ("cancel",)
            for each in effects
        ]  # fmt: skip
        assert plain == model.effects, event
        # What was written down is read again as it was.
        assert machine.state_of(json.loads(json.dumps(after.to_json()))) == replace(after, disk="")
        # Nothing begins after a stop or a start of the program, before somebody says so.
        was = state.run
        ended = isinstance(event, machine.StepEnded) and was is not None and event.token == was.token
        ended = ended and was is not None and was.phase is machine.Phase.RUNNING
        if isinstance(event, machine.Resume) or (
            isinstance(event, machine.Append) and (event.start or not state.paused)
        ):
            may_go = True
        elif isinstance(event, (machine.Stop, machine.Restarted)) or (
            ended and event.result is machine.Result.STOPPED
        ):
            may_go = False
        under_way = under_way and not ended and not isinstance(event, (machine.Stop, machine.Restarted))
        begins = [each for each in effects if isinstance(each, machine.Carry)]
        if begins:
            assert may_go
            assert len(begins) == 1
            assert not after.disk
            assert run is not None
            assert not run.paused
            assert not under_way  # one at a time
            under_way = True
        state = after


@settings(max_examples=200, deadline=None, suppress_health_check=list(HealthCheck))
@given(st.data())
def test_the_machine_agrees_with_the_model(data: st.DataObject) -> None:
    """Whatever comes in whatever order, phases, places, queue and effects are the model's."""
    same_as_the_model(data)


@pytest.mark.whole
@pytest.mark.timeout(1200)
@settings(max_examples=10_000, deadline=None, suppress_health_check=list(HealthCheck))
@given(st.data())
def test_ten_thousand_random_runs_agree_with_the_model(data: st.DataObject) -> None:
    """The same, 10,000 times."""
    same_as_the_model(data)
