"""`rosproto dynparam` against a node that serves what dynamic_reconfigure serves."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from rosproto import Master, Node
from rosproto.cli import main
from tests.support.tunable import Tunable


@pytest.fixture
def dynparam(capsys: pytest.CaptureFixture[str]) -> Iterator[Callable[..., tuple[int, str, str]]]:
    with Master() as master, Node("/camera", master_uri=master.uri) as node:
        Tunable(node, "/camera")
        node.service_server("/other/set_parameters", "std_srvs/Empty", lambda request: None)

        def call(*words: str) -> tuple[int, str, str]:
            code = main(["dynparam", *words, "--master", master.uri])
            return code, *capsys.readouterr()

        yield call


def test_list(dynparam: Callable[..., tuple[int, str, str]]) -> None:
    """Only what serves all of it."""
    assert dynparam("list")[:2] == (0, "/camera\n")
    assert json.loads(dynparam("list", "--json")[1]) == ["/camera"]


def test_get_and_describe(dynparam: Callable[..., tuple[int, str, str]]) -> None:
    assert dynparam("get", "camera")[1] == "enabled: true\nmode: slow\nsize: 3\nspeed: 0.5\n"
    assert dynparam("get", "/camera", "speed")[1] == "0.5\n"
    assert json.loads(dynparam("get", "/camera", "--json")[1])["size"] == 3
    out = dynparam("describe", "/camera")[1]
    assert "speed (double, None to 1.0, default 0.5): the speed\n" in out
    assert "mode (str, default 'slow'): the mode\n" in out


def test_set(dynparam: Callable[..., tuple[int, str, str]]) -> None:
    """One, or several; the type is the node's, and what it makes of a value is said."""
    assert dynparam("set", "/camera", "size", "7")[:2] == (0, "size: 7\n")
    assert dynparam("set", "/camera", "{enabled: false, mode: 12, speed: 1}")[0] == 0
    values = json.loads(dynparam("get", "/camera", "--json")[1])
    assert values == {"enabled": False, "mode": "12", "size": 7, "speed": 1.0}
    out = dynparam("set", "/camera", "speed", "5.5")[1]
    assert out.startswith("speed: 1.0\n")
    assert "5.5" in out
    assert dynparam("set", "/camera", "enabled", "on", "--json")[1].startswith('{"enabled": true')


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (("set", "/camera", "sise", "7"), 1, "did you mean size?"),
        (("set", "/camera", "size", "7.5"), 2, "is not a valid int"),
        (("set", "/camera", "enabled", "perhaps"), 2, "is not a valid bool"),
        (("set", "/camera", "size"), 2, "write NAME VALUE"),
        (("get", "/camera", "sped"), 1, "did you mean speed?"),
        (("get", "/camra", "--timeout", "0.2"), 1, "did you mean /camera?"),
    ],
)
def test_what_cannot_be_is_said(
    dynparam: Callable[..., tuple[int, str, str]], words: tuple[str, ...], code: int, said: str
) -> None:
    found, _, err = dynparam(*words)
    assert found == code
    assert said in err


def test_dump_and_load(dynparam: Callable[..., tuple[int, str, str]], tmp_path: Path) -> None:
    file = tmp_path / "camera.yaml"
    assert dynparam("dump", "/camera", str(file))[0] == 0
    assert dynparam("set", "/camera", "{size: 1, mode: fast}")[0] == 0
    assert dynparam("load", "/camera", str(file))[0] == 0
    assert json.loads(dynparam("get", "/camera", "--json")[1])["size"] == 3
    file.write_text("- 1\n")
    assert "expected name: value" in dynparam("load", "/camera", str(file))[2]
