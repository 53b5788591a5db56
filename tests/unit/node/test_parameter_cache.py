"""The cache of subscribed parameters: updates, deletions, and answers that come late."""

from __future__ import annotations

import pytest

from rosproto.node.parameter_cache import ABSENT, ParameterCache, ParameterChange, canonical_key, same_value


def subscribed(key: str, value: object) -> ParameterCache:
    cache = ParameterCache()
    cache.begin(key)
    cache.start(key, value)
    return cache


def test_the_answer_of_the_subscription_is_the_first_value():
    cache = ParameterCache()
    cache.begin("/a")
    assert cache.start("/a", 1) == [ParameterChange("/a", "/a", 1)]
    assert cache.get("/a") == 1


@pytest.mark.promise("`paramUpdate` carries a trailing slash, an empty dict")
def test_an_update_with_a_trailing_slash_is_an_update_of_the_key():
    cache = subscribed("/a", 1)
    assert cache.apply("/a/", 2) == [ParameterChange("/a", "/a", 2)]
    assert cache.get("/a") == 2


def test_an_update_below_a_subscribed_namespace_changes_that_leaf_only():
    cache = subscribed("/ns", {"a": 1, "b": {"c": 2}})
    assert cache.apply("/ns/b/c/", 3) == [ParameterChange("/ns", "/ns/b/c", 3)]
    assert cache.get("/ns") == {"a": 1, "b": {"c": 3}}
    assert cache.get("/ns/b/c") == 3


def test_an_update_of_a_namespace_above_reaches_the_subscribed_key():
    cache = subscribed("/ns/a", 1)
    assert cache.apply("/ns", {"a": 2, "z": 0}) == [ParameterChange("/ns/a", "/ns/a", 2)]
    assert cache.apply("/ns", {"z": 0}) == [ParameterChange("/ns/a", "/ns/a", ABSENT)]


@pytest.mark.promise("`paramUpdate` carries a trailing slash, an empty dict")
def test_an_empty_dict_is_a_deletion():
    cache = subscribed("/ns", {"a": 1, "b": 2})
    assert cache.apply("/ns/a/", {}) == [ParameterChange("/ns", "/ns/a", ABSENT)]
    assert cache.get("/ns") == {"b": 2}
    assert cache.apply("/ns/b", {}) == [ParameterChange("/ns", "/ns/b", ABSENT)]
    assert cache.get("/ns") is ABSENT


def test_a_value_that_is_the_same_is_no_change_but_true_is_not_one():
    cache = subscribed("/a", 1)
    assert cache.apply("/a", 1) == []
    assert cache.apply("/a", True) == [ParameterChange("/a", "/a", True)]
    assert cache.apply("/a", 1.0) == [ParameterChange("/a", "/a", 1.0)]


def test_an_update_that_overtakes_the_answer_is_not_undone_by_it():
    cache = ParameterCache()
    cache.begin("/ns")
    cache.apply("/ns/a/", 2)
    cache.start("/ns", {"a": 1, "b": 1})
    assert cache.get("/ns") == {"a": 2, "b": 1}


def test_an_update_that_brings_back_an_old_value_while_asking_again_is_kept():
    cache = subscribed("/a", 1)
    cache.begin("/a")
    assert cache.apply("/a", 1) == []
    assert cache.start("/a", 0) == []  # the answer is older than the update
    assert cache.get("/a") == 1


def test_a_value_seen_once_is_not_changed_by_later_updates():
    cache = subscribed("/ns", {"b": {"c": 1}})
    before = cache.get("/ns")
    cache.apply("/ns/b/c", 2)
    assert before == {"b": {"c": 1}}


def test_a_key_nobody_subscribed_is_a_key_error():
    cache = subscribed("/ns", {"a": 1})
    with pytest.raises(KeyError):
        cache.get("/nsa")
    assert cache.get("/ns/zz") is ABSENT


def test_the_root_can_be_subscribed():
    cache = subscribed("/", {"a": 1})
    cache.apply("/b/c/", 2)
    assert cache.get("/") == {"a": 1, "b": {"c": 2}}


def test_a_forgotten_key_takes_no_updates():
    cache = subscribed("/a", 1)
    cache.forget("/a")
    assert cache.apply("/a", 2) == []
    assert cache.start("/a", 3) == []
    assert cache.keys() == []


def test_a_key_of_hostile_depth_is_ignored():
    cache = subscribed("/", {})
    assert cache.apply("/a" * 100_000, 1) == []


def test_keys_have_one_spelling():
    assert canonical_key("/a//b/") == "/a/b"
    assert canonical_key("/") == "/"


def test_nan_equals_itself_here():
    assert same_value({"a": [float("nan")]}, {"a": [float("nan")]})
    assert not same_value([1], [1, 2])
