"""Missions of a few lines, and waiting for what becomes of them."""

from __future__ import annotations

from collections.abc import Callable

from rosproto.errors import RosTimeout
from woosh_pure import Chassis, SimulatedChassis
from woosh_pure.missions import Mission, Missions, Phase, Run, parse

HEAD = 'mission = 1\nname = "test"\n'
GO = '[guards]; not_known = "go"'  # this simulated robot tells its state on change only


def mission(*steps: str, head: str = GO) -> Mission:
    """A mission of steps, one line each."""
    tables = "".join("[[step]]\n" + step.replace("; ", "\n") + "\n" for step in steps)
    return parse(HEAD + head.replace("; ", "\n") + "\n" + tables)


def run_of(missions: Missions) -> Run:
    run = missions.state.run
    assert run is not None
    return run


def reach(missions: Missions, accept: Callable[[Run], object], seconds: float = 20.0) -> Run:
    """Wait until the run is so, and return it."""
    try:
        missions.wait_for(lambda: bool(missions.state.run and accept(run_of(missions))), seconds)
    except RosTimeout:
        raise AssertionError(f"not within {seconds} s: {missions.state}") from None
    return run_of(missions)


def running(run: Run) -> bool:
    return run.phase is Phase.RUNNING


def stop_by(who: str, sim: SimulatedChassis, chassis: Chassis, missions: Missions) -> None:
    """Stop the robot by this program, another program, or the missions."""
    if who == "this program":
        chassis.stop()
    elif who == "another program":
        with Chassis(sim.master_uri) as other:
            assert other.stop(everything=True).standing
    else:
        assert missions.stop(by="Anna").standing
