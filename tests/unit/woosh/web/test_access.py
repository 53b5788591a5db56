"""Log-ins of browsers, and how often commands may come."""

from __future__ import annotations

import pytest

from rosproto import admission
from woosh_pure.web import access as access_module
from woosh_pure.web.access import AccessRules, cookie_name, cookies


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


def test_orders_are_counted_for_each_address() -> None:
    access = AccessRules()
    assert [access.check_rate("a", 0.0) is None for _ in range(12)] == [True] * 10 + [False] * 2
    assert access.check_rate("b", 0.0) is None
    assert access.check_rate("a", 0.2) is None, "one more after a fifth of a second"
    assert access.check_rate("a", 0.2) is not None


@pytest.mark.parametrize("origin", ["*", "null", "file://", "ftp://robot.example"])
def test_only_web_pages_are_allowed_to_ask(origin: str) -> None:
    with pytest.raises(ValueError, match="expected one like"):
        AccessRules(origins=[origin])


@pytest.mark.parametrize("name", ["ConnectionSlots", "TokenBucket", "host_of"])
def test_what_every_server_uses_is_still_found_here(name: str) -> None:
    with pytest.warns(DeprecationWarning, match=r"rosproto\.admission"):
        assert getattr(access_module, name) is getattr(admission, name)
    with pytest.raises(AttributeError):
        access_module.Nothing  # noqa: B018
