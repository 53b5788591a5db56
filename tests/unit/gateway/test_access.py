"""Who may do what through a gateway: whole tables of names, patterns, tokens, origins."""

from __future__ import annotations

import pytest

from rosproto.gateway.access import (
    Access,
    foreign_host,
    foreign_origin,
    is_loopback_host,
    require_token_off_loopback,
    token_fits,
)


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
    """Told when the gateway is made, not when somebody drives."""
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


@pytest.mark.parametrize(
    ("given", "expected", "fits"),
    [
        (None, None, True),
        ("x", None, True),
        (None, "t", False),
        ("", "t", False),
        ("t", "t", True),
        ("tt", "t", False),
        ("\udc80", "t", False),
    ],
)
def test_token(given: str | None, expected: str | None, fits: bool) -> None:
    """Asked for only where there is one."""
    assert token_fits(given, expected) is fits


@pytest.mark.parametrize(
    ("host", "loopback"),
    [
        ("127.0.0.1", True),
        ("127.9.9.9", True),
        ("::1", True),
        ("[::1]", True),
        ("localhost", True),
        ("LOCALHOST", True),
        ("0.0.0.0", False),
        ("::", False),
        ("", False),
        ("10.0.0.7", False),
        ("localhost.evil.com", False),
        ("127.0.0.1.evil.com", False),
    ],
)
def test_what_is_loopback(host: str, loopback: bool) -> None:
    """And what only looks so; off it, no token is no start."""
    assert is_loopback_host(host) is loopback
    if loopback:
        require_token_off_loopback(host, None)
    else:
        with pytest.raises(ValueError, match="token"):
            require_token_off_loopback(host, None)
    require_token_off_loopback(host, "secret")
    with pytest.raises(ValueError, match="empty"):
        require_token_off_loopback(host, "")


@pytest.mark.parametrize(
    ("origin", "origins", "may"),
    [
        (None, (), True),
        ("http://localhost:8080", (), True),
        ("https://127.0.0.1", (), True),
        ("http://[::1]:3000", (), True),
        ("http://evil.com", (), False),
        ("http://localhost.evil.com", (), False),
        ("http://localhost@evil.com", (), False),
        ("http://evil.com/localhost", (), False),
        ("null", (), False),
        ("null", ("null",), True),
        ("", (), False),
        ("file://", (), False),
        ("chrome-extension://localhost", (), False),
        ("http://[::1", (), False),
        ("https://studio.example", ("https://studio.example",), True),
        ("http://studio.example", ("https://studio.example",), False),
        ("http://evil.com", ("*",), True),
    ],
)
def test_origins(origin: str | None, origins: tuple[str, ...], may: bool) -> None:
    """A page from elsewhere may not connect, what is no browser may."""
    assert (foreign_origin(origin, origins) is None) is may


@pytest.mark.parametrize(
    ("host", "bound", "ours"),
    [
        ("localhost:9090", "127.0.0.1", True),
        ("127.0.0.1", "127.0.0.1", True),
        ("[::1]:9090", "::1", True),
        (None, "127.0.0.1", True),
        ("evil.com:9090", "127.0.0.1", False),
        ("evil.com", "127.0.0.1", False),
        ("evil.com:9090", "10.0.0.7", True),
    ],
)
def test_hosts(host: str | None, bound: str, ours: bool) -> None:
    """On loopback a foreign name is a page that was led here."""
    assert (foreign_host(host, bound) is None) is ours
