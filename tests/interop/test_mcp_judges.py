"""`woosh mcp` before the judges of its protocol: `@modelcontextprotocol/conformance` and `@modelcontextprotocol/inspector`.

Of the suite's scenarios, those that call tools made for the suite do not apply.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.support import web_peers
from tests.support.extras import needs
from tests.support.ros_process import RosProcess

needs("mcp")
pytestmark = pytest.mark.slow

ROOT = Path(__file__).resolve().parents[2]
SCENARIOS = (
    "server-initialize",
    "ping",
    "tools-list",
    "resources-list",
    "prompts-list",
    "dns-rebinding-protection",
)
SERVER = (sys.executable, "-m", "woosh_pure", "--sim", "mcp")
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT), "PYTHONUNBUFFERED": "1"}


def judge(package: str, program: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run a program of npm's."""
    script = web_peers.npm_module(f"@modelcontextprotocol/{package}/{program}")
    words = [str(web_peers.new_node()), str(script), *arguments]
    return subprocess.run(words, capture_output=True, text=True, timeout=100, env=ENVIRONMENT, cwd=ROOT)


def inspected(target: list[str], *options: str) -> Any:
    """What the inspector is answered; for a URL its headers, for a command its environment are given."""
    program = "clients/launcher/build/index.js"
    more = [] if target[0].startswith("http") else ["-e", f"PYTHONPATH={ROOT}"]
    done = judge("inspector", program, "--cli", *options, *more, *target)
    assert done.returncode == 0, done.stderr + done.stdout
    return json.loads(done.stdout)


@pytest.fixture(scope="module")
def url() -> Iterator[str]:
    with RosProcess([*SERVER, "--http", "0"], ENVIRONMENT) as server:
        yield server.wait_for(r"http://[\w.:]+/mcp")[0]


@pytest.mark.parametrize("scenario", SCENARIOS)
def test_the_conformance_suite(scenario: str, url: str, tmp_path: Path) -> None:
    """The official suite finds nothing wrong."""
    done = judge(
        "conformance", "dist/index.js", "server", "--url", url, "--scenario", scenario, "-o", str(tmp_path)
    )
    assert done.returncode == 0, done.stdout + done.stderr
    checks = [
        check for file in sorted(tmp_path.rglob("checks.json")) for check in json.loads(file.read_text())
    ]
    assert checks
    assert [check for check in checks if check["status"] not in ("SUCCESS", "INFO")] == []


@pytest.mark.parametrize("way", ["stdio", "http"])
def test_the_inspector(way: str, request: pytest.FixtureRequest) -> None:
    """It lists the tools, each with a description and schemas, and calls one that reads."""
    target = list(SERVER) if way == "stdio" else [request.getfixturevalue("url")]
    tools = {tool["name"]: tool for tool in inspected(target, "--method", "tools/list")["tools"]}
    assert {"state", "where", "marks", "stop"} <= tools.keys()
    assert "go_to_mark" not in tools, "it moves, and nobody has allowed that"
    assert all(tool["description"] and tool["inputSchema"] and tool["annotations"] for tool in tools.values())
    answer = inspected(target, "--method", "tools/call", "--tool-name", "state")
    assert not answer.get("isError"), answer
    assert "battery" in json.dumps(answer["structuredContent"])
