"""The same calls to Debian's rosmaster and to ours give the same replies.

A table of call sequences, and random ones. Status codes and values must be equal; texts too, but where ours says
more on purpose (`DIFFERENT_TEXT`). Differences that are on purpose have tests of their own at the end.
"""

from __future__ import annotations

import re
import xmlrpc.client
from collections.abc import Iterator
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rosproto import names
from rosproto.master import Master
from tests.support import ros
from tests.support.slaves import RecordingNode

A, B = "http://127.0.0.1:1/", "http://127.0.0.1:2/"
Call = tuple[Any, ...]

SEQUENCES: dict[str, list[Call]] = {
    "topics": [
        ("registerSubscriber", "/s", "/t", "*", A),
        ("getTopicTypes", "/q"),
        ("registerPublisher", "/p", "/t", "*", B),
        ("getTopicTypes", "/q"),
        ("registerPublisher", "/p", "/t", "std_msgs/String", B),
        ("registerPublisher", "/p", "/t", "std_msgs/String", B),
        ("registerSubscriber", "/s2", "/t", "std_msgs/Int32", A),
        ("getPublishedTopics", "/q", ""),
        ("getTopicTypes", "/q"),
        ("getSystemState", "/q"),
        ("lookupNode", "/q", "/p"),
        ("unregisterPublisher", "/p", "/t", A),
        ("unregisterPublisher", "/x", "/t", B),
        ("unregisterPublisher", "/p", "/u", B),
        ("unregisterPublisher", "/p", "/t", B),
        ("unregisterPublisher", "/p", "/t", B),
        ("lookupNode", "/q", "/p"),
        ("unregisterSubscriber", "/s", "/t", A),
        ("unregisterSubscriber", "/s", "/t", A),
        ("getSystemState", "/q"),
        ("getTopicTypes", "/q"),
    ],
    "subgraphs and names": [
        ("registerPublisher", "/ns/p", "t", "a/B", A),
        ("registerPublisher", "/ns/p", "~t", "a/B", A),
        ("registerPublisher", "/ns/p", "/abs//x/", "a/B", A),
        ("registerPublisher", "/ns/p", "/absx", "a/B", A),
        ("getPublishedTopics", "/q", "/abs"),
        ("getPublishedTopics", "/q", "/abs/"),
        ("getPublishedTopics", "/ns/q", "p"),
        ("getPublishedTopics", "/ns/p", "~"),
        ("getPublishedTopics", "/q", "/nothing"),
        ("lookupNode", "/ns/other", "p"),
        ("lookupNode", "/other", "p"),
    ],
    "services": [
        ("registerService", "/s", "/srv", "rosrpc://h:1", A),
        ("lookupService", "/q", "/srv"),
        ("registerService", "/s", "/srv", "rosrpc://h:2", A),
        ("unregisterService", "/s", "/srv", "rosrpc://h:1"),
        ("lookupService", "/q", "/srv"),
        ("registerPublisher", "/s", "/rosout", "rosgraph_msgs/Log", A),
        ("registerService", "/s2", "/srv", "rosrpc://h:3", B),
        ("lookupService", "/q", "/srv"),
        ("unregisterService", "/s", "/srv", "rosrpc://h:2"),
        ("getSystemState", "/q"),
        ("unregisterService", "/nobody", "/srv", "rosrpc://h:3"),
        ("unregisterService", "/s2", "/srv", "rosrpc://h:3"),
        ("lookupService", "/q", "/srv"),
        ("lookupService", "/q", "/never"),
        ("getSystemState", "/q"),
    ],
    "parameters": [
        ("getParam", "/n", "/k"),
        ("setParam", "/n", "/k", 1),
        ("getParam", "/n", "k"),
        ("setParam", "/ns/n", "~p", [1, "two", 3.5, True, [], {}]),
        ("getParam", "/ns/n", "~p"),
        ("getParam", "/q", "/ns"),
        ("setParam", "/n", "/k/below", "x"),
        ("getParam", "/n", "/k"),
        ("getParam", "/n", "/k/below/deeper"),
        ("setParam", "/n", "/k", {"a": {"b": 1}, "c": 2}),
        ("setParam", "/n", "/k", {"a/with/slash": 1, "": 2}),
        ("getParam", "/n", "/k"),
        ("getParamNames", "/n"),
        ("hasParam", "/n", "/k"),
        ("hasParam", "/n", "/k/a"),
        ("hasParam", "/ns/x", "n"),
        ("hasParam", "/n", "/"),
        ("searchParam", "/ns/n/m", "p"),
        ("searchParam", "/ns/n/m", "k/whatever/below"),
        ("searchParam", "/ns/n", "nothing"),
        ("searchParam", "/ns/n", "/k"),
        ("searchParam", "/ns/n", "/nothing"),
        ("searchParam", "/ns/n", "~p"),
        ("searchParam", "relative", "k"),
        ("searchParam", "/", "k"),
        ("deleteParam", "/n", "/nothing"),
        ("deleteParam", "/n", "/k/nothing/below"),
        ("deleteParam", "/n", "/k"),
        ("deleteParam", "/n", "/k"),
        ("deleteParam", "/n", "/"),
        ("getParam", "/n", "/k"),
        ("setParam", "/n", "/e", {}),
        ("getParam", "/n", "/e"),
        ("getParamNames", "/n"),
        ("setParam", "/n", "/", {"only": 1}),
        ("getParam", "/n", "/"),
        ("setParam", "/n", "/", 5),
    ],
    "parameter subscriptions": [
        ("subscribeParam", "/s", A, "/k"),
        ("setParam", "/n", "/k", 7),
        ("subscribeParam", "/s", A, "/k"),
        ("lookupNode", "/q", "/s"),
        ("unsubscribeParam", "/s", A, "/k"),
        ("unsubscribeParam", "/s", A, "/k"),
        ("unsubscribeParam", "/x", A, "/never"),
        ("lookupNode", "/q", "/s"),
        ("subscribeParam", "/s", A, "/"),
        ("subscribeParam", "/s", A, ""),
        ("subscribeParam", "/s", "nowhere", "/k"),
    ],
    "a name from another URI": [
        ("registerPublisher", "/n", "/t", "a/B", A),
        ("registerService", "/n", "/srv", "rosrpc://h:1", A),
        ("registerSubscriber", "/n", "/u", "a/B", A),
        ("registerSubscriber", "/n", "/v", "a/B", B),
        ("getSystemState", "/q"),
        ("lookupNode", "/q", "/n"),
        ("lookupService", "/q", "/srv"),
    ],
    "values of every type": [
        *(
            call
            for value in (
                0, -(2**31), 2**31 - 1, True, False, 1.5, -0.0, 1e300, "", " blank ", "line\nline", "<&>\"'",
                "Grüße 你好", [], [[]], {}, {"x": []}, xmlrpc.client.Binary(b"\x00\xff"),
            )
            for call in (("setParam", "/n", "/v", value), ("getParam", "/n", "/v"))
        )
    ],
    "wrong arguments": [
        *(
            (method, *params)
            for method in (
                "registerPublisher", "registerSubscriber", "registerService", "unregisterPublisher",
                "unregisterSubscriber", "unregisterService", "lookupNode", "lookupService", "getPublishedTopics",
                "getTopicTypes", "getSystemState", "getUri", "getPid", "deleteParam", "setParam", "getParam",
                "searchParam", "subscribeParam", "unsubscribeParam", "hasParam", "getParamNames", "shutdown",
            )
            for params in ((), ("/n", 1, 2, 3, 4, 5), (5, "/t", "a/B", A), (["/n"], "/t"), (None,), ({},))
            # exactly right for these two: not a wrong call
            if not (method == "shutdown" and len(params) == 2)
        ),
        *(("registerPublisher", "/n", t, "a/B", A) for t in ("", "/", 5, "a b", "a:b", [], None)),
        *(("registerPublisher", "/n", "/t", t, A) for t in ("", "a", "a/b/c", 5, None, [])),
        *(("registerPublisher", "/n", "/t", "a/B", u) for u in ("", "h:1", "https://h", 5, None)),
        *(("registerService", "/n", "/s", u, A) for u in ("", "h:1", 5)),
        *(("lookupNode", "/n", n) for n in ("", 5, "a b", "a:b", None)),
        *(("lookupService", "/n", n) for n in ("", 5, "/", None)),
        *(("getPublishedTopics", "/n", n) for n in (5, None, [])),
        *(("getParam", "/n", k) for k in ("", 0, 5, None, [], ["k"])),
        *(("searchParam", "/n", k) for k in ("", 5, None)),
        ("setParam", "/n", "/k", None),
        ("setParam", "/n", "", 1),
        ("nonsense", "/n"),
        ("system.listNonsense",),
        ("_shutdown", "/n"),
        ("", "/n"),
    ],
}  # fmt: skip

