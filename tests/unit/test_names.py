"""Names are ASCII, resolve as in rosgraph, and command lines are parsed as in rospy."""

from __future__ import annotations

import pytest

from rosproto import names


@pytest.mark.parametrize(
    "name", ["", "/", "~", "a", "/a", "~a", "a/b", "/a/b_c/D9", "~/a", "a/", "A__", "/9", "/_a"]
)
def test_legal_names(name: str) -> None:
    """First a letter, `/` or `~`, then letters, digits, `_`, `/` (wire.md, fact 38)."""
    assert names.is_legal_name(name)


@pytest.mark.promise("Names are ASCII")
@pytest.mark.parametrize(
    "name",
    [
        "1a",
        "_a",
        "a b",
        "a-b",
        "//",
        "a//b",
        "/a//",
        "a~b",
        "/a.b",
        "a\n",
        "/a\n",
        "\u00e4",
        "/\u00e4",
        "/a\u0663",
        "\n",
    ],
)
def test_illegal_names(name: str) -> None:
    """rospy's expression lets Unicode letters and a line feed at the end through; ours does not (wire.md, fact 38)."""
    assert not names.is_legal_name(name)


def test_base_names() -> None:
    """A node's own name has no slash (wire.md, fact 38)."""
    assert all(map(names.is_legal_base_name, ["a", "Node_1", "x__"]))
    assert not any(
        map(names.is_legal_base_name, ["", "/a", "a/b", "~a", "_a", "1a", "a b", "a\n", "\u00e4", "a-b"])
    )


@pytest.mark.parametrize(
    ("name", "canonical"),
    [
        ("/", "/"),
        ("//", "/"),
        ("", ""),
        ("/a/", "/a"),
        ("a//b/", "a/b"),
        ("///a///b", "/a/b"),
        ("~a", "~a"),
        ("a", "a"),
    ],
)
def test_canonicalize(name: str, canonical: str) -> None:
    """Double slashes collapse, one at the end goes (wire.md, fact 38)."""
    assert names.canonicalize(name) == canonical


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("/", "/"),
        ("/node", "/"),
        ("/ns/node", "/ns/"),
        ("/a/b/c", "/a/b/"),
        ("/ns/node/", "/ns/"),
        ("", "/"),
        ("a", "/"),
    ],
)
def test_namespace(name: str, expected: str) -> None:
    """As rosgraph.names.namespace: with a slash at its end."""
    assert names.namespace(name) == expected


@pytest.mark.parametrize(
    ("ns", "name", "expected"),
    [("/", "a", "/a"), ("/ns", "a", "/ns/a"), ("/ns/", "a", "/ns/a"), ("/ns", "/a", "/a"), ("/ns", "~a", "~a"),
     ("", "a", "a"), ("~", "a", "~a")],
)  # fmt: skip
def test_join(ns: str, name: str, expected: str) -> None:
    """As rosgraph.names.ns_join."""
    assert names.join(ns, name) == expected


@pytest.mark.parametrize(
    ("name", "resolved"),
    [
        ("/scan", "/scan"),
        ("scan", "/ns/scan"),
        ("a/scan/", "/ns/a/scan"),
        ("~scan", "/ns/node/scan"),
        ("~/scan", "/ns/node/scan"),
        ("~", "/ns/node"),
        ("//a//b", "/a/b"),
        ("/", "/"),
    ],
)
def test_resolve(name: str, resolved: str) -> None:
    """Global ignores the namespace, private goes below the node's own name (wire.md, fact 38)."""
    assert names.resolve(name, "/ns/node") == resolved


def test_a_private_name_belongs_to_the_node_that_is_given() -> None:
    """Several nodes of one process each have their own (wire.md, fact 38)."""
    assert names.resolve("~x", "/one") == "/one/x"
    assert names.resolve("~x", "/two") == "/two/x"
    assert names.resolve("x", "/one") == "/x"


