"""The machine of missions against a slow, obvious model, and what must hold whatever comes.

MISSION_RUNS=10000 in the environment makes so many random runs; some minutes.
"""

from __future__ import annotations

import json
import os
from dataclasses import replace

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.support.mission_model import Model, No, events, missions
from woosh_pure.missions import machine

RUNS = int(os.environ.get("MISSION_RUNS", "60"))


def same_as_the_model(data: st.DataObject) -> None:
    """Apply random events to both; they agree after each, and the machine keeps its promises."""
    state, model, now = machine.State(), Model(), 0.0
    may_go = under_way = False
    pool = data.draw(st.lists(missions(), min_size=1, max_size=2))
    for _ in range(30):
        event, passed = events(data.draw, state, pool)
        now += passed
        try:
            after = machine.step(state, event.name, now, 1e9, **event.values)
        except machine.Refused:
            with pytest.raises(No):
                model.apply(event, now)
            continue
        model.apply(event, now)
        run, was = after.run, state.run
        one = None
        if run is not None:
            one = (run.entry.id, run.phase.value, run.at, bool(run.failure), run.paused, run.charging)
        assert (one, after.paused, [entry.id for entry in after.queue]) == model.seen(), event
        # A step begins where the token of a running run is a new one.
        begins = (
            run is not None and run.phase is machine.Phase.RUNNING and run.token != (was.token if was else 0)
        )
        assert ([run.step.do] if begins and run is not None and run.step else []) == model.begun, event
        # What was written down is read again as it was.
        assert machine.state_of(json.loads(json.dumps(after.to_json()))) == replace(after, disk="")
        # Nothing begins after a stop or a start of the program, before somebody says so.
        ended = event.name == "step_ended" and was is not None and event.token == was.token
        ended = ended and was is not None and was.phase is machine.Phase.RUNNING
        stops = event.name in ("stop", "restarted") or (ended and event.result is machine.Result.STOPPED)
        if event.name == "resume" or (event.name == "append" and (event.start or not state.paused)):
            may_go = True
        elif stops:
            may_go = False
        under_way = under_way and not ended and not stops
        if begins:
            assert may_go
            assert not after.disk
            assert run is not None
            assert not run.paused
            assert not under_way  # one at a time
            under_way = True
        state = after


@pytest.mark.slow
@pytest.mark.timeout(120 + RUNS // 5)
@settings(max_examples=RUNS, deadline=None, suppress_health_check=list(HealthCheck))
@given(st.data())
def test_the_machine_agrees_with_the_model(data: st.DataObject) -> None:
    """Whatever comes in whatever order, phases, places, queue and effects are the model's."""
    same_as_the_model(data)
