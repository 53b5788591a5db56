"""Who may do what through a gateway: whole tables of names and patterns."""

from __future__ import annotations

import pytest

from rosproto.gateway.access import Access


@pytest.mark.promise("A gateway is read only until a pattern allows")
def test_everything_is_read_and_nothing_written_at_first() -> None:
    """What moves a robot, and everything else that changes something, is closed."""
    access = Access()
    for kind in ("topic", "service", "parameter", "action", "node"):
        assert access.may_read(kind, "/anything") is None
        refused = access.may_write(kind, "/anything")
        assert refused is not None
        assert "--allow-write" in refused.text
        assert "/anything" in refused.text
    assert not access.writes_anything


@pytest.mark.parametrize(
    ("pattern", "kind", "name", "opens"),
    [
        ("*", "topic", "/a/b", True),
        ("*", "service", "/a/b", True),
        ("/a/*", "topic", "/a/b/c", True),
        ("/a/*", "topic", "/b/a/c", False),
        ("a", "topic", "/a", True),
        ("/a", "topic", "/a/b", False),
        ("/a", "topic", "/A", False),
        ("/[ab]", "topic", "/b", True),
        ("/?", "topic", "/b", True),
        ("/?", "topic", "/bb", False),
        ("topic:/a", "topic", "/a", True),
        ("topic:/a", "service", "/a", False),
        ("service:/a", "service", "/a", True),
        ("param:/a", "parameter", "/a", True),
        ("parameter:a", "parameter", "/a", True),
        ("api:Twist", "api", "Twist", True),
        ("api:Twist", "topic", "/Twist", False),
        ("api:*", "api", "ExecTask", True),
        ("topic:*", "api", "Twist", False),
        ("action:/move_base", "action", "/move_base", True),
        ("action:/move_base", "topic", "/move_base/goal", True),
        ("action:/move_base", "topic", "/move_base/cancel", True),
        ("action:/move_base", "topic", "/move_base/result", False),
        ("topic:/move_base/goal", "action", "/move_base", False),
        ("/cmd_vel", "topic", "/cmd_vel\n", False),
    ],
)
def test_patterns(pattern: str, kind: str, name: str, opens: bool) -> None:
    """What a pattern of `write` opens, and what it does not."""
    assert (Access(write=[pattern]).may_write(kind, name) is None) is opens  # type: ignore[arg-type]
    assert Access(write=[pattern], read_only=True).may_write(kind, name) is not None  # type: ignore[arg-type]


def test_the_command_of_another_protocol_is_named_as_it_is_there() -> None:
    """In the option as well: it is not a name of the graph."""
    refused = Access().may_write("api", "Twist")
    assert refused is not None
    assert "requesting api Twist is refused" in refused.text
    assert refused.text.endswith("--allow-write api:Twist")


def test_deny_wins_and_allow_limits() -> None:
    """Over reading, and over writing."""
    access = Access(allow=["/robot/*"], deny=["/robot/secret*", "param:*"], write=["*"])
    assert access.may_read("topic", "/robot/odom") is None
    assert access.may_write("topic", "/robot/odom") is None
    for kind, name in [
        ("topic", "/other"),
        ("topic", "/robot/secret_plan"),
        ("parameter", "/robot/x"),
        ("service", "/robot/secrets"),
    ]:
        assert access.may_read(kind, name) is not None  # type: ignore[arg-type]
        assert access.may_write(kind, name) is not None  # type: ignore[arg-type]


@pytest.mark.promise("are neither read, nor written, nor listed")
@pytest.mark.parametrize(
    "deny", ["topic:/move_base/goal", "topic:/move_base/*", "/move_base/cancel", "action:/move_base"]
)
def test_a_goal_denied_on_one_way_is_denied_on_the_other(deny: str) -> None:
    """A goal is sent as an action, or published; the topic's denial holds for the action, and the other way round."""
    access = Access(deny=[deny], write=["*"])
    assert access.may_write("action", "/move_base") is not None
    if deny.startswith("action"):
        assert access.may_write("topic", "/move_base/goal") is not None
        assert access.may_write("topic", "/move_base/cancel") is not None


def test_services_that_only_answer_are_open_by_type() -> None:
    """But not where nothing may be seen; and a name alone opens nothing."""
    assert Access().may_write("service", "/a/get_loggers", "roscpp/GetLoggers") is None
    assert Access(read_only=True).may_write("service", "/tf2_frames", "tf2_msgs/FrameGraph") is None
    assert Access().may_write("service", "/a/get_loggers", "std_srvs/Empty") is not None
    assert Access(deny=["/a/*"]).may_write("service", "/a/get_loggers", "roscpp/GetLoggers") is not None


@pytest.mark.parametrize("pattern", ["", "topic:", "robot:/a"])
def test_patterns_that_are_none(pattern: str) -> None:
    """Reported when the gateway is made, not when a client drives."""
    with pytest.raises(ValueError):
        Access(write=[pattern])


def test_one_text_is_no_list_of_patterns() -> None:
    """Its characters would be; and `*` among them opens everything."""
    with pytest.raises(ValueError, match="list"):
        Access(write="/cmd_vel*")


def test_a_long_name_is_cut_in_the_sentence() -> None:
    """A client does not fill a log."""
    refused = Access().may_write("topic", "/" + "x" * 100_000)
    assert refused is not None
    assert len(refused.text) < 1000


@pytest.mark.promise("A denied name denies everything below it")
@pytest.mark.parametrize("deny", ["/walk", "//walk/", "walk", "/wa?k", "/"])
def test_a_denied_name_denies_what_is_below_it(deny: str) -> None:
    """Of every kind; names that only begin alike stay."""
    access = Access(deny=[deny], write=["*"])
    for kind in ("topic", "service", "parameter", "action", "node"):
        for name in ("/walk", "/walk/goal", "/walk/a/b", "//walk//goal/", "walk/goal"):
            assert access.may_read(kind, name) is not None
            assert access.may_write(kind, name) is not None
        if deny != "/":
            assert access.may_read(kind, "/walker/goal") is None


@pytest.mark.promise("a goal denied as an action or as a topic")
@pytest.mark.parametrize("part", ["goal", "cancel", "status", "feedback", "result"])
def test_an_action_and_its_topics_are_hidden_together(part: str) -> None:
    """A goal would otherwise give what a hidden topic shows."""
    assert Access(deny=["action:/walk"]).may_read("topic", f"/walk/{part}") is not None
    assert Access(deny=["action:/walk"]).may_read("topic", "/walk/other") is None
    assert Access(deny=[f"topic:/walk/{part}"], write=["*"]).may_write("action", "/walk") is not None


@pytest.mark.promise("open only what they match")
def test_allow_and_write_open_only_what_they_match() -> None:
    """What is below needs a pattern of its own."""
    access = Access(allow=["/walk"], write=["/walk"])
    assert access.may_read("topic", "/walk/goal") is not None
    assert Access(write=["/walk"]).may_write("parameter", "/walk/key") is not None
    assert access.may_read("topic", "//walk/") is None
