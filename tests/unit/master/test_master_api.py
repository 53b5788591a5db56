"""Dispatch of the Master API: argument errors, resolution, statuses, order of notifications."""

from __future__ import annotations

import os
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosproto.master import (
    MasterApi,
    Notification,
    ParameterTree,
    ParamUpdate,
    PublisherUpdate,
    Registry,
    parameters,
)
from rosproto.master.api import METHODS, UnknownMethod
from rosproto.master.validation import resolve

A, B = "http://a:1/", "http://b:2/"


@pytest.fixture
def sent() -> list[Notification]:
    return []


@pytest.fixture
def api(sent: list[Notification]) -> MasterApi:
    api = MasterApi(sent.append)
    api.uri = "http://master:11311/"
    return api


EVERY_METHOD = {
    "registerService": ("/n", "/s", "rosrpc://a:1", A),
    "unregisterService": ("/n", "/s", "rosrpc://a:1"),
    "registerSubscriber": ("/n", "/t", "std_msgs/String", A),
    "unregisterSubscriber": ("/n", "/t", A),
    "registerPublisher": ("/n", "/t", "std_msgs/String", A),
    "unregisterPublisher": ("/n", "/t", A),
    "lookupNode": ("/n", "/n"),
    "getPublishedTopics": ("/n", ""),
    "getTopicTypes": ("/n",),
    "getSystemState": ("/n",),
    "getUri": ("/n",),
    "lookupService": ("/n", "/s"),
    "getPid": ("/n",),
    "deleteParam": ("/n", "/k"),
    "setParam": ("/n", "/k", 1),
    "getParam": ("/n", "/k"),
    "searchParam": ("/n", "k"),
    "subscribeParam": ("/n", A, "/k"),
    "unsubscribeParam": ("/n", A, "/k"),
    "hasParam": ("/n", "/k"),
    "getParamNames": ("/n",),
    "shutdown": ("/n", "why"),
}


def test_the_method_list_is_the_documented_one(api: MasterApi) -> None:
    """wiki.ros.org/ROS/Master_API and ROS/Parameter%20Server%20API, and rosmaster's shutdown."""
    assert api.methods() == sorted(EVERY_METHOD)


@pytest.mark.parametrize("method", sorted(EVERY_METHOD))
def test_missing_superfluous_and_anonymous_arguments_are_the_callers_error(
    api: MasterApi, method: str
) -> None:
    """Status -1 with rosmaster's words and a value of the method's type, never a Fault."""
    good = EVERY_METHOD[method]
    default = 0 if method == "shutdown" else METHODS[method].default
    assert api.dispatch(method, []) == [-1, "missing required caller_id parameter", default]
    assert api.dispatch(method, [*good, "more"]) == [-1, "Error: bad call arity", default]
    if len(good) > 1:
        assert api.dispatch(method, good[:-1]) == [-1, "Error: bad call arity", default]
    assert api.dispatch(method, [5, *good[1:]]) == [-1, "caller_id must be a string", default]


@pytest.mark.parametrize("method", ["", "nonsense", "_shutdown", "__init__", "dispatch", "uri", "registry"])
def test_unknown_methods_are_not_reachable(api: MasterApi, method: str) -> None:
    """Only the documented methods exist; attributes of the object are none."""
    with pytest.raises(UnknownMethod, match="is not supported"):
        api.dispatch(method, ["/n"])


@pytest.mark.parametrize(
    ("method", "params", "text"),
    [
        ("registerPublisher", ("/n", "", "a/B", A), "ERROR: parameter [topic] must be a non-empty string"),
        ("registerPublisher", ("/n", 7, "a/B", A), "ERROR: parameter [topic] must be a non-empty string"),
        ("registerPublisher", ("/n", "/", "a/B", A), "ERROR: parameter [topic] cannot be the global namespace"),
        ("registerPublisher", ("/n", A, "a/B", A), "ERROR: parameter [topic] contains illegal chars"),
        ("registerPublisher", ("/n", "/t", "", A), "ERROR: parameter [topic_type] must be a non-empty string"),
        ("registerPublisher", ("/n", "/t", "B", A), "ERROR: parameter [topic_type] is not a valid package resource name"),
        ("registerPublisher", ("/n", "/t", "a/b/C", A), "ERROR: parameter [topic_type] is not a valid package resource name"),
        ("registerPublisher", ("/n", "/t", "a/B", ""), "ERROR: parameter [caller_api] is not an XMLRPC URI"),
        ("registerPublisher", ("/n", "/t", "a/B", "ftp://x"), "ERROR: parameter [caller_api] is not an RPC URI"),
        ("registerService", ("/n", "/s", "x", A), "ERROR: parameter [service_api] is not an RPC URI"),
        ("getPublishedTopics", ("/n", 1), "ERROR: parameter [subgraph] must be a string"),
        ("getParam", ("/n", ""), "ERROR: parameter [key] must be specified and non-empty"),
        ("getParam", ("/n", 5), "ERROR: parameter [key] must be a string"),
        ("setParam", ("/n", "/k", None), "ERROR: parameter [value] must be specified"),
        ("setParam", ("/n", "/", 1), "Error: invalid arguments: cannot set root of parameter tree to non-dictionary"),
        ("lookupNode", ("/n", ""), "ERROR: parameter [node] must be a non-empty string"),
    ],
)  # fmt: skip
def test_bad_arguments_get_rosmasters_words(
    api: MasterApi, sent: list[Notification], method: str, params: tuple[object, ...], text: str
) -> None:
    """Status -1 and the default value; nothing is stored, nobody is told."""
    assert api.dispatch(method, params) == [-1, text, METHODS[method].default]
    assert api.dispatch("getSystemState", ["/n"])[2] == [[], [], []]
    assert not sent


