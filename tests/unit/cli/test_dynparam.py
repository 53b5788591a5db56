"""`rosproto dynparam` against a node that serves what dynamic_reconfigure serves."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from rosproto import Master, Node
from rosproto.cli import main
from rosproto.codec import message_class
from rosproto.codec.dicts import from_dict

Config = message_class("dynamic_reconfigure/Config")
Description = message_class("dynamic_reconfigure/ConfigDescription")
FIELDS = ("bools", "ints", "strs", "doubles")
START = {
    "bools": [{"name": "enabled", "value": True}],
    "ints": [{"name": "size", "value": 3}],
    "strs": [{"name": "mode", "value": "slow"}],
    "doubles": [{"name": "speed", "value": 0.5}],
}
KINDS = {"enabled": "bool", "size": "int", "mode": "str", "speed": "double"}
DESCRIPTION = {
    "groups": [
        {
            "name": "Default",
            "parameters": [{"name": n, "type": k, "description": f"the {n}"} for n, k in KINDS.items()],
        }
    ],
    "max": {"doubles": [{"name": "speed", "value": 1.0}], "ints": [{"name": "size", "value": 9}]},
    "dflt": START,
}


class Tunable:
    """As dynamic_reconfigure's server: latched description and values, a service; speed is brought into its range."""

    def __init__(self, node: Node, name: str) -> None:
        self.values = from_dict(Config, START)
        self._updates = node.publisher(f"{name}/parameter_updates", Config, latch=True)
        self._updates.publish(self.values)
        node.publisher(f"{name}/parameter_descriptions", Description, latch=True).publish(
            from_dict(Description, DESCRIPTION)
        )
        node.service_server(f"{name}/set_parameters", "dynamic_reconfigure/Reconfigure", self._set)

    def _set(self, request: Any) -> dict[str, Any]:
        for field in FIELDS:
            new = {one.name: one.value for one in getattr(request.config, field)}
            for one in getattr(self.values, field):
                one.value = new.get(one.name, one.value)
        self.values.doubles[0].value = min(1.0, self.values.doubles[0].value)
        self._updates.publish(self.values)
        return {"config": self.values}


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
        (("set", "/camera", "size", "7.5"), 1, "is no int"),
        (("set", "/camera", "enabled", "perhaps"), 1, "is no bool"),
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
