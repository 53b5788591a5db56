"""`node.params`: a mapping over the parameter server, and subscribed keys that stay fresh."""

from __future__ import annotations

import threading
from collections.abc import Iterator

import numpy as np
import pytest

from rosproto.errors import ConnectionLost, MasterError
from rosproto.node.parameters import UnknownParameter
from tests.support.small_node import SmallNode


@pytest.fixture
def node() -> Iterator[SmallNode]:
    with SmallNode("/ns/small") as small:
        yield small


def test_values_are_set_read_and_deleted_as_in_a_mapping(node):
    params = node.params
    params["/speed"] = 0.5
    assert params["/speed"] == 0.5
    assert "/speed" in params
    assert list(params) == params.keys() == params.names() == ["/speed"]
    assert len(params) == 1
    del params["/speed"]
    assert "/speed" not in params
    assert 5 not in params


@pytest.mark.parametrize(
    ("key", "resolved"),
    [
        ("/a/b", "/a/b"),
        ("/a//b/", "/a/b"),
        ("b", "/ns/b"),
        ("b/c", "/ns/b/c"),
        ("~b", "/ns/small/b"),
        ("/", "/"),
    ],
)
def test_names_are_resolved_in_the_nodes_namespace(node, key, resolved):
    node.params.set(key, {"x": 1})
    assert node.master.params == {resolved: {"x": 1}}


def test_a_missing_parameter_is_a_key_error_and_a_master_error_that_names_the_master(node):
    for use in (lambda: node.params["/nope"], lambda: node.params.delete("/nope")):
        with pytest.raises(
            UnknownParameter, match=r"parameter /nope is not set on the master http://memory/"
        ) as caught:
            use()
        assert isinstance(caught.value, KeyError)
        assert isinstance(caught.value, MasterError)
        assert caught.value.key == "/nope"
    assert node.params.get("/nope") is None
    assert node.params.get("/nope", 7) == 7


def test_a_failure_of_the_master_is_no_missing_parameter(node, monkeypatch):
    def broken(key):
        raise MasterError("getParam", 0, "internal error")

    monkeypatch.setattr(node.master, "get_param", broken)
    with pytest.raises(MasterError) as caught:
        node.params.get("/x", 1)
    assert not isinstance(caught.value, KeyError)


def test_searching_gives_the_key_found_or_none(node):
    node.params["/ns/robot"] = 1
    assert node.params.search("robot") == "/ns/robot"
    assert node.params.search("nothing") is None
    with pytest.raises(ValueError, match="private"):
        node.params.search("~robot")


def test_numpy_values_tuples_and_mappings_become_plain(node):
    node.params["/x"] = {
        "a": np.int64(3),
        "b": np.float32(0.5),
        "c": (1, 2),
        "d": np.array([[1.0], [2.0]]),
        "e": np.bool_(True),
    }
    stored = node.master.params["/x"]
    assert stored == {"a": 3, "b": 0.5, "c": [1, 2], "d": [[1.0], [2.0]], "e": True}
    assert [type(stored[k]) for k in "abe"] == [int, float, bool]


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (None, "a NoneType cannot"),
        ({"a": {"b": None}}, "/x/a/b: a NoneType"),
        ([1, object()], r"/x\[1\]: a object"),
        (1 << 31, "32 bits"),
        ({"a/b": 1}, "'a/b' is not a key"),
        ({1: 1}, "1 is not a key"),
        ({"": 1}, "'' is not a key"),
        ({1, 2}, "a set cannot"),
    ],
)
def test_what_cannot_be_a_parameter_is_refused_with_its_place(node, value, text):
    with pytest.raises(ValueError, match=text):
        node.params["/x"] = value
    assert node.master.params == {}


def test_the_root_takes_a_dict_only(node):
    with pytest.raises(ValueError, match="root"):
        node.params["/"] = 5


def update(node: SmallNode, key: str, value: object, trusted: bool = True) -> bool:
    return node.params.on_update(key, value, trusted)


def test_a_subscription_has_the_value_at_once_and_follows_the_master(node):
    node.master.params["/ns/a"] = 1
    seen = []
    subscription = node.params.subscribe("a", lambda key, value: seen.append((key, value)))
    assert (subscription.key, subscription.value, seen) == ("/ns/a", 1, [])
    assert update(node, "/ns/a/", 2)
    assert subscription.value == 2
    assert update(node, "/ns/a/", {})
    assert subscription.value is None
    assert seen == [("/ns/a", 2), ("/ns/a", None)]


