"""Who may send requests: token, Host and Origin."""

from __future__ import annotations

import pytest

from rosproto.admission import (
    AdmissionPolicy,
    AdmissionRefusal,
    basic_password,
    bearer_token,
    host_of,
    port_of,
)

GOOD_HOSTS = [
    "localhost",
    "LOCALHOST:8080",
    "localhost.",
    "127.0.0.1:8080",
    "[::1]:8080",
    "192.168.1.7",
    "10.0.0.1:80",
]
BAD_HOSTS = [
    "",
    "evil.example",
    "evil.example:8080",
    "127.0.0.1.evil.example",
    "localhost.evil.example",
    "a@b",
    "[::1",
    "::1:8080:9",
    "127.0.0.1/evil",
    "2130706433.evil",
    "\x00",
    "robot.local",
]


@pytest.mark.parametrize("host", GOOD_HOSTS)
def test_addresses_in_numbers_and_localhost_are_ours(host: str) -> None:
    assert AdmissionPolicy().check_host(host) is None


@pytest.mark.promise("is refused (DNS rebinding)")
@pytest.mark.parametrize("host", [*BAD_HOSTS, None])
def test_another_name_is_dns_rebinding(host: str | None) -> None:
    refusal = AdmissionPolicy().check_host(host)
    assert refusal is not None
    assert refusal.status == 421
    assert "--host-name" in refusal.text


def test_names_that_were_given_are_ours_and_those_of_origins() -> None:
    access = AdmissionPolicy(origins=["https://robot.example:8443"], hosts=["robot.local:8080"])
    assert access.check_host("robot.example") is None
    assert access.check_host("Robot.Local:8080") is None


@pytest.mark.promise("requested by a page of another site")
@pytest.mark.parametrize(
    ("origin", "host", "good"),
    [
        (None, "127.0.0.1:8080", True),
        ("http://127.0.0.1:8080", "127.0.0.1:8080", True),
        ("https://127.0.0.1:8080", "127.0.0.1:8080", False),
        ("http://127.0.0.1", "127.0.0.1:80", True),
        ("http://LOCALHOST:8080", "localhost:8080", True),
        ("http://127.0.0.1:8081", "127.0.0.1:8080", False),
        ("http://localhost:8080", "127.0.0.1:8080", False),
        ("http://evil.example", "127.0.0.1:8080", False),
        ("null", "127.0.0.1:8080", False),
        ("", "127.0.0.1:8080", False),
        ("file://", "", False),
        ("http://evil.example@127.0.0.1:8080", "127.0.0.1:8080", True),
        ("http://127.0.0.1:8080/path", "127.0.0.1:8080", False),
        ("http://[::1", "[::1", False),
        ("http://a:0", "a:0", False),
        ("http://a:99999", "a:99999", False),
    ],
)
def test_only_our_own_page_may_change_something(origin: str | None, host: str, good: bool) -> None:
    assert (AdmissionPolicy().check_origin(origin, host, "http") is None) == good


@pytest.mark.promise("so is the same host with another scheme")
@pytest.mark.parametrize("scheme", ["http", "ws", "https", "wss"])
def test_the_same_host_by_another_scheme_is_another_site(scheme: str) -> None:
    own, other = ("https", "http") if scheme in ("https", "wss") else ("http", "https")
    assert AdmissionPolicy().check_origin(f"{own}://robot:8080", "robot:8080", scheme) is None
    assert AdmissionPolicy().check_origin(f"{other}://robot:8080", "robot:8080", scheme) is not None


def test_a_page_that_was_given_may_ask() -> None:
    access = AdmissionPolicy(origins=["https://desk.example"])
    assert access.check_origin("https://desk.example", "127.0.0.1:8080", "http") is None
    assert access.check_origin("https://desk.example:444", "127.0.0.1:8080", "http") is not None
    assert access.check_origin("https://desk.example", "desk.example", "http") is None, (
        "behind a proxy with TLS"
    )


@pytest.mark.parametrize(
    ("site", "good"), [("same-origin", True), ("none", True), ("cross-site", False), ("same-site", False)]
)
def test_a_browser_that_names_no_origin_says_whence_it_comes(site: str, good: bool) -> None:
    assert (AdmissionPolicy().check_origin(None, "127.0.0.1", "http", site) is None) == good


@pytest.mark.parametrize(
    "origin", ["robot.example", "ftp://robot.example", "https://", "https://a/path", "https://a?b"]
)
def test_an_origin_that_is_none_is_told_at_the_start(origin: str) -> None:
    with pytest.raises(ValueError, match="expected one like"):
        AdmissionPolicy(origins=[origin])


@pytest.mark.promise("A token has at least 8 characters")
@pytest.mark.parametrize(
    ("token", "text"),
    [("short", "at least 8"), ("", "at least 8"), ("päßwörter", "ASCII"), ("with blank", "ASCII")],
)
def test_a_token_that_can_be_guessed_or_not_be_sent_is_refused(token: str, text: str) -> None:
    with pytest.raises(ValueError, match=text):
        AdmissionPolicy(token)


