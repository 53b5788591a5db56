"""schemathesis (PyPI) against /openapi.json, with all its checks: what is documented is taken, what is not is
refused, and every answer is documented.
"""

from __future__ import annotations

import logging
import subprocess
from pathlib import Path

import pytest

pytest.importorskip("fastapi", reason="needs the extra `web`")
pytest.importorskip("uvicorn", reason="needs the extra `web`")
pytest.importorskip("websockets", reason="needs the extra `web`")

from rosproto.admission import TokenBucket
from tests.support.web import serving
from tests.support.web_peers import python_with
from woosh_pure import Chassis
from woosh_pure.maps.marks import UserMark

TOKEN = "a-long-secret"
EXAMPLES, SEED = 6, 30
HOOKS = """
import uuid

import schemathesis


@schemathesis.hook
def before_call(context, case, kwargs):
    if 0 < len(case.headers.get("Idempotency-Key", "")) <= 200:
        case.headers["Idempotency-Key"] = str(uuid.uuid4())
"""
CONFIG = """
# A key is for one request: another one with the same is refused with 422, however valid its body is. The description
# of the key says so; a schema cannot.
hooks = "hooks.py"

# A goal of a former step may be under way: do not wait five minutes for it.
[[operations]]
include-operation-id = "wait_for_goal"
parameters = { "query.timeout" = 0.2 }

# Which steps lead where in a mission is more than a schema says: a faulty one is refused with 422.
[[operations]]
include-operation-id = "save_mission"
checks = { positive_data_acceptance = { expected-statuses = ["2xx", "401", "403", "404", "409", "422", "5xx"] } }
"""


@pytest.mark.slow
@pytest.mark.timeout(450)  # each of the two runs has its own limit
def test_the_api_is_what_its_description_says(
    chassis: Chassis, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """The addresses below robots/NAME/ are left out: they have the same functions, and one lease. So is the stream of
    missions, which has no end.
    """
    python = python_with("schemathesis")
    monkeypatch.setattr(TokenBucket, "take", lambda *_: True)  # each request shall be looked at
    (tmp_path / "schemathesis.toml").write_text(CONFIG)
    (tmp_path / "hooks.py").write_text(HOOKS)
    bags, missions = tmp_path / "bags", tmp_path / "missions"
    bags.mkdir()
    marks = [UserMark("A1")]
    with serving(chassis, token=TOKEN, marks=marks, recordings=bags, missions=missions) as web:

        def run(*options: str) -> None:
            done = subprocess.run(
                [
                    *(str(python), "-m", "schemathesis.cli", "--config-file", "schemathesis.toml", "run"),
                    *("openapi.json", "--url", f"http://127.0.0.1:{web.port}"),
                    *("--seed", str(SEED), "--max-examples", str(EXAMPLES), "--generation-database", "none"),
                    *(
                        "--exclude-path-regex",
                        "/robots/{robot}/|/mission-events",
                        "--request-timeout",
                        "20",
                        "--no-color",
                    ),
                    *options,
                ],
                cwd=tmp_path,
                capture_output=True,
                text=True,
                timeout=200,
            )
            assert done.returncode == 0, (done.stdout + done.stderr)[-12000:]

        (tmp_path / "openapi.json").write_bytes(web.get("/openapi.json").body)
        # One check leaves the only required header out, the token: in a run with --header it is added again.
        run("--checks", "missing_required_header", "--phases", "coverage")
        token = ("--header", f"Authorization: Bearer {TOKEN}")
        run(*token, "--checks", "all", "--exclude-checks", "missing_required_header")
        assert web.post("stop").json["stands_still"] is True
    said = [record.getMessage() for record in caplog.records if record.levelno >= logging.ERROR]
    assert [text for text in said if "internal error" in text or "raised" in text or "ASGI" in text] == []
