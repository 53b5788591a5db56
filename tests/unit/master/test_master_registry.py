"""The graph of a master: rosmaster's replies, and the notifications."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rosproto.master import registry as registry_module
from rosproto.master.notifications import PublisherUpdate, Shutdown
from rosproto.master.registry import Answer, Registry

A, B, C = "http://a:1/", "http://b:2/", "http://c:3/"


def test_a_publisher_is_told_the_subscribers_and_each_subscriber_the_whole_list() -> None:
    """registerPublisher answers with subscriber URIs and sends every subscriber all publishers."""
    graph = Registry()
    assert graph.register_subscriber("/s", "/t", "std_msgs/String", A).triple == [
        1,
        "Subscribed to [/t]",
        [],
    ]
    graph.register_publisher("/p", "/t", "std_msgs/String", B)
    answer = graph.register_publisher("/q", "/t", "std_msgs/String", C)
    assert answer.triple == [1, "Registered [/q] as publisher of [/t]", [A]]
    assert answer.notifications == (PublisherUpdate(A, "/t", (B, C)),)


def test_an_unregistered_publisher_leaves_an_empty_list() -> None:
    """unregisterPublisher tells subscribers the list without it, also when it is empty."""
    graph = Registry()
    graph.register_subscriber("/s", "/t", "*", A)
    graph.register_publisher("/p", "/t", "std_msgs/String", B)
    answer = graph.unregister_publisher("/p", "/t", B)
    assert answer == Answer(1, "Unregistered [/p] as provider of [/t]", 1, (PublisherUpdate(A, "/t", ()),))


@pytest.mark.parametrize(
    ("name", "topic", "uri", "text"),
    [
        ("/p", "/t", C, "[/p] is not a known provider of [/t]"),
        ("/p", "/other", B, "[/p] is not a known provider of [/other]"),
        ("/stranger", "/t", B, "[/stranger] is not a registered node"),
    ],
)
def test_unregistering_what_is_not_registered_is_ignored(name: str, topic: str, uri: str, text: str) -> None:
    """A wrong node, topic or URI succeeds with 0 removed, changes nothing and tells nobody."""
    graph = Registry()
    graph.register_publisher("/p", "/t", "std_msgs/String", B)
    before = graph.system_state()
    assert graph.unregister_publisher(name, topic, uri) == Answer(1, text, 0)
    assert graph.unregister_subscriber(name, topic, uri) == Answer(
        1, text if name != "/p" or topic != "/t" else "[/p] is not a known provider of [/t]", 0
    )
    assert graph.system_state() == before


def test_registering_twice_counts_once() -> None:
    """A repeated registration is not a second one."""
    graph = Registry()
    for _ in range(2):
        graph.register_publisher("/p", "/t", "std_msgs/String", B)
    assert graph.system_state().value == [[["/t", ["/p"]]], [], []]
    graph.unregister_publisher("/p", "/t", B)
    assert graph.system_state().value == [[], [], []]
    assert len(graph) == 0


def test_a_node_lives_as_long_as_its_last_registration() -> None:
    """lookupNode finds a node until it unregistered everything of every kind."""
    graph = Registry()
    graph.register_publisher("/n", "/t", "std_msgs/String", A)
    graph.register_service("/n", "/srv", "rosrpc://a:9", A)
    graph.subscribe_param("/n", "/key/", A)
    assert graph.lookup_node("/n").triple == [1, "node api", A]
    graph.unregister_publisher("/n", "/t", A)
    graph.unregister_service("/n", "/srv", "rosrpc://a:9")
    assert graph.lookup_node("/n").value == A
    graph.unsubscribe_param("/n", "/key/", A)
    assert graph.lookup_node("/n").triple == [-1, "unknown node [/n]", ""]


@pytest.mark.promise("The types of topics")
def test_a_concrete_type_replaces_the_wildcard_and_not_the_other_way() -> None:
    """`*` never squashes a known type; a later concrete publisher replaces it."""
    graph = Registry()
    graph.register_subscriber("/s", "/quiet", "*", A)
    graph.register_publisher("/p", "/t", "*", B)
    assert graph.topic_types().value == [["/t", "*"]]
    graph.register_publisher("/q", "/t", "std_msgs/String", C)
    graph.register_publisher("/r", "/t", "*", C)
    graph.register_subscriber("/s", "/t", "std_msgs/Int32", A)
    assert graph.topic_types().value == [["/t", "std_msgs/String"]]


def test_a_subscriber_sets_a_type_that_nobody_knew() -> None:
    """getTopicTypes shows a subscriber's type; getPublishedTopics does not."""
    graph = Registry()
    graph.register_subscriber("/s", "/t", "std_msgs/Int32", A)
    assert graph.topic_types().value == [["/t", "std_msgs/Int32"]]
    assert graph.published_topics("").value == []