def test_the_right_token_lets_in_and_a_wrong_one_does_not() -> None:
    access = AdmissionPolicy("correct-horse")
    assert access.check_token("correct-horse", "a", 0.0) is None
    for wrong in (None, "", "correct-hors", "correct-horse ", "CORRECT-HORSE", "\udcff"):
        refusal = access.check_token(wrong, "a", 0.0)
        assert refusal is not None
        assert refusal.status == 401


@pytest.mark.promise("answered ten times, then once every six seconds")
def test_who_guesses_is_slowed_down_and_nobody_else() -> None:
    access = AdmissionPolicy("correct-horse")
    statuses = [access.check_token("wrong", "a", 0.0).status for _ in range(12)]  # type: ignore[union-attr]
    assert statuses == [401] * 10 + [429] * 2
    assert access.check_token("wrong", "b", 0.0).status == 401  # type: ignore[union-attr]
    assert access.check_token("correct-horse", "a", 0.0) is None, "who knows it is not locked out"


@pytest.mark.promise("is refused by its `Origin`")
@pytest.mark.parametrize("origin", ["file://", "app://studio", "null"])
def test_a_program_that_shows_pages_is_allowed_by_name_only(origin: str) -> None:
    assert AdmissionPolicy().check_origin(origin, "127.0.0.1", "ws") is not None
    named = AdmissionPolicy(origins=[origin])
    assert named.check_origin(origin, "127.0.0.1", "ws") is None
    assert named.check_origin("http://evil.example", "127.0.0.1", "ws") is not None
    assert AdmissionPolicy(origins=["*"]).check_origin(origin, "127.0.0.1", "ws") is None


def test_one_origin_alone_is_a_list_forgotten() -> None:
    with pytest.raises(ValueError, match="list"):
        AdmissionPolicy(origins="https://a.example")


@pytest.mark.promise("on another address it does not start without a token")
@pytest.mark.parametrize("bind", ["127.0.0.1", "127.9.9.9", "::1", "[::1]", "localhost", "LOCALHOST"])
def test_this_computer_alone_needs_no_token(bind: str) -> None:
    AdmissionPolicy().require_token_at(bind)


@pytest.mark.promise("on another address it does not start without a token")
@pytest.mark.parametrize(
    "bind", ["0.0.0.0", "::", "", "10.0.0.7", "localhost.evil.com", "127.0.0.1.evil.com"]
)
def test_other_computers_need_a_token(bind: str) -> None:
    """Also where an address only looks like this computer's."""
    with pytest.raises(ValueError, match="--token-file"):
        AdmissionPolicy().require_token_at(bind)
    AdmissionPolicy("correct-horse").require_token_at(bind)


@pytest.mark.parametrize("name", ["host", "origin"])
def test_a_header_that_is_there_twice_is_refused(name: str) -> None:
    """Two readers of the same request could take different ones."""
    headers = {"host": ["localhost"], name: ["http://localhost", "http://localhost"]}
    refusal = AdmissionPolicy().check_headers(lambda asked: headers.get(asked, []), "http", changes=False)
    assert refusal is not None
    assert (refusal.status, refusal.reason) == (400, "headers")


def test_origin_is_checked_where_something_may_change() -> None:
    headers = {"host": ["localhost"], "origin": ["http://evil.example"]}

    def reason(*, changes: bool) -> AdmissionRefusal | None:
        return AdmissionPolicy().check_headers(lambda name: headers.get(name, []), "http", changes=changes)

    assert reason(changes=False) is None
    assert getattr(reason(changes=True), "reason", "") == "origin"


def test_the_token_of_a_header() -> None:
    assert bearer_token(["bearer  a-token "]) == "a-token"
    assert [bearer_token(given) for given in ([], ["Basic x"], ["Bearer a", "Bearer a"])] == [None] * 3


def test_hosts_lose_their_port_and_their_case() -> None:
    assert host_of("ROBOT.local.:80") == "robot.local"
    assert host_of("[2001:db8::1]:80") == "2001:db8::1"
    assert [port_of(host) for host in ("h:81", "[::1]:82", "h", "", "h:1:2")] == ["81", "82", "", "", ""]


@pytest.mark.parametrize(
    ("given", "password"),
    [
        (["Basic cm9ib3Q6d29yZA=="], "word"),  # robot:word
        (["basic  OndvcmQ="], "word"),  # :word
        (["Basic YTpiOmM="], "b:c"),  # a:b:c
        (["Basic 55+t77yaOg=="], ""),  # a name that is not ASCII, and nothing
        (["Basic d29yZA=="], None),  # word: no colon
        (["Basic cm9ib3Q6d29yZA"], None),
        (["Basic /w=="], None),
        (["Basic"], None),
        (["Bearer cm9ib3Q6d29yZA=="], None),
        (["Basic OndvcmQ=", "Basic OndvcmQ="], None),
        ([], None),
    ],
)
def test_the_password_of_basic_authentication(given: list[str], password: str | None) -> None:
    """Whatever the name; None where there is none, or several."""
    assert basic_password(given) == password