# Ours says why, or in other words; code and value are rosmaster's.
DIFFERENT_TEXT = re.compile(
    r"^Error: invalid arguments: (argument of type|unhashable|'|.*object)|is not a provider of|<class 'Exception'>"
)


@pytest.fixture(scope="module")
def debian(ros_installed: None) -> Iterator[str]:
    """One rosmaster for the whole module; every sequence gets names of its own."""
    with ros.start_real_master() as uri:
        yield uri


@pytest.fixture(scope="module")
def ours() -> Iterator[str]:
    with Master() as master:
        client = xmlrpc.client.ServerProxy(master.uri)
        client.deleteParam("/x", "/rosversion")  # the helper for Debian's sets the other two
        yield master.uri


def ask(uri: str, call: Call) -> Any:
    """The reply, or ("fault",): what rosmaster writes into faults is Python's repr of its own error."""
    method, *params = call
    proxy = xmlrpc.client.ServerProxy(uri, allow_none=True, use_builtin_types=True)
    with proxy:
        try:
            return getattr(proxy, method)(*params)
        except xmlrpc.client.Fault:
            return ("fault",)


def comparable(reply: Any, prefix: str) -> Any:
    """Without order where the API promises none, and with the texts that may differ left out."""
    if reply == ("fault",):
        return reply
    code, text, value = reply
    if DIFFERENT_TEXT.search(text):
        text = "..."
    if isinstance(value, list) and len(value) == 3 and all(isinstance(v, list) for v in value):
        value = [sorted(row for row in table if row[0].startswith(prefix)) for table in value]
    elif isinstance(value, list) and text in ("Parameter names", "current system state", "current topics"):
        value = sorted(row for row in value if (row if isinstance(row, str) else row[0]).startswith(prefix))
    return code, text, value