@pytest.mark.parametrize("name", ["", "a b", "/a\n", "/a\x00", "http://a", "/a\t"])
def test_names_that_no_master_takes_do_not_resolve(name: str) -> None:
    """A wrong name is the caller's error, said at once."""
    with pytest.raises(ValueError, match="expected an ASCII letter"):
        names.resolve(name, "/node")


@pytest.mark.parametrize(
    ("name", "means"),
    [
        ("/a-b", "/a-b"),
        ("1", "/ns/1"),
        ("~3.x", "/ns/me/3.x"),
        ("/\u00e9//\u4e2d/", "/\u00e9/\u4e2d"),
        ("-", "/ns/-"),
    ],
)
def test_names_that_are_only_in_use_resolve_too(name: str, means: str) -> None:
    """rosmaster and rospy take them, so somebody's robot has them."""
    assert not names.is_legal_name(name.rstrip("/"))
    assert names.resolve(name, "/ns/me") == means


def test_a_relative_node_name_is_refused() -> None:
    """Nothing could be resolved with it."""
    with pytest.raises(ValueError, match="not global"):
        names.resolve("a", "node")


@pytest.mark.promise("Names are ASCII")
def test_remappings_apply_after_both_sides_are_resolved() -> None:
    """`scan:=/front/scan` also catches `/ns/scan` (wire.md, fact 38), and is applied once, not in a chain."""
    remappings = names.resolve_remappings({"scan": "/front/scan", "~x": "y", "/front/scan": "/z"}, "/ns/node")
    assert remappings == {"/ns/scan": "/front/scan", "/ns/node/x": "/ns/y", "/front/scan": "/z"}
    assert names.resolve("scan", "/ns/node", remappings) == "/front/scan"
    assert names.resolve("/ns/scan/", "/ns/node", remappings) == "/front/scan"
    assert names.resolve("~x", "/ns/node", remappings) == "/ns/y"
    assert names.resolve("other", "/ns/node", remappings) == "/ns/other"


def test_anonymous_names_are_legal_and_differ(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever the host is called (wire.md, fact 38)."""
    monkeypatch.setattr("platform.node", lambda: "My-PC.l\u00e4n:1")
    made = {names.anonymous_name("listener") for _ in range(50)}
    assert len(made) == 50
    assert all(names.is_legal_base_name(name) and name.startswith("listener_My_PC_l_n_1_") for name in made)


def test_package_resource() -> None:
    """One slash or none."""
    assert names.package_resource("std_msgs/String") == ("std_msgs", "String")
    assert names.package_resource("String") == ("", "String")
    with pytest.raises(ValueError, match="one slash"):
        names.package_resource("a/b/c")


class TestArguments:
    """Remapping arguments as wiki.ros.org/Remapping%20Arguments has them (wire.md, fact 38)."""

    def test_each_kind_has_its_place(self) -> None:
        found = names.parse_arguments(
            [
                "run",
                "scan:=/front/scan",
                "~map:=/m",
                "_rate:=10.5",
                "__name:=me",
                "__ns:=/robot",
                "--loud",
                "a:=b:=c",
            ]
        )
        assert found.remappings == {"scan": "/front/scan", "~map": "/m", "a": "b:=c"}
        assert found.parameters == {"~rate": 10.5}
        assert found.specials == {"__name": "me", "__ns": "/robot"}
        assert found.rest == ["run", "--loud"]

    def test_blanks_around_the_sign_do_not_matter(self) -> None:
        assert names.parse_arguments(["a := b"]).remappings == {"a": "b"}

    @pytest.mark.parametrize("argument", [":=", "a:=", ":=b", "--x"])
    def test_what_is_none_is_left_to_the_program(self, argument: str) -> None:
        assert names.parse_arguments([argument]) == ({}, {}, {}, [argument])

    def test_a_parameter_may_be_empty(self) -> None:
        assert names.parse_arguments(["_prefix:="]).parameters == {"~prefix": ""}

    def test_a_value_that_is_not_closed_names_the_argument(self) -> None:
        with pytest.raises(ValueError, match="_gains"):
            names.parse_arguments(["_gains:=[1, 2"])
