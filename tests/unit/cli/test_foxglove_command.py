"""`rosproto foxglove` and `woosh foxglove`: one line to open, nothing written, an end in order."""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path

import pytest

from rosproto.cli import main
from rosproto.master import Master
from woosh_pure.cli import main as woosh

pytest.importorskip("foxglove", reason="foxglove-sdk is not installed")


def test_it_says_where_it_serves(capsys: pytest.CaptureFixture[str]) -> None:
    """The address, what is open, the page to open; the end comes when it was asked for."""
    with Master() as master:
        assert main(["foxglove", "--master", master.uri, "--port", "0", "--for", "0.3"]) == 0
    out = capsys.readouterr().out
    assert re.search(
        r"^Serving Foxglove at ws://127\.0\.0\.1:\d+ \(read only: --allow-write PATTERN opens more\)$",
        out,
        re.M,
    )
    assert "https://app.foxglove.dev/?ds=foxglove-websocket&ds.url=ws%3A%2F%2F127.0.0.1%3A" in out


def test_other_computers_need_the_token_it_prints(capsys: pytest.CaptureFixture[str]) -> None:
    """One is made where none was given."""
    with Master() as master:
        assert (
            main(["foxglove", "--master", master.uri, "--bind", "0.0.0.0", "--port", "0", "--for", "0.1"])
            == 0
        )
    assert re.search(r"ws://0\.0\.0\.0:\d+/\?token=\S{20,} ", capsys.readouterr().out)


def test_without_the_sdk_it_names_the_extra(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """As a sentence, and not as a traceback."""
    monkeypatch.setitem(sys.modules, "foxglove", None)
    with Master() as master:
        assert main(["foxglove", "--master", master.uri, "--port", "0"]) == 1
    assert "pip install 'woosh-pure[foxglove]'" in capsys.readouterr().err


def test_a_port_in_use(capsys: pytest.CaptureFixture[str]) -> None:
    """Is told with the option that changes it."""
    with Master() as master:
        assert main(["foxglove", "--master", master.uri, "--port", str(master.port)]) == 1
    assert "--port" in capsys.readouterr().err


def test_the_layout_alone(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Asks no chassis."""
    assert woosh(["foxglove", "--layout", str(tmp_path / "woosh.json"), "--layout-only"]) == 0
    assert "3D!woosh" in json.loads((tmp_path / "woosh.json").read_text("utf-8"))["configById"]
    assert "woosh.json" in capsys.readouterr().out
    assert woosh(["foxglove", "--layout-only"]) == 2


@pytest.mark.slow
def test_the_chassis_for_viewers(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """`woosh foxglove --sim`: read only; with --allow-driving what drives is named."""
    assert woosh(["--sim", "--json", "foxglove", "--port", "0", "--for", "0.2"]) == 0
    assert json.loads(capsys.readouterr().out)["write"] == []
    assert woosh(["--sim", "--json", "foxglove", "--port", "0", "--for", "0.2", "--allow-driving"]) == 0
    assert "topic:/base_cmd_vel" in json.loads(capsys.readouterr().out)["write"]