def moved(value: Any, prefix: str) -> Any:
    """Global names below `prefix`, so that sequences do not meet in the one rosmaster."""
    if isinstance(value, str) and value.startswith("/") and value != "/":
        return prefix + value
    return value


@pytest.mark.parametrize("name", sorted(SEQUENCES))
def test_replies_are_those_of_rosmaster(name: str, debian: str, ours: str) -> None:
    """Code, text and value of every call of a sequence."""
    if any("/" in call[1:] for call in SEQUENCES[name]):
        prefix = ""  # it is about the root
        for uri in (debian, ours):
            ask(uri, ("setParam", "/x", "/", {}))
    else:
        prefix = "/" + re.sub(r"\W", "_", name)
    for number, call in enumerate(SEQUENCES[name]):
        sent = (call[0], *(moved(v, prefix) for v in call[1:]))
        theirs, mine = (comparable(ask(uri, sent), prefix) for uri in (debian, ours))
        if call[0] in ("getUri", "getPid") and theirs != ("fault",) and theirs[0] == 1:
            theirs, mine = theirs[:2], mine[:2]
        assert mine == theirs, f"call {number}: {sent}"


def test_missing_names_get_the_same_parse() -> None:
    """The table covers every method of the API."""
    called = {call[0] for calls in SEQUENCES.values() for call in calls}
    from rosproto.master.api import METHODS

    assert set(METHODS) <= called