@pytest.mark.parametrize("caller_id", ["", "/", "//", " ", "/a b", A])
def test_what_nobody_could_look_up_is_not_registered(api: MasterApi, caller_id: str) -> None:
    """Asking is free; registering needs a node name."""
    assert api.dispatch("getSystemState", [caller_id])[0] == 1
    for method in ("registerPublisher", "registerSubscriber", "registerService", "subscribeParam"):
        answer = api.dispatch(method, [caller_id, *EVERY_METHOD[method][1:]])
        assert answer[0] == -1
        assert answer[2] == METHODS[method].default


@pytest.mark.parametrize("position", [0, 1, 2, 3])
def test_names_of_absurd_length_are_refused(api: MasterApi, position: int) -> None:
    """What a master keeps is bounded piece by piece."""
    params: list[object] = ["/n", "/t", "a/B", A]
    params[position] = ("http://" if position == 3 else "a/") + "x" * 5000
    assert api.dispatch("registerPublisher", params)[0] == -1


def test_names_are_resolved_in_the_callers_namespace(api: MasterApi) -> None:
    """Relative and private names, as rosgraph.names.resolve_name does."""
    api.dispatch("registerPublisher", ["/ns/n", "t", "a/B", A])
    api.dispatch("registerPublisher", ["/ns/n", "~t", "a/B", A])
    api.dispatch("registerPublisher", ["/ns/n", "/x//y/", "a/B", A])
    topics = [row[0] for row in api.dispatch("getPublishedTopics", ["/q", ""])[2]]  # type: ignore[attr-defined]
    assert topics == ["/ns/t", "/ns/n/t", "/x/y"]
    assert api.dispatch("lookupNode", ["/ns/other", "n"]) == [1, "node api", A]


def test_the_master_tells_its_uri_and_process(api: MasterApi) -> None:
    """getUri and getPid."""
    assert api.dispatch("getUri", ["/n"]) == [1, "", "http://master:11311/"]
    assert api.dispatch("getPid", ["/n"]) == [1, "", os.getpid()]


def test_parameters_from_end_to_end(api: MasterApi, sent: list[Notification]) -> None:
    """The replies of every Parameter Server method, and the updates they cause."""
    assert api.dispatch("subscribeParam", ["/s", B, "k"]) == [1, "Subscribed to parameter [/k]", {}]
    assert api.dispatch("setParam", ["/n", "~x", 5]) == [1, "parameter /n/x set", 0]
    assert api.dispatch("setParam", ["/n", "/k/x", 1.5]) == [1, "parameter /k/x set", 0]
    assert sent == [ParamUpdate(B, "/k/x/", 1.5)]
    assert api.dispatch("getParam", ["/n", "/k"]) == [1, "Parameter [/k]", {"x": 1.5}]
    assert api.dispatch("getParam", ["/n", "/q"]) == [-1, "Parameter [/q] is not set", 0]
    assert api.dispatch("hasParam", ["/n", "k"]) == [1, "/k", True]
    assert api.dispatch("hasParam", ["/n", "~k"]) == [1, "/n/k", False]
    assert api.dispatch("searchParam", ["/n/m", "x"]) == [1, "Found [/n/x]", "/n/x"]
    assert api.dispatch("searchParam", ["/n", "q"]) == [
        -1,
        "Cannot find parameter [q] in an upwards search",
        "",
    ]
    assert api.dispatch("searchParam", ["/n", "~x"]) == [0, "Internal failure: invalid key", 0]
    assert api.dispatch("getParamNames", ["/n"]) == [1, "Parameter names", ["/n/x", "/k/x"]]
    assert api.dispatch("deleteParam", ["/n", "/k"]) == [1, "parameter /k deleted", 0]
    assert api.dispatch("deleteParam", ["/n", "/k"]) == [-1, "parameter [/k] is not set", 0]
    assert sent[1:] == [ParamUpdate(B, "/k/", {})]
    assert api.dispatch("unsubscribeParam", ["/s", B, "k"]) == [1, "Unsubscribe to parameter [/k]", 1]
    api.dispatch("setParam", ["/n", "/k", 2])
    assert len(sent) == 2


