"""The parameter tree: dict semantics, limits, and who is notified under which key."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rosproto.master.notifications import ParamUpdate
from rosproto.master.parameters import ParameterTree, subscription_key

A, B = "http://a:1/", "http://b:2/"


def subscribers(**keys: list[str]) -> dict[str, dict[tuple[str, str], None]]:
    """{"/k/": {(name, uri): None}} from k=[names], with URI http://<name>/."""
    return {
        subscription_key(key.replace("__", "/")): {(f"/{n}", f"http://{n}/"): None for n in names}
        for key, names in keys.items()
    }


def told(updates: list[ParamUpdate]) -> list[tuple[str, str, object]]:
    return sorted(((u.uri, u.parameter, u.value) for u in updates), key=repr)


def test_a_namespace_reads_as_a_dict() -> None:
    """Values set one by one come back as a tree, and the root holds everything."""
    tree = ParameterTree()
    tree.set("/a/b", 1)
    tree.set("/a/c/d", "x")
    assert tree.get("/a") == {"b": 1, "c": {"d": "x"}}
    assert tree.get("/") == {"a": {"b": 1, "c": {"d": "x"}}}
    assert tree.names() == ["/a/b", "/a/c/d"]


def test_a_dict_replaces_the_subtree() -> None:
    """setParam of a dict is not a union with what was there."""
    tree = ParameterTree()
    tree.set("/a", {"x": 1, "y": 2})
    tree.set("/a", {"y": 3})
    assert tree.get("/a") == {"y": 3}
    tree.set("/", {"b": True})
    assert tree.get("/") == {"b": True}


def test_a_plain_value_on_the_way_becomes_a_namespace() -> None:
    """As in rosmaster: writing below a value turns it into a namespace."""
    tree = ParameterTree()
    tree.set("/a", 1)
    tree.set("/a/b", 2)
    assert tree.get("/a") == {"b": 2}


@pytest.mark.parametrize("key", ["/a/b/c", "/x", "/a/bc"])
def test_what_is_not_set_is_a_key_error(key: str) -> None:
    """Also below a plain value, and for delete."""
    tree = ParameterTree()
    tree.set("/a/b", 1)
    assert not tree.has(key)
    with pytest.raises(KeyError):
        tree.get(key)
    with pytest.raises(KeyError):
        tree.delete(key)


def test_delete_takes_a_value_or_a_namespace_but_not_the_root() -> None:
    """An emptied namespace stays, as an empty dict."""
    tree = ParameterTree()
    tree.set("/a/b", 1)
    tree.set("/c/d", 1)
    tree.delete("/a/b")
    tree.delete("/c")
    assert tree.get("/") == {"a": {}}
    with pytest.raises(KeyError):
        tree.delete("/")


def test_the_root_needs_a_dict() -> None:
    """rosmaster's words, because they go back to the caller."""
    with pytest.raises(TypeError, match="cannot set root of parameter tree to non-dictionary"):
        ParameterTree().set("/", 1)


def test_a_value_handed_out_never_changes() -> None:
    """It may be encoded outside the lock while others write."""
    tree = ParameterTree()
    tree.set("/a", {"b": {"c": 1}, "l": [1]})
    before = tree.get("/a")
    tree.set("/a/b/c", 2)
    tree.delete("/a/l")
    assert before == {"b": {"c": 1}, "l": [1]}


def test_slashes_inside_dict_keys_are_kept() -> None:
    """They come back as they were."""
    tree = ParameterTree()
    tree.set("/a", {"b/c": 1})
    assert tree.get("/a") == {"b/c": 1}
    assert not tree.has("/a/b")


@pytest.mark.parametrize(
    ("namespace", "key", "found"),
    [
        ("/pr2/foo", "robot", "/pr2/robot"),
        ("/pr2/foo", "robot/arm", "/pr2/robot/arm"),
        ("/other", "robot/arm", "/robot/arm"),
        ("/pr2", "own", "/pr2/own"),
        ("/pr2/", "own", "/pr2/own"),
        ("/", "robot", "/robot"),
        ("/pr2/foo", "nothing", None),
        ("/pr2/foo", "/robot", "/robot"),
        ("/pr2/foo", "/nothing", None),
    ],
)
def test_search_goes_upwards_for_the_first_part(namespace: str, key: str, found: str | None) -> None:
    """The nearest namespace that holds the first part of the key; the rest need not exist."""
    tree = ParameterTree()
    tree.set("/", {"robot": 1, "pr2": {"robot": {"base": 1}, "own": 1}})
    assert tree.search(namespace, key) == found


@pytest.mark.parametrize(
    ("namespace", "key", "text"),
    [("/n", "", "invalid key"), ("/n", "~p", "invalid key"), ("n", "p", "namespace must be global")],
)
def test_search_refuses_private_keys_and_relative_namespaces(namespace: str, key: str, text: str) -> None:
    """With rosmaster's words."""
    with pytest.raises(ValueError, match=text):
        ParameterTree().search(namespace, key)


def test_subscribers_at_and_above_hear_the_changed_key_but_not_the_one_who_set_it() -> None:
    """The key in the update is the changed one, with a trailing slash (wire.md, fact 32)."""
    tree = ParameterTree(subscribers(a=["one", "setter"], a__b=["two"], other=["three"], **{"": ["root"]}))
    assert told(tree.set("/a/b", 5, "/setter")) == [
        ("http://one/", "/a/b/", 5),
        ("http://root/", "/a/b/", 5),
        ("http://two/", "/a/b/", 5),
    ]