KEY = st.lists(st.sampled_from("abc"), min_size=1, max_size=3).map(lambda p: "/" + "/".join(p))
LEAF = st.integers(-5, 5) | st.booleans() | st.sampled_from(["", "x"]) | st.just(0.5)
VALUE = st.recursive(
    LEAF, lambda v: st.lists(v, max_size=2) | st.dictionaries(st.sampled_from("abc"), v, max_size=2)
)
NODE, TOPIC = st.sampled_from(["/n", "/ns/m"]), st.sampled_from(["/t", "/u", "rel", "~priv"])
TYPE, URI = st.sampled_from(["*", "a/B", "c/D"]), st.sampled_from([A, B])
RPC = st.sampled_from(["rosrpc://h:1", "rosrpc://h:2"])
STEP = st.one_of(
    st.tuples(st.just("setParam"), NODE, KEY, VALUE),
    st.tuples(st.sampled_from(["deleteParam", "getParam", "hasParam"]), NODE, KEY),
    st.tuples(st.just("searchParam"), NODE, KEY.map(lambda k: k[1:])),
    st.tuples(st.just("getParamNames"), NODE),
    st.tuples(st.sampled_from(["registerPublisher", "registerSubscriber"]), NODE, TOPIC, TYPE, URI),
    st.tuples(st.sampled_from(["unregisterPublisher", "unregisterSubscriber"]), NODE, TOPIC, URI),
    st.tuples(st.just("registerService"), NODE, TOPIC, RPC, URI),
    st.tuples(st.just("unregisterService"), NODE, TOPIC, RPC),
    st.tuples(st.sampled_from(["lookupService", "lookupNode"]), NODE, TOPIC),
    st.tuples(st.sampled_from(["getSystemState", "getTopicTypes"]), NODE),
    st.tuples(st.just("getPublishedTopics"), NODE, st.sampled_from(["", "/ns", "/t"])),
)
_runs = iter(range(1_000_000))


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.lists(STEP, min_size=1, max_size=20))
def test_any_history_gives_the_replies_of_rosmaster(debian: str, ours: str, steps: list[Call]) -> None:
    """Random calls, in a namespace of their own for every run."""
    prefix = f"/run{next(_runs)}"
    owner: dict[str, str] = {}
    for call in steps:
        # On purpose different: a node whose only service is taken over is forgotten by ours (see below).
        if call[0] == "registerService":
            service = names.resolve(call[2], call[1])
            if owner.setdefault(service, call[1]) != call[1]:
                continue
        sent = (call[0], *(moved(v, prefix) for v in call[1:]))
        theirs, mine = (comparable(ask(uri, sent), prefix) for uri in (debian, ours))
        if call[0] == "deleteParam" and theirs[0] == mine[0] == -1:
            theirs, mine = theirs[::2], mine[::2]
        assert mine == theirs, sent


ODD: list[Any] = [
    None, 5, True, 1.5, [], {}, ["x"], {"a": 1}, "", "a b", xmlrpc.client.Binary(b"a"), xmlrpc.client.DateTime("20200101T00:00:00"),
]  # fmt: skip
ODD_TOPICS = [
    "/t",
    "/t/",
    "//t",
    "rel",
    "~priv",
    "~~x",
    "a/~b",
    "t/..",
    "a.b",
    "1abc",
    "/t:1",
    "t x",
    "/",
    "~",
    "/\u00fc",
]
ODD_KEYS = ["/k", "/k/below", "/k/", "//k//below", "k.dot", "~k", "k:x", "k x", "~", "/\u00e9", ""]
ODD_VALUES = [0, "", [], {}, {"a": {"b": 2}}, {"": 1}, {"a/b": 1}, {"x y": {"": {}}}, [[{}]], 0.5, False]
TYPES = ["*", "a/B", "B", "a/b/c", "a/", "/B"]
URIS, HOME = ["http://h", "http://h:1", "rosrpc://h:1", "", "x", "http://"], "home"
PROVIDERS = ["rosrpc://h:1", "http://h", "", "h:1"]
SIGNATURES: dict[str, tuple[Any, ...]] = {
    "registerPublisher": (ODD_TOPICS, TYPES, HOME), "registerSubscriber": (ODD_TOPICS, TYPES, HOME),
    "unregisterPublisher": (ODD_TOPICS, URIS), "unregisterSubscriber": (ODD_TOPICS, URIS),
    "unregisterService": (ODD_TOPICS, PROVIDERS), "lookupNode": (ODD_TOPICS,), "lookupService": (ODD_TOPICS,),
    "getPublishedTopics": (ODD_TOPICS,), "getTopicTypes": (), "getSystemState": (),
    "deleteParam": (ODD_KEYS,), "setParam": (ODD_KEYS, ODD_VALUES), "getParam": (ODD_KEYS,), "hasParam": (ODD_KEYS,),
    "searchParam": (ODD_KEYS,), "subscribeParam": (HOME, ODD_KEYS), "unsubscribeParam": (HOME, ODD_KEYS), "getParamNames": (),
}  # fmt: skip


