"""URIs, hosts and ports as text."""

from __future__ import annotations

import pytest

from rosproto.transport.uri import is_loopback, make_uri, master_uri_of, parse_uri, same_uri, uri_path


@pytest.mark.parametrize(
    ("uri", "host", "port"),
    [
        ("http://10.0.0.7:11311/", "10.0.0.7", 11311),
        ("http://10.0.0.7:11311", "10.0.0.7", 11311),
        ("http://10.0.0.7/", "10.0.0.7", 80),
        ("http://10.0.0.7", "10.0.0.7", 80),
        ("http://10.0.0.7:/", "10.0.0.7", 80),
        ("http://robot:11311/path/x?y#z", "robot", 11311),
        ("http://robot:11311?query", "robot", 11311),
        ("HTTP://Robot.Local:11311/", "robot.local", 11311),
        ("  http://robot:1/\n", "robot", 1),
        ("robot:11311", "robot", 11311),
        ("robot", "robot", 80),
        ("rosrpc://robot:40001", "robot", 40001),
        ("http://[::1]:11311/", "::1", 11311),
        ("http://[fe80::1%eth0]/", "fe80::1%eth0", 80),
        ("http://r:0/", "r", 0),
        ("http://r:65535/", "r", 65535),
        ("http://r:1/http://x:2/", "r", 1),
        ("", "localhost", 11311),
    ],
)
def test_every_form_of_a_uri_is_read(uri: str, host: str, port: int) -> None:
    assert parse_uri(uri) == (host, port)


@pytest.mark.parametrize(
    "uri",
    [
        "http://",
        "http:///x",
        "http://:1/",
        "http://r:x/",
        "http://r:65536/",
        "http://r:-1/",
        "http://r:١/",
        "http://::1:11311/",
        "http://[::1/",
        "http://[::1]x/",
        "http://a b/",
        "http://user@host/",
        "http://r:999999999/",
    ],
)
def test_what_is_no_uri_is_a_value_error_that_shows_it(uri: str) -> None:
    with pytest.raises(ValueError, match="URI"):
        parse_uri(uri)


def test_uris_are_made_with_a_trailing_slash_and_brackets() -> None:
    assert make_uri("10.0.0.7", 1) == "http://10.0.0.7:1/"
    assert make_uri("::1", 2) == "http://[::1]:2/"
    assert make_uri("h", 3, "rosrpc") == "rosrpc://h:3/"
    for host in ("10.0.0.7", "::1"):
        assert parse_uri(make_uri(host, 5)) == (host, 5)


@pytest.mark.parametrize(
    ("uri", "path"),
    [("http://h:1/", "/"), ("http://h:1", "/"), ("http://h:1/RPC2", "/RPC2"), ("h:1/x", "/x"), ("", "/")],
)
def test_the_path_of_a_uri(uri: str, path: str) -> None:
    assert uri_path(uri) == path


@pytest.mark.promise("URIs are the same in another case or")
def test_equal_uris_differ_in_case_slash_and_path_only() -> None:
    assert same_uri("http://Robot:1/", "http://robot:1")
    assert same_uri("http://robot/", "http://robot:80")
    assert not same_uri("http://robot:1/", "http://robot:2/")
    assert not same_uri("http://robot:1/", "nonsense:x")
    assert same_uri("nonsense:x", "nonsense:x")


@pytest.mark.parametrize(
    ("host", "yes"),
    [
        ("localhost", True),
        ("LOCALHOST", True),
        ("127.0.0.1", True),
        ("127.9.9.9", True),
        ("::1", True),
        ("[::1]", True),
        ("::ffff:127.0.0.1", True),
        ("10.0.0.7", False),
        ("127.example.com", False),
        ("::", False),
    ],
)
def test_loopback_is_judged_by_the_text(host: str, yes: bool) -> None:
    assert is_loopback(host) is yes


@pytest.mark.parametrize("uri", ["http//robot:11311", "http:/robot:11311/", "HTTP//robot", "rosrpc//robot:1"])
def test_a_mistyped_scheme_is_named(uri: str) -> None:
    """It was taken for a host called http."""
    with pytest.raises(ValueError, match="should be '://'"):
        parse_uri(uri)


@pytest.mark.parametrize(
    ("address", "uri"),
    [
        ("10.0.0.7", "http://10.0.0.7:11311/"),
        ("robot:5", "http://robot:5/"),
        (" robot/ ", "http://robot:11311/"),
        ("fe80::1", "http://[fe80::1]:11311/"),
        ("[::1]", "http://[::1]:11311/"),
        ("[::1]:5", "http://[::1]:5/"),
        ("http://robot", "http://robot"),
        ("http//robot", "http//robot"),
        ("", ""),
    ],
)
def test_a_master_named_by_its_host_has_port_11311(address: str, uri: str) -> None:
    """A URI stays as it is; what is not an address stays for `parse_uri` to refuse."""
    assert master_uri_of(address) == uri
