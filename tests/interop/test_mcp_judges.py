"""`woosh mcp` before the judges of its protocol: `@modelcontextprotocol/conformance` and `@modelcontextprotocol/inspector`.

Of the suite's scenarios, those that call tools made for the suite do not apply.
"""

from __future__ import annotations

import functools
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


node = functools.cache(web_peers.new_node)


def judge(package: str, program: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run a program of npm's."""
    script = web_peers.npm_module(f"@modelcontextprotocol/{package}/{program}")
    words = [str(node()), str(script), *arguments]
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


def test_the_inspector_lists_the_tools(url: str) -> None:
    """Over HTTP; each has a description, schemas and annotations."""
    tools = {tool["name"]: tool for tool in inspected([url], "--method", "tools/list")["tools"]}
    assert {"state", "where", "marks", "stop"} <= tools.keys()
    assert "go_to_mark" not in tools, "it moves, and nobody has allowed that"
    for name, tool in tools.items():
        assert tool["description"], name
        assert tool["inputSchema"]["type"] == "object", name
        assert "readOnlyHint" in tool["annotations"], name


def test_the_inspector_calls_a_tool() -> None:
    """Over stdio: what it starts is a simulated robot."""
    answer = inspected(list(SERVER), "--method", "tools/call", "--tool-name", "state")
    assert not answer.get("isError"), answer
    assert answer["structuredContent"]["battery_percent"] == 87.0