@st.composite
def odd_call(draw: st.DrawFn) -> Call:
    """A call with arguments of the right kind, one of which is often of another; or too few, or too many."""
    method = draw(st.sampled_from(sorted(SIGNATURES)))
    caller = draw(st.sampled_from(["/n", "/ns/m", "/a.b", "/n-1", "/n/"]))
    # Each node at one address: what happens at two is compared above. A name that nobody has: masters call there.
    home = f"http://h{len(caller)}.invalid:1/"
    arguments = [caller, *(home if s is HOME else draw(st.sampled_from(s)) for s in SIGNATURES[method])]
    change = draw(st.integers(0, 9))
    if change == 0:
        place = draw(st.integers(0, len(arguments) - 1))
        # A caller without a name that could be looked up is refused by ours on purpose.
        odd = ODD if place else [value for value in ODD if not isinstance(value, str)]
        arguments[place] = draw(st.sampled_from(odd))
    elif change == 1:
        arguments = arguments[: draw(st.integers(0, len(arguments) - 1))]
    elif change == 2:
        arguments.append(draw(st.sampled_from(ODD)))
    return (method, *arguments)


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.lists(odd_call(), min_size=1, max_size=25))
def test_any_arguments_get_the_replies_of_rosmaster(debian: str, ours: str, calls: list[Call]) -> None:
    """Wrong types, missing and superfluous arguments, names nobody would give, in any history."""
    prefix = f"/odd{next(_runs)}"
    for call in calls:
        if call[0] == "setParam" and call[2:3] in (("~",), ("",)) and isinstance(call[-1], dict):
            continue
        sent = (call[0], *(moved(v, prefix) for v in call[1:]))
        theirs, mine = (comparable(ask(uri, sent), prefix) for uri in (debian, ours))
        if theirs[1:2] == ("...",):  # where ours has other words
            theirs, mine = theirs[::2], mine[::2]
        assert mine == theirs, sent


UPDATES: list[tuple[list[Call], list[str]]] = [
    ([("setParam", "/n", "/k", 1)], ["/k"]),
    ([("setParam", "/n", "/k/x", 1)], ["/k"]),
    ([("setParam", "/n", "/k", {"x": {"y": 2}, "z": 3})], ["/k/x", "/k/q", "/k"]),
    ([("setParam", "/n", "/k/x", 1), ("deleteParam", "/n", "/k")], ["/k/x", "/k"]),
    ([("setParam", "/n", "/other", 1)], ["/k"]),
    ([("setParam", "/listener", "/k", 1)], ["/k"]),
    ([("setParam", "/listener", "/k", {"x": 1})], ["/k/x"]),
    ([("setParam", "/n", "/k/x", 1), ("deleteParam", "/listener", "/k/x")], ["/k/x"]),
]