def test_published_topics_stay_inside_the_subgraph() -> None:
    """A subgraph is a namespace: `/a` holds /a/x but not /ab."""
    graph = Registry()
    for topic in ("/a/x", "/ab", "/a"):
        graph.register_publisher("/p", topic, "std_msgs/String", A)
    assert [row[0] for row in graph.published_topics("/a").value] == ["/a/x"]  # type: ignore[attr-defined]
    assert len(graph.published_topics("").value) == 3  # type: ignore[arg-type]


def test_types_of_deserted_topics_are_remembered_up_to_a_bound(monkeypatch: pytest.MonkeyPatch) -> None:
    """The oldest deserted topics are forgotten; those in use never."""
    monkeypatch.setattr(registry_module, "MAX_RETIRED_TYPES", 2)
    graph = Registry()
    graph.register_publisher("/p", "/used", "std_msgs/String", A)
    for topic in ("/1", "/2", "/3"):
        graph.register_publisher("/p", topic, "std_msgs/String", A)
    for topic in ("/1", "/2", "/3"):
        graph.unregister_publisher("/p", topic, A)
    assert [row[0] for row in graph.topic_types().value] == ["/used", "/2", "/3"]  # type: ignore[attr-defined]


def test_a_service_belongs_to_the_newest_provider() -> None:
    """A second provider replaces the first, whose later unregistration is ignored."""
    graph = Registry()
    graph.register_service("/old", "/srv", "rosrpc://old:1", A)
    graph.register_publisher("/old", "/rosout", "rosgraph_msgs/Log", A)
    assert graph.register_service("/new", "/srv", "rosrpc://new:2", B).triple == [
        1,
        "Registered [/new] as provider of [/srv]",
        1,
    ]
    assert graph.lookup_service("/srv").triple == [1, "rosrpc URI: [rosrpc://new:2]", "rosrpc://new:2"]
    answer = graph.unregister_service("/old", "/srv", "rosrpc://old:1")
    assert answer.triple == [
        1,
        "[rosrpc://old:1] is no longer the current service api handle for [/srv]",
        0,
    ]
    assert graph.unregister_service("/new", "/srv", "rosrpc://new:2").value == 1
    assert graph.lookup_service("/srv").triple == [-1, "no provider", ""]


def test_a_node_whose_only_service_was_taken_is_forgotten() -> None:
    """Nothing of it is registered any more, so its name is free."""
    graph = Registry()
    graph.register_service("/old", "/srv", "rosrpc://old:1", A)
    graph.register_service("/new", "/srv", "rosrpc://new:2", B)
    assert graph.lookup_node("/old").code == -1
    assert graph.system_state().value == [[], [], [["/srv", ["/new"]]]]


def test_a_name_from_a_new_uri_ends_the_old_node_and_tells_its_listeners() -> None:
    """The former life's registrations of all kinds are gone, its subscribers are told, it is shut down."""
    graph = Registry()
    graph.register_subscriber("/s", "/t", "*", C)
    graph.register_publisher("/n", "/t", "std_msgs/String", A)
    graph.register_subscriber("/n", "/in", "std_msgs/String", A)
    graph.register_service("/n", "/srv", "rosrpc://a:9", A)
    graph.subscribe_param("/n", "/key/", A)
    answer = graph.register_publisher("/n", "/rosout", "rosgraph_msgs/Log", B)
    assert answer.notifications == (
        Shutdown(
            A,
            "/n",
            "[/n] Reason: new node registered with same name",
            frozenset({"/t"}),
            frozenset({"/in"}),
        ),
        PublisherUpdate(C, "/t", ()),
    )
    assert graph.lookup_node("/n").value == B
    assert graph.lookup_service("/srv").code == -1
    assert graph.system_state().value == [[["/rosout", ["/n"]]], [["/t", ["/s"]]], []]
    assert not graph.param_subscribers.providers


def test_a_node_sent_away_cannot_take_its_name_back_by_listening_to_a_parameter() -> None:
    """roscpp's last log line subscribes to one; rosmaster then ends the new node as well."""
    graph = Registry()
    graph.register_publisher("/n", "/t", "std_msgs/String", A)
    graph.register_publisher("/n", "/t", "std_msgs/String", B)
    assert graph.subscribe_param("/n", "/k/", A) == Answer(1, "", 0)
    assert graph.lookup_node("/n").value == B
    assert not graph.param_subscribers.providers
    # Started again at its old address, it registers something else first, and then everything counts.
    back = graph.register_publisher("/n", "/t", "std_msgs/String", A)
    assert [note.uri for note in back.notifications] == [B]
    graph.subscribe_param("/n", "/k/", A)
    assert graph.param_subscribers.uris("/k/") == (A,)


