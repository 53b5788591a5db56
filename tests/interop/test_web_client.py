"""A client that somebody else's generator makes from /openapi.json runs examples/rest/delivery.py."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("fastapi", reason="needs the extra `web`")
pytest.importorskip("uvicorn", reason="needs the extra `web`")
pytest.importorskip("websockets", reason="needs the extra `web`")

from tests.support.web import serving
from tests.support.web_peers import python_with
from woosh_pure import Chassis, SimulatedChassis
from woosh_pure.maps.marks import UserMark
from woosh_pure.sim.site import built_in_site

TOKEN = "made-by-chance"
EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "rest" / "delivery.py"
MORE = """
import sys
from woosh_client import AuthenticatedClient
from woosh_client.api.goals import create_goal
from woosh_client.api.lease import get_lease
from woosh_client.api.stop import stop
from woosh_client.models import MarkGoal, PoseGoal, ProblemDocument

robot = AuthenticatedClient(base_url=sys.argv[1], token=sys.argv[2], timeout=70.0)
assert get_lease.sync(client=robot).holder is None, "the example has given it back"
refused = create_goal.sync(client=robot, body=MarkGoal(kind="mark", mark=""))
assert isinstance(refused, ProblemDocument) and refused.status == 422, refused
for name in ("yaw", "theta"):
    body = PoseGoal(kind="pose", x=0.0, y=0.0, **{name: 0.5})
    goals = [create_goal.sync(client=robot, body=body, idempotency_key=name) for _ in range(2)]
    assert goals[0].id == goals[1].id, goals
    assert stop.sync(client=robot).stands_still is True
"""


def test_the_example_says_how_the_client_is_made(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, str(EXAMPLE)],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=20,
    )
    assert done.returncode == 1
    assert "generate the client first" in done.stderr


@pytest.mark.slow
def test_a_generated_client_fetches_and_delivers(tmp_path: Path) -> None:
    python = python_with("openapi_python_client")
    marks = [UserMark(name, mark.pose, charger=mark.charger) for name, mark in built_in_site().marks.items()]
    with (
        SimulatedChassis(full_graph=False, speed=8.0) as sim,
        Chassis(sim.master_uri) as chassis,
        serving(chassis, token=TOKEN, marks=marks) as web,
    ):
        (tmp_path / "openapi.json").write_bytes(web.get("/openapi.json").body)
        generate = ["-m", "openapi_python_client", "generate", "--path", "openapi.json", "--meta", "none"]
        run(python, tmp_path, *generate, "--output-path", "woosh_client")
        address = f"http://127.0.0.1:{web.port}"
        said = run(python, tmp_path, str(EXAMPLE), address, TOKEN)
        run(python, tmp_path, "-c", MORE, address, TOKEN)
    assert said.count("arrived") == 3, said
    assert said.splitlines()[-1] == "delivered from A1 to A2"


def run(python: Path, folder: Path, *words: str) -> str:
    """What a program says; it must end well."""
    env = {**os.environ, "PYTHONPATH": str(folder), "NO_COLOR": "1"}
    done = subprocess.run(
        [str(python), *words], cwd=folder, env=env, capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 0, (done.stdout + done.stderr)[-3000:]
    return done.stdout
