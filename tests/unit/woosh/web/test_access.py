"""Who may ask: Host, Origin, token, and how often."""

from __future__ import annotations

import pytest

from woosh_pure.web.access import MOST_BUCKETS, AccessRules, TokenBucket, cookie_name, cookies, host_of

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
    assert AccessRules().check_host(host) is None


@pytest.mark.promise("is refused (DNS rebinding)")
@pytest.mark.parametrize("host", [*BAD_HOSTS, None])
def test_another_name_is_dns_rebinding(host: str | None) -> None:
    refusal = AccessRules().check_host(host)
    assert refusal is not None
    assert refusal.status == 421
    assert "--host-name" in refusal.text


def test_names_that_were_given_are_ours_and_those_of_origins() -> None:
    access = AccessRules(origins=["https://robot.example:8443"], hosts=["robot.local:8080"])
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
    assert (AccessRules().check_origin(origin, host, "http") is None) == good


@pytest.mark.promise("The same host with another scheme is another site")
@pytest.mark.parametrize("scheme", ["http", "ws", "https", "wss"])
def test_the_same_host_by_another_scheme_is_another_site(scheme: str) -> None:
    own, other = ("https", "http") if scheme in ("https", "wss") else ("http", "https")
    assert AccessRules().check_origin(f"{own}://robot:8080", "robot:8080", scheme) is None
    assert AccessRules().check_origin(f"{other}://robot:8080", "robot:8080", scheme) is not None


def test_a_page_that_was_given_may_ask() -> None:
    access = AccessRules(origins=["https://desk.example"])
    assert access.check_origin("https://desk.example", "127.0.0.1:8080", "http") is None
    assert access.check_origin("https://desk.example:444", "127.0.0.1:8080", "http") is not None
    assert access.check_origin("https://desk.example", "desk.example", "http") is None, (
        "behind a proxy with TLS"
    )


@pytest.mark.parametrize(
    ("site", "good"), [("same-origin", True), ("none", True), ("cross-site", False), ("same-site", False)]
)
def test_a_browser_that_names_no_origin_says_whence_it_comes(site: str, good: bool) -> None:
    assert (AccessRules().check_origin(None, "127.0.0.1", "http", site) is None) == good


@pytest.mark.parametrize(
    "origin", ["robot.example", "ftp://robot.example", "https://", "https://a/path", "https://a?b"]
)
def test_an_origin_that_is_none_is_told_at_the_start(origin: str) -> None:
    with pytest.raises(ValueError, match="expected one like"):
        AccessRules(origins=[origin])


@pytest.mark.promise("other addresses need a token of at least 8 letters")
@pytest.mark.parametrize(
    ("token", "text"),
    [("short", "at least 8"), ("", "at least 8"), ("päßwörter", "ASCII"), ("with blank", "ASCII")],
)
def test_a_token_that_can_be_guessed_or_not_be_sent_is_refused(token: str, text: str) -> None:
    with pytest.raises(ValueError, match=text):
        AccessRules(token)


def test_the_right_token_lets_in_and_a_wrong_one_does_not() -> None:
    access = AccessRules("correct-horse")
    assert access.check_token("correct-horse", "a", 0.0) is None
    for wrong in (None, "", "correct-hors", "correct-horse ", "CORRECT-HORSE", "\udcff"):
        refusal = access.check_token(wrong, "a", 0.0)
        assert refusal is not None
        assert refusal.status == 401


@pytest.mark.promise("a cookie that scripts cannot read and other sites do not send")
def test_a_log_in_is_good_at_its_place_as_long_as_the_token_is() -> None:
    access = AccessRules("correct-horse")
    kept = access.log_in("woosh_login_80 80")
    assert kept != access.log_in("woosh_login_80 80"), "each browser has its own"
    assert access.is_logged_in(["", "a.b", "\udcff.x", "päß", kept], "woosh_login_80 80")
    assert not access.is_logged_in([kept], "woosh_login_81 81")
    assert not access.is_logged_in([kept[:-1], kept.upper(), "correct-horse"], "woosh_login_80 80")
    again = AccessRules("correct-horse")
    assert again.is_logged_in([kept], "woosh_login_80 80"), "STOP of an open page outlives a restart"
    assert not AccessRules("another-horse").is_logged_in([kept], "woosh_login_80 80")
    assert not AccessRules().is_logged_in([AccessRules().log_in("x")], "x")


def test_a_cookie_has_the_port_in_its_name() -> None:
    hosts = [
        ("h:8080", "http"),
        ("[::1]:8081", "https"),
        ("h", "http"),
        ("h", "wss"),
        ("", "http"),
        ("h:1:2", "ws"),
    ]
    names = [cookie_name(host, scheme) for host, scheme in hosts]
    assert names == [f"woosh_login_{port}" for port in (8080, 8081, 80, 443, 80, 80)]
    assert cookies("a=1; b=2;a=3=4; a; =; a =5", "a") == ["1", "3=4", ""]


@pytest.mark.promise("answered ten times, then once every six seconds")
def test_who_guesses_is_slowed_down_and_nobody_else() -> None:
    access = AccessRules("correct-horse")
    statuses = [access.check_token("wrong", "a", 0.0).status for _ in range(12)]  # type: ignore[union-attr]
    assert statuses == [401] * 10 + [429] * 2
    assert access.check_token("wrong", "b", 0.0).status == 401  # type: ignore[union-attr]
    assert access.check_token("correct-horse", "a", 0.0) is None, "who knows it is not locked out"


def test_orders_are_counted_for_each_address() -> None:
    access = AccessRules()
    assert [access.check_rate("a", 0.0) is None for _ in range(12)] == [True] * 10 + [False] * 2
    assert access.check_rate("b", 0.0) is None
    assert access.check_rate("a", 0.2) is None, "one more after a fifth of a second"
    assert access.check_rate("a", 0.2) is not None


def test_addresses_do_not_pile_up() -> None:
    """Of as many others an address is remembered, of one more it is not."""
    for others, remembered in ((MOST_BUCKETS - 1, True), (MOST_BUCKETS, False)):
        access = AccessRules("correct-horse")
        for _ in range(12):
            access.check_rate("a", 0.0)
            access.check_token("wrong", "a", 0.0)
        for i in range(others):
            access.check_rate(f"{i}", 0.0)
            access.check_token("wrong", f"{i}", 0.0)
        assert (access.check_rate("a", 0.0) is not None) == remembered
        assert access.check_token("wrong", "a", 0.0).status == (429 if remembered else 401)  # type: ignore[union-attr]


def test_a_bucket_does_not_fill_beyond_its_burst_or_by_a_clock_that_goes_back() -> None:
    bucket = TokenBucket(1.0, 2.0)
    assert [bucket.take(1e6) for _ in range(3)] == [True, True, False]
    assert not bucket.take(0.0)
    assert [bucket.take(2e6) for _ in range(3)] == [True, True, False]


def test_hosts_lose_their_port_and_their_case() -> None:
    assert host_of("ROBOT.local.:80") == "robot.local"
    assert host_of("[2001:db8::1]:80") == "2001:db8::1"