def test_setting_it_here_updates_the_subscription_here(node):
    """The master does not tell the node that set a value."""
    seen = []
    subscription = node.params.subscribe("/a", lambda key, value: seen.append(value))
    node.params["/a"] = 5
    node.params["/a"] = 5
    assert subscription.value == 5
    node.params.delete("/a")
    assert subscription.value is None
    assert seen == [5, None]


def test_a_key_nobody_subscribed_is_told_so(node):
    assert not update(node, "/other", 1)
    node.params.subscribe("/ns")
    assert update(node, "/ns/deep/er/", 1)
    assert update(node, "/", {})
    assert not update(node, "/nsx", 1)


def test_an_update_from_elsewhere_is_a_hint_to_ask_the_master(node):
    node.master.params["/a"] = "true value"
    subscription = node.params.subscribe("/a")
    assert update(node, "/a", "forged", trusted=False)
    assert subscription.value == "true value"
    del node.master.params["/a"]
    assert update(node, "/a", "forged", trusted=False)
    assert subscription.value is None


def test_an_update_from_elsewhere_while_the_master_is_away_changes_nothing(node, monkeypatch):
    node.master.params["/a"] = 1
    subscription = node.params.subscribe("/a")

    def away(key):
        raise ConnectionLost("away")

    monkeypatch.setattr(node.master, "get_param", away)
    assert update(node, "/a", "forged", trusted=False)
    assert subscription.value == 1


def test_several_subscriptions_of_a_key_are_one_at_the_master_until_the_last_is_closed(node):
    first, second = node.params.subscribe("/a"), node.params.subscribe("/a/")
    assert node.master.count("subscribeParam") == 1
    first.close()
    first.close()
    assert node.master.count("unsubscribeParam") == 0
    update(node, "/a", 3)
    assert second.value == 3
    with second:
        pass
    assert node.master.count("unsubscribeParam") == 1
    assert second.value is None


def test_after_a_restart_of_the_master_a_changed_value_is_told_once(node):
    node.master.params["/a"] = 1
    seen = []
    subscription = node.params.subscribe("/a", lambda key, value: seen.append(value))
    node.registrations.register_all()
    assert seen == []
    node.master.params["/a"] = 2
    node.registrations.register_all()
    assert (seen, subscription.value) == ([2], 2)


def test_a_callback_that_fails_does_not_keep_the_others_from_being_called(node, caplog):
    seen = []
    node.params.subscribe("/a", lambda key, value: 1 / 0)
    node.params.subscribe("/a", lambda key, value: seen.append(value))
    node.params["/a"] = 1
    assert seen == [1]
    assert "ZeroDivisionError" in caplog.text


def test_a_callback_may_set_the_parameter_itself_and_every_change_is_told_in_order(node):
    seen = []

    def clamp(key, value):
        seen.append(value)
        if value > 10:
            node.params[key] = 10

    node.params.subscribe("/a", clamp)
    node.params["/a"] = 50
    assert seen == [50, 10]


def test_changes_of_many_threads_are_told_one_at_a_time_and_the_last_one_stands(node):
    inside, seen, overlaps = [], [], []

    def told(key, value):
        if inside:
            overlaps.append(value)
        inside.append(1)
        seen.append(value)
        inside.pop()

    subscription = node.params.subscribe("/a", told)
    threads = [
        threading.Thread(target=lambda n=n: [update(node, "/a", n * 1000 + i) for i in range(100)])
        for n in range(1, 5)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(10)
    assert overlaps == []
    assert len(seen) == 400
    assert seen[-1] == subscription.value


def test_a_cached_parameter_is_asked_for_once(node):
    node.master.params["/a"] = 1
    assert [node.params.cached("/a") for _ in range(5)] == [1] * 5
    assert node.master.count("subscribeParam") == 1
    assert node.master.count("getParam") == 0
    assert node.params.cached("/nope", 9) == 9


def test_a_subscription_the_master_refuses_leaves_nothing_behind(node, monkeypatch):
    def refuse(key):
        raise MasterError("subscribeParam", -1, "no")

    monkeypatch.setattr(node.master, "subscribe_param", refuse)
    with pytest.raises(MasterError):
        node.params.subscribe("/a")
    monkeypatch.undo()
    assert not update(node, "/a", 1)
    assert node.params.subscribe("/a").value is None