def test_nodes_sent_away_are_remembered_up_to_a_bound(monkeypatch: pytest.MonkeyPatch) -> None:
    """The oldest is forgotten."""
    monkeypatch.setattr(registry_module, "MAX_EVICTED", 2)
    graph = Registry()
    for number in range(5):
        graph.register_publisher("/n", "/t", "std_msgs/String", f"http://a:{number}/")
    for number in (3, 2):  # remembered: what they say late is not heard
        graph.subscribe_param("/n", "/k/", f"http://a:{number}/")
        assert graph.lookup_node("/n").value == "http://a:4/"
    graph.subscribe_param("/n", "/k/", "http://a:1/")
    assert graph.lookup_node("/n").value == "http://a:1/"


def test_names_at_a_uri_are_found_in_any_spelling() -> None:
    """Host case and trailing slash do not matter (roscpp and rospy spell differently)."""
    graph = Registry()
    graph.register_publisher("/n", "/t", "std_msgs/String", "http://Robot:5/")
    assert graph.names_at("http://robot:5") == ["/n"]
    assert graph.names_at("http://robot:6") == []


def test_a_full_registry_refuses_new_and_keeps_old() -> None:
    """At capacity a new registration gets status 0; a repeated one and an unregistration work."""
    graph = Registry(capacity=2)
    graph.register_publisher("/p", "/a", "std_msgs/String", A)
    graph.register_publisher("/p", "/b", "std_msgs/String", A)
    refused = graph.register_publisher("/p", "/c", "std_msgs/String", A)
    assert (refused.code, refused.value, refused.notifications) == (0, [], ())
    assert graph.register_service("/p", "/s", "rosrpc://a:1", A).triple[0::2] == [0, 0]
    assert graph.register_publisher("/p", "/a", "std_msgs/String", A).code == 1
    graph.unregister_publisher("/p", "/b", A)
    assert graph.register_subscriber("/p", "/c", "*", A).code == 1


NODES = st.sampled_from(["/a", "/b", "/c"])
URIS = st.sampled_from([A, B, C])
KEYS = st.sampled_from(["/t", "/u"])
STEP = st.tuples(st.sampled_from(["pub", "unpub", "sub", "unsub", "srv", "unsrv"]), NODES, KEYS, URIS)


def _play(graph: Registry, step: tuple[str, str, str, str]) -> Answer:
    verb, node, key, uri = step
    if verb == "pub":
        return graph.register_publisher(node, key, "std_msgs/String", uri)
    if verb == "sub":
        return graph.register_subscriber(node, key, "std_msgs/String", uri)
    if verb == "srv":
        return graph.register_service(node, key, f"rosrpc{uri[4:]}", uri)
    if verb == "unsrv":
        return graph.unregister_service(node, key, f"rosrpc{uri[4:]}")
    return (graph.unregister_publisher if verb == "unpub" else graph.unregister_subscriber)(node, key, uri)


@settings(max_examples=150)
@given(st.lists(STEP, max_size=40))
def test_any_history_leaves_a_consistent_graph_and_informed_subscribers(
    steps: list[tuple[str, str, str, str]],
) -> None:
    """Counts, nodes and indices agree; what a subscriber heard last is what the graph says."""
    graph = Registry()
    heard: dict[tuple[str, str], tuple[str, ...]] = {}
    for step in steps:
        answer = _play(graph, step)
        assert answer.code == 1
        for note in answer.notifications:
            if isinstance(note, PublisherUpdate):
                heard[note.uri, note.topic] = note.publishers
        if step[0] == "sub":
            heard[step[3], step[2]] = tuple(answer.value)  # type: ignore[arg-type]
    kinds = (graph.publishers, graph.subscribers, graph.services)
    entries = [entry for kind in kinds for held in kind.providers.values() for entry in held]
    assert len(graph) == len(entries)
    assert all(graph.lookup_node(name).value == uri for name, uri in entries)
    homes = {(name, uri) for uri in (A, B, C) for name in graph.names_at(uri)}
    assert homes == set(entries)
    assert all(len(held) == 1 for held in graph.services.providers.values())
    for topic, subscribers in graph.subscribers.providers.items():
        for _, uri in subscribers:
            assert heard[uri, topic] == graph.publishers.uris(topic)