@pytest.mark.parametrize(("writes", "keys"), UPDATES)
def test_parameter_updates_are_those_of_rosmaster(
    writes: list[Call], keys: list[str], debian: str, ours: str
) -> None:
    """Which keys with which values a subscriber is told (wire.md, fact 32), and what the setter is not.

    The last value per key: ours may skip those in between when they follow each other fast.
    """
    prefix = f"/updates{next(_runs)}"
    told = []
    for uri in (debian, ours):
        with RecordingNode() as node:
            for key in keys:
                ask(uri, ("subscribeParam", prefix + "/listener", node.uri, prefix + key))
            for call in writes:
                ask(uri, (call[0], *(moved(v, prefix) for v in call[1:])))
            # A last update that everybody gets marks the end. What is still under way to a key that is
            # unsubscribed meanwhile is dropped by ours, so the subscriptions stay until it has come.
            ask(uri, ("subscribeParam", prefix + "/listener", node.uri, prefix + "/end"))
            ask(uri, ("setParam", "/n", prefix + "/end", 1))
            node.wait_for(lambda n: [prefix + "/end/", 1] in n.told("paramUpdate"))
            for key in (*keys, "/end"):
                ask(uri, ("unsubscribeParam", prefix + "/listener", node.uri, prefix + key))
            told.append({str(key): value for key, value in node.told("paramUpdate")})
    assert told[1] == told[0]


def test_publisher_updates_are_those_of_rosmaster(debian: str, ours: str) -> None:
    """The whole list, at every change, by the master's name."""
    told = []
    for uri in (debian, ours):
        with RecordingNode() as node:
            ask(uri, ("registerSubscriber", "/u/s", "/u/t", "*", node.uri))
            for call in (
                ("registerPublisher", "/u/p", "/u/t", "a/B", A),
                ("registerPublisher", "/u/q", "/u/t", "a/B", B),
                ("unregisterPublisher", "/u/p", "/u/t", A),
                ("unregisterPublisher", "/u/p", "/u/t", A),
                ("unregisterPublisher", "/u/q", "/u/t", B),
            ):
                count = len(node.calls)
                changed = ask(uri, call)[2] != 0
                if changed:
                    node.wait_for(lambda n, count=count: len(n.calls) > count)  # type: ignore[misc]
            told.append(node.told("publisherUpdate"))
            ask(uri, ("unregisterSubscriber", "/u/s", "/u/t", node.uri))
    assert told[1] == told[0] == [["/u/t", [A]], ["/u/t", [A, B]], ["/u/t", [B]], ["/u/t", []]]


# -- on purpose different ------------------------------------------------------------------------------------


@pytest.mark.promise("rosmaster accepts an `i8` that it cannot return")
def test_a_value_beyond_32_bits_is_refused_where_rosmaster_breaks(debian: str, ours: str) -> None:
    """rosmaster says yes and answers every later getParam with a Fault."""
    body = (
        "<methodCall><methodName>setParam</methodName><params><param><value>/n</value></param>"
        "<param><value>/big/k</value></param><param><value><i8>99999999999</i8></value></param></params></methodCall>"
    )
    import urllib.request

    codes = []
    for uri in (debian, ours):
        with urllib.request.urlopen(
            urllib.request.Request(uri, body.encode(), {"Content-Type": "text/xml"})
        ) as answer:
            codes.append(xmlrpc.client.loads(answer.read())[0][0][0])  # type: ignore[index]
    assert codes == [1, -1]
    assert ask(debian, ("getParam", "/n", "/big/k")) == ("fault",)
    assert ask(ours, ("getParam", "/n", "/big/k"))[0] == -1


def test_listeners_of_a_replaced_node_are_told_by_ours_only(debian: str, ours: str) -> None:
    """rosmaster forgets the old publications in silence."""
    for uri, lists in ((debian, [[A]]), (ours, [[A], []])):
        with RecordingNode() as node:
            ask(uri, ("registerSubscriber", "/r/s", "/r/t", "*", node.uri))
            ask(uri, ("registerPublisher", "/r/p", "/r/t", "a/B", A))
            node.wait_for(lambda n: len(n.calls) == 1)
            ask(uri, ("registerPublisher", "/r/p", "/r/other", "a/B", B))
            # A last update that everybody gets marks the end.
            ask(uri, ("registerSubscriber", "/r/s", "/r/end", "*", node.uri))
            ask(uri, ("registerPublisher", "/r/z", "/r/end", "a/B", A))
            node.wait_for(lambda n: ("publisherUpdate", ["/r/end", [A]]) in n.calls)
            assert [p[1] for p in node.told("publisherUpdate") if p[0] == "/r/t"] == lists
