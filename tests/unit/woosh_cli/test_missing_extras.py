"""A command whose extra is not installed says which one, before it connects or listens."""

from __future__ import annotations

import sys

import pytest

from woosh_pure.cli import main


@pytest.mark.parametrize(
    ("module", "extra", "words"),
    [
        ("fastapi", "web", ["--sim", "web", "--port", "0", "--no-browser"]),
        ("fastapi", "web", ["sim", "--robots", "2", "--port", "0"]),
        ("websockets.asyncio.server", "api", ["sim", "--robot-api", "0", "--port", "0"]),
        (
            "paho.mqtt.client",
            "fleet",
            ["--sim", "vda5050", "--broker", "mqtt://127.0.0.1:1", "--serial", "a"],
        ),
        ("websockets.asyncio.server", "foxglove", ["--sim", "foxglove", "--port", "0"]),
    ],
)
def test_it_names_the_extra(
    module: str,
    extra: str,
    words: list[str],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setitem(sys.modules, module, None)
    assert main(words) == 1
    told = capsys.readouterr().err
    assert f".[{extra}]" in told
    assert "this is a bug" not in told
