"""`rosproto foxglove` and `woosh foxglove`: one line to open, nothing written, an end in order."""

from __future__ import annotations

import argparse
import json
import re
import sys
from pathlib import Path

import pytest

from rosproto.cli import main
from rosproto.cli.gateway import add_foxglove_arguments, server_options
from rosproto.master import Master
from tests.unit.gateway.test_websocket_server import certificate
from woosh_pure.cli import main as woosh

pytest.importorskip("websockets", reason="websockets is not installed")


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
    assert re.search(r"ws://127\.0\.0\.1:\d+/\?token=\S{20,} ", capsys.readouterr().out)


def test_tls(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    """The address says so; a certificate that cannot be used is told with its option."""
    pytest.importorskip("cryptography")
    cert, key = certificate(tmp_path)
    with Master() as master:
        common = ["foxglove", "--master", master.uri, "--port", "0", "--for", "0.05", "--tls-cert"]
        assert main([*common, cert, "--tls-key", key]) == 0
        assert "Serving Foxglove at wss://127.0.0.1:" in capsys.readouterr().out
        assert main([*common, key]) == 1
    assert "--tls-cert" in capsys.readouterr().err


@pytest.mark.promise("a page from a file sends")
def test_the_page_on_the_internet_may_look_and_not_write(capsys: pytest.CaptureFixture[str]) -> None:
    """Where something is open for writing it needs the token, or to be named; desktop programs come in."""
    page = "https://app.foxglove.dev"

    def told(*options: str) -> tuple[str, tuple[str, ...]]:
        parser = argparse.ArgumentParser()
        add_foxglove_arguments(parser)
        with Master() as master:
            assert main(["foxglove", "--master", master.uri, "--port", "0", "--for", "0.05", *options]) == 0
        return capsys.readouterr().out, server_options(parser.parse_args(list(options)))["origins"]

    for options, lets_in in (
        ((), True),
        (("--allow-write", "/say", "--read-only"), True),
        (("--allow-write", "/say"), False),
        (("--allow-write", "/say", "--token", "of-many-letters"), True),
        (("--allow-write", "/say", "--origin", page), True),
    ):
        said, origins = told(*options)
        assert "file://" in origins
        assert "null" not in origins
        assert (page in origins) is lets_in, options
        assert (f"open:  {page}/?ds=foxglove-websocket" in said) is lets_in
        assert (f"--origin {page}" in said) is not lets_in


def test_without_websockets_it_names_the_extra(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """As a sentence, and not as a traceback."""
    monkeypatch.setitem(sys.modules, "websockets.asyncio.server", None)
    with Master() as master:
        assert main(["foxglove", "--master", master.uri, "--port", "0"]) == 1
    assert 'pip install ".[foxglove]"' in capsys.readouterr().err


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
