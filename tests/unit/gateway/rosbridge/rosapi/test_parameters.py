"""Parameters through /rosapi: JSON both ways, and no way around a pattern."""

from __future__ import annotations

import json
from collections.abc import Iterator

import pytest

from rosproto.gateway.access import Access
from rosproto.gateway.rosbridge.rosapi import Rosapi, RosapiError
from rosproto.master import Master
from rosproto.node import Node

OPEN = Access(write=("*",))


@pytest.fixture
def node() -> Iterator[Node]:
    """The gateway's node, with some parameters."""
    with Master() as master, Node("/gateway", master_uri=master.uri, rosout=False) as node:
        node.params["/speed"] = 0.5
        node.params["/robot"] = {"name": "ö", "secret": {"key": "s3cret"}, "size": [1, 2.5, True]}
        yield node


def get(rosapi: Rosapi, name: str, default: str = "") -> object:
    value = rosapi.call("/rosapi/get_param", {"name": name, "default": default})["value"]
    assert isinstance(value, str)
    return json.loads(value)


def test_values_are_json(node: Node) -> None:
    """Numbers, texts, lists and namespaces; a default where nothing is set, and null without one."""
    rosapi = Rosapi(node, OPEN)
    assert get(rosapi, "/speed") == 0.5
    assert get(rosapi, "robot/size") == [1, 2.5, True]
    assert get(rosapi, "//robot/")["name"] == "ö"  # type: ignore[index]
    assert get(rosapi, "/none") is None
    assert get(rosapi, "/none", "[1]") == [1]
    assert get(rosapi, "/none", "no JSON") == "no JSON"
    node.params["/odd"] = [float("nan"), float("inf"), b"\x00\xff"]
    assert get(rosapi, "/odd") == [None, None, "AP8="]


def test_setting_deleting_searching(node: Node) -> None:
    """A set value is read back; deleting twice is not an error; names are sorted."""
    rosapi = Rosapi(node, OPEN)
    assert rosapi.call("/rosapi/set_param", {"name": "/new", "value": '{"a": [1, "x"]}'}) == {}
    assert node.params["/new/a"] == [1, "x"]
    assert rosapi.call("/rosapi/has_param", {"name": "/new"}) == {"exists": True}
    assert rosapi.call("/rosapi/search_param", {"name": "speed"}) == {"global_name": "/speed"}
    assert rosapi.call("/rosapi/search_param", {"name": "none"}) == {"global_name": ""}
    for _ in range(2):
        assert rosapi.call("/rosapi/delete_param", {"name": "/new"}) == {}
    assert rosapi.call("/rosapi/has_param", {"name": "/new"}) == {"exists": False}
    names = rosapi.call("/rosapi/get_param_names")["names"]
    assert isinstance(names, list)
    assert names == sorted(names)
    assert "/robot/secret/key" in names


@pytest.mark.parametrize(
    "value", ["", "{", "plain text", "null", "[" * 5000, '{"a": {}, "b/c": 1}', "1e99999x", "9" * 30]
)
def test_a_value_that_cannot_be_set_is_a_sentence(node: Node, value: str) -> None:
    """Text that is not JSON, null, keys with slashes, numbers without end."""
    with pytest.raises(RosapiError, match="parameter"):
        Rosapi(node, OPEN).call("/rosapi/set_param", {"name": "/x", "value": value})
    assert not node.params.has("/x")


@pytest.mark.promise("a million characters at most, a parameter's value 32 levels, an answer 300 types")
def test_deep_values_are_refused(node: Node) -> None:
    """A value of a client is not nested without end."""
    value = '{"a":' * 40 + "1" + "}" * 40
    with pytest.raises(RosapiError, match="nested deeper"):
        Rosapi(node, OPEN).call("/rosapi/set_param", {"name": "/x", "value": value})


@pytest.mark.promise("A pattern cannot be evaded through a namespace of parameters")
def test_nothing_is_written_by_default(node: Node) -> None:
    """Without a pattern, and where everything is read only, neither set nor deleted."""
    for access in (Access(), Access(write=("*",), read_only=True), Access(write=("topic:*", "/other"))):
        rosapi = Rosapi(node, access)
        with pytest.raises(RosapiError, match="refused"):
            rosapi.call("/rosapi/set_param", {"name": "/speed", "value": "9"})
        with pytest.raises(RosapiError, match="refused"):
            rosapi.call("/rosapi/delete_param", {"name": "/speed"})
    assert node.params["/speed"] == 0.5


@pytest.mark.promise("No answer of `/rosapi` contains a name that `Access` hides")
@pytest.mark.parametrize(
    "name", ["/robot/secret/key", "robot/secret/key", "//robot//secret//key/", "/robot/secret"]
)
def test_a_hidden_parameter_is_not_read(node: Node, name: str) -> None:
    """By whatever spelling: refused, not there, in no list."""
    rosapi = Rosapi(node, Access(deny=("/robot/secret*",), write=("*",)))
    for call in ("get_param", "delete_param"):
        with pytest.raises(RosapiError, match="not open here"):
            rosapi.call(f"/rosapi/{call}", {"name": name})
    with pytest.raises(RosapiError, match="not open here"):
        rosapi.call("/rosapi/set_param", {"name": name, "value": "1"})
    assert rosapi.call("/rosapi/has_param", {"name": name}) == {"exists": False}
    assert node.params["/robot/secret/key"] == "s3cret"


@pytest.mark.promise("A pattern cannot be evaded through a namespace of parameters")
def test_a_namespace_is_no_way_around(node: Node) -> None:
    """Reading omits hidden parameters; writing or deleting is refused because of them."""
    rosapi = Rosapi(node, Access(deny=("/robot/secret*",), write=("*",)))
    assert get(rosapi, "/robot") == {"name": "ö", "size": [1, 2.5, True]}
    assert "s3cret" not in json.dumps(get(rosapi, "/"))
    assert "/robot/secret/key" not in rosapi.call("/rosapi/get_param_names")["names"]  # type: ignore[operator]
    for call, args in (
        ("delete_param", {"name": "/robot"}),
        ("set_param", {"name": "/robot", "value": "{}"}),
        ("set_param", {"name": "/", "value": "{}"}),
        ("delete_param", {"name": "/"}),
        ("set_param", {"name": "/robot/", "value": '{"secret": {"key": 1}}'}),
    ):
        with pytest.raises(RosapiError, match="not open here"):
            rosapi.call(f"/rosapi/{call}", args)
    assert node.params["/robot/secret/key"] == "s3cret"
    assert rosapi.call("/rosapi/search_param", {"name": "robot/secret/key"}) == {"global_name": ""}


@pytest.mark.promise("A pattern cannot be evaded through a namespace of parameters")
def test_a_pattern_of_one_parameter_opens_that_one(node: Node) -> None:
    """Allowed names are read within a namespace that is not; the rest is not there."""
    rosapi = Rosapi(node, Access(allow=("param:/robot/name",), write=("param:/robot/name",)))
    assert get(rosapi, "/robot") == {"name": "ö"}
    assert rosapi.call("/rosapi/has_param", {"name": "/robot"}) == {"exists": True}
    assert rosapi.call("/rosapi/set_param", {"name": "/robot/name", "value": '"new"'}) == {}
    with pytest.raises(RosapiError, match="not open here"):
        rosapi.call("/rosapi/set_param", {"name": "/robot", "value": '{"name": "x"}'})