@pytest.mark.parametrize("value", [1 << 40, [None], {"a": {"b": None}}])
def test_a_value_that_could_not_be_answered_is_refused(api: MasterApi, value: object) -> None:
    """Status -1 now instead of a Fault at every getParam later."""
    code, text, _ = api.dispatch("setParam", ["/n", "/k", value])
    assert code == -1
    assert str(text).startswith("ERROR: parameter [value] holds")


def test_notifications_leave_in_the_order_of_their_calls(api: MasterApi, sent: list[Notification]) -> None:
    """They are posted before the next call is looked at."""
    api.dispatch("registerSubscriber", ["/s", "/t", "*", B])
    api.dispatch("registerPublisher", ["/p", "/t", "a/B", A])
    api.dispatch("unregisterPublisher", ["/p", "/t", A])
    assert sent == [PublisherUpdate(B, "/t", (A,)), PublisherUpdate(B, "/t", ())]


def test_shutdown_is_obeyed_only_where_it_is_allowed() -> None:
    """A refusal has a reason and stops nothing."""
    stopped: list[str] = []
    api = MasterApi(lambda note: None, stop=stopped.append, may_stop=lambda peer: peer.startswith("127."))
    refused = api.dispatch("shutdown", ["/n", "bye"], "10.0.0.1:5")
    assert refused == [-1, "shutdown of the master is not allowed from 10.0.0.1:5", 0]
    assert not stopped
    assert api.dispatch("shutdown", ["/n", "bye"], "127.0.0.1:5") == [1, "shutdown", 0]
    assert stopped == ["external shutdown request from [/n] at 127.0.0.1:5: bye"]


def test_a_full_master_says_so() -> None:
    """Status 0 from registry and parameter tree alike, with the default value."""
    registry = Registry(capacity=0)
    api = MasterApi(lambda n: None, registry=registry, parameters=ParameterTree(max_bytes=100))
    for method in ("registerPublisher", "registerSubscriber", "registerService", "subscribeParam"):
        code, _, value = api.dispatch(method, EVERY_METHOD[method])
        assert (code, value) == (0, METHODS[method].default)
    assert api.dispatch("setParam", ["/n", "/k", "x" * 1000])[0] == -1


JUNK = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8) | st.binary(max_size=8),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=4), inner, max_size=3),
)


@given(
    st.sampled_from(sorted(EVERY_METHOD)),
    st.lists(JUNK | st.sampled_from(["/n", "/t", "a/B", A]), max_size=5),
)
def test_any_arguments_give_a_triple(method: str, params: list[object]) -> None:
    """Nothing that XML-RPC can carry raises; the reply is always [int, str, value]."""
    code, text, value = MasterApi(lambda note: None).dispatch(method, params)
    assert code in (-1, 0, 1)
    assert isinstance(text, str)
    assert value is not None


@pytest.mark.parametrize(
    ("name", "node", "resolved"),
    [
        ("x", "/ns/node", "/ns/x"),
        ("x", "/node", "/x"),
        ("~x", "/ns/node", "/ns/node/x"),
        ("~/x", "/node", "/node/x"),
        ("/x//y/", "/node", "/x/y"),
        ("/", "/node", "/"),
        ("x", "", "/x"),
        ("x", "node", "/x"),
        ("a-b.c", "/n", "/a-b.c"),
    ],
)
def test_names_resolve_as_rosgraph_resolves_them(name: str, node: str, resolved: str) -> None:
    """Lenient about characters, always global and canonical."""
    assert resolve(name, node) == resolved


@pytest.mark.parametrize(
    "call",
    [
        ["setParam", "/large", [1] * 1000],
        ["setParam", "/large", 1],
        ["setParam", "/large/below", 1],
        ["setParam", "/names", {"a": 1}],
        ["deleteParam", "/large"],
        ["getParamNames"],
    ],
    ids=["set", "replace", "value becomes a namespace", "replace a namespace", "delete", "names"],
)
def test_what_takes_long_for_large_values_is_done_without_the_lock(
    call: list[Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """It takes seconds for millions of values, and every other call needs the lock."""
    api = MasterApi(lambda note: None)
    api.dispatch("setParam", ["/n", "/large", [1] * 1000])
    api.dispatch("setParam", ["/n", "/names", dict.fromkeys("abc", 1)])
    locked: list[bool] = []

    def noted(name: str) -> None:
        real = getattr(parameters, name)

        def call(*given: Any) -> Any:
            locked.append(api.lock.locked())
            return real(*given)

        monkeypatch.setattr(parameters, name, call)

    noted("_checked_size")
    noted("_leaves")
    assert api.dispatch(call[0], ["/n", *call[1:]])[0] == 1
    assert locked
    assert not any(locked)