def test_subscribers_below_hear_their_own_key() -> None:
    """With their part of the new dict, and `{}` when it has none; the setter hears that too."""
    tree = ParameterTree(subscribers(a__b=["one"], a__c=["two", "setter"], ab=["three"]))
    assert told(tree.set("/a", {"b": {"x": 1}}, "/setter")) == [
        ("http://one/", "/a/b/", {"x": 1}),
        ("http://setter/", "/a/c/", {}),
        ("http://two/", "/a/c/", {}),
    ]


def test_subscribers_below_a_namespace_replaced_by_a_value_hear_of_the_deletion() -> None:
    """rosmaster forgets them; only when there was a namespace, so plain writes stay cheap and quiet."""
    tree = ParameterTree(subscribers(a__b=["one"]))
    tree.set("/a/b", 1)
    assert told(tree.set("/a", 7)) == [("http://one/", "/a/b/", {})]
    assert told(tree.set("/a", 8)) == []


def test_deletion_is_an_empty_dict_and_the_caller_hears_it_too() -> None:
    """At, above and below the deleted key."""
    tree = ParameterTree(subscribers(a=["at"], a__b=["below"], **{"": ["root"]}))
    tree.set("/a/b", 1)
    assert told(tree.delete("/a")) == [
        ("http://at/", "/a/", {}),
        ("http://below/", "/a/b/", {}),
        ("http://root/", "/a/", {}),
    ]


@pytest.mark.parametrize(
    "value",
    [None, [1, None], {"x": {"y": None}}, 1 << 31, -(1 << 31) - 1, [1 << 40]],
)
def test_what_could_not_be_read_again_is_refused_and_changes_nothing(value: object) -> None:
    """nil and ints beyond 32 bits: rosmaster stores them and then answers getParam with a Fault."""
    tree = ParameterTree()
    tree.set("/a", 1)
    with pytest.raises(ValueError):
        tree.set("/a", value)
    assert tree.get("/") == {"a": 1}


def test_depth_of_value_and_key_together_is_bounded() -> None:
    """So that the whole tree can always be answered."""
    tree = ParameterTree(max_depth=5)
    tree.set("/1/2/3/4/5", 1)
    tree.set("/1/2/3", {"4": [1]})
    for key, value in (("/1/2/3/4/5/6", 1), ("/1/2/3", {"4": {"5": [1]}}), ("/" + "x/" * 5000, 1)):
        with pytest.raises(ValueError, match="nested too deep"):
            tree.set(key, value)


def test_size_of_the_tree_is_bounded_and_shrinking_is_always_possible() -> None:
    """A full tree refuses what makes it grow, nothing else."""
    tree = ParameterTree(max_bytes=2000)
    tree.set("/a", "x" * 1000)
    with pytest.raises(ValueError, match="full"):
        tree.set("/b", "x" * 1000)
    assert tree.names() == ["/a"]
    tree.set("/a", "short")
    tree.set("/b", "x" * 1000)
    tree.delete("/b")
    tree.set("/c", "x" * 1000)


NAME = st.sampled_from(["a", "b", "c"])
LEAF: st.SearchStrategy[Any] = st.one_of(
    st.booleans(), st.integers(-(1 << 31), (1 << 31) - 1), st.floats(allow_nan=False), st.text(max_size=5)
)
# No empty dicts: announcing one is announcing a deletion (paramUpdate knows no difference).
VALUE = st.recursive(
    LEAF, lambda v: st.lists(v, max_size=3) | st.dictionaries(NAME, v, min_size=1, max_size=3)
)
KEY = st.lists(NAME, min_size=1, max_size=4).map(lambda parts: "/" + "/".join(parts))


@settings(max_examples=60)
@given(st.lists(st.tuples(st.sampled_from(["set", "delete"]), KEY, VALUE), max_size=12), KEY)
def test_a_subscriber_that_applies_every_update_has_the_right_value(
    steps: list[tuple[str, str, Any]], watched: str
) -> None:
    """Any history of writes: what the subscriber put together equals getParam; sizes stay exact."""
    tree = ParameterTree({subscription_key(watched): {("/n", A): None}})
    mirror = ParameterTree()
    for verb, key, value in steps:
        if verb == "delete":
            if not tree.has(key):
                continue
            updates = tree.delete(key)
        else:
            updates = tree.set(key, value, "/somebody")
        for update in updates:
            if update.value == {} and mirror.has(update.parameter):
                mirror.delete(update.parameter)
            elif update.value != {}:
                mirror.set(update.parameter, update.value)
    whole = ParameterTree()
    whole.set("/", tree.get("/"))
    assert bytes_counted(tree) == bytes_counted(whole)

    def view(t: ParameterTree) -> object:
        # An empty namespace and an absent one look alike to a subscriber: both are announced as {}.
        return _without_empty(t.get(watched)) if t.has(watched) else None

    assert view(tree) == view(mirror) or (view(tree) in (None, {}) and view(mirror) in (None, {}))


def test_the_size_of_all_is_right_although_what_was_weighed_has_been_replaced_meanwhile() -> None:
    tree = ParameterTree()
    tree.set("/a", [1] * 1000)
    displaced = tree.displaced("/a")
    tree.set("/a", "short")
    tree.set("/a", 5, displaced=displaced)
    tree.delete("/a", displaced=displaced)
    assert bytes_counted(tree) == bytes_counted(ParameterTree())


def bytes_counted(tree: ParameterTree) -> int:
    """The smallest limit at which a tree takes one more value: what it counts, and that value."""
    low, high = 0, 1 << 24
    while low < high:
        tree.max_bytes = middle = (low + high) // 2
        try:
            tree.set("/one more", 0)
        except ValueError:
            low = middle + 1
        else:
            tree.delete("/one more")
            high = middle
    return low


def _without_empty(value: object) -> object:
    if not isinstance(value, dict):
        return value
    pruned = {k: _without_empty(v) for k, v in value.items()}
    return {k: v for k, v in pruned.items() if v != {}}
