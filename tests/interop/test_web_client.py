"""A client that somebody else's generator makes from /openapi.json: it fetches at one mark and delivers at another."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest

pytest.importorskip("fastapi", reason="needs the extra `web`")
pytest.importorskip("uvicorn", reason="needs the extra `web`")
pytest.importorskip("websockets", reason="needs the extra `web`")

from tests.support.web import serving
from tests.support.web_peers import python_with
from woosh_pure import Chassis, SimulatedChassis
from woosh_pure.sim.site import built_in_site
from woosh_pure.web.maps import WebMark

TOKEN = "made-by-chance"
DELIVERY = """
import sys
from client import AuthenticatedClient
from client.api.goals import create_goal, wait_for_goal
from client.api.lease import ask_for_lease, give_lease_back
from client.api.state import get_marks, get_readiness
from client.api.stop import stop
from client.models import CarryGoal, CarryGoalDirection, LeaseRequest, MarkGoal, ProblemDocument

robot = AuthenticatedClient(base_url=sys.argv[1], token=sys.argv[2], timeout=70.0)
assert get_readiness.sync(client=robot).answer != "no"
assert ask_for_lease.sync(client=robot, body=LeaseRequest(seconds=120.0)).yours
fetch, deliver = [mark.name for mark in get_marks.sync(client=robot) if not mark.charger][:2]
for order in (
    CarryGoal(kind="carry", mark=fetch, direction=CarryGoalDirection.LOAD),
    CarryGoal(kind="carry", mark=deliver, direction=CarryGoalDirection.UNLOAD),
    MarkGoal(kind="mark", mark=fetch),
):
    goal = create_goal.sync(client=robot, body=order)
    while not goal.done:
        goal = wait_for_goal.sync(goal.id, client=robot, timeout=30.0)
    print(goal.text, flush=True)
    assert goal.arrived is True, goal
refused = create_goal.sync(client=robot, body=MarkGoal(kind="mark", mark=""))
assert isinstance(refused, ProblemDocument) and refused.status == 422, refused
assert stop.sync(client=robot).stands_still is True
assert give_lease_back.sync(client=robot).holder is None
print("delivered")
"""


@pytest.mark.slow
def test_a_generated_client_fetches_and_delivers(tmp_path: Path) -> None:
    python = python_with("openapi_python_client")
    marks = [WebMark(name, mark.pose, mark.charger) for name, mark in built_in_site().marks.items()]
    with (
        SimulatedChassis(full_graph=False, speed=8.0) as sim,
        Chassis(sim.master_uri) as chassis,
        serving(chassis, token=TOKEN, marks=marks) as web,
    ):
        (tmp_path / "openapi.json").write_bytes(web.get("/openapi.json").body)
        generate = ["-m", "openapi_python_client", "generate", "--path", "openapi.json", "--meta", "none"]
        run(python, tmp_path, *generate, "--output-path", "client")
        said = run(python, tmp_path, "-c", DELIVERY, f"http://127.0.0.1:{web.port}", TOKEN)
    assert said.splitlines()[-1] == "delivered"


def run(python: Path, folder: Path, *words: str) -> str:
    """What a program says; it must end well."""
    env = {**os.environ, "PYTHONPATH": str(folder), "NO_COLOR": "1"}
    done = subprocess.run(
        [str(python), *words], cwd=folder, env=env, capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 0, (done.stdout + done.stderr)[-3000:]
    return done.stdout
