"""Who may use the web server: the lease, `Origin`, `Host`, tokens, log-ins, the rate, and where it listens."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.importorskip("fastapi", reason="needs the extra `web`")
pytest.importorskip("uvicorn", reason="needs the extra `web`")
pytest.importorskip("websockets", reason="needs the extra `web`")

from tests.support.web import PageClient, Served, serving
from woosh_pure import Chassis
from woosh_pure.geometry import Pose2D
from woosh_pure.maps.marks import UserMark

TOKEN = "a-long-secret"


@pytest.fixture
def web(chassis: Chassis, tmp_path: Path) -> Iterator[Served]:
    """A server for one robot."""
    marks = [UserMark("A1", Pose2D(3.0, 1.0, 1.57)), UserMark("C1", Pose2D(-0.9, -3.0), charger=True)]
    with serving(chassis, marks=marks, recordings=tmp_path) as served:
        yield served


def test_a_lease_of_somebody_else_is_in_the_way_but_never_of_a_stop(web: Served, chassis: Chassis) -> None:
    assert chassis.lease.acquire("the night shift")
    refused = web.post("goals", {"kind": "move", "distance": 0.1})
    assert refused.status == 409
    assert "the night shift commands this robot now" in refused.problem
    assert refused.json["holder"] == "the night shift"
    assert web.post("pose", {"x": 0.0, "y": 0.0}).status == 409
    assert web.post("stop").json["stands_still"] is True
    asked = web.post("lease").json
    assert (asked["yours"], asked["asking"]) == (False, ["program at 127.0.0.1"])
    assert web.post("lease/grant").status == 409
    assert chassis.lease.grant("the night shift", "program at 127.0.0.1")
    assert web.get("lease").json["yours"] is True
    assert [web.delete("lease").json["holder"] for _ in range(2)] == [None, None]


def test_a_person_takes_over_from_a_program_by_asking_twice(web: Served, chassis: Chassis) -> None:
    assert chassis.lease.acquire("the night shift")
    early = web.post("lease", {"take_over": True})
    assert (early.status, "first" in early.problem) == (409, True), "asked once"
    asked = web.post("lease").json
    assert (asked["yours"], asked["holder_is_program"]) == (False, True)
    taken = web.post("lease", {"take_over": True}).json
    assert (taken["yours"], taken["asking"]) == (True, [])
    assert web.get("journal").json[-1]["what"] == "take over from the night shift"
    assert not chassis.lease.renew("the night shift")


def test_nobody_takes_over_from_a_person(web: Served, chassis: Chassis) -> None:
    with PageClient(web.port) as page:
        page.say(t="lease", op="ask")
        holder = page.of("lease", yours=True)
        assert holder["holder_is_program"] is False
        assert web.post("lease").json["holder_is_program"] is False
        refused = web.post("lease", {"take_over": True})
        assert (refused.status, "is a person" in refused.problem) == (409, True)
        assert chassis.lease.holder == holder["you"]


@pytest.mark.promise("requested by a page of another site", "STOP in the page")
def test_a_foreign_page_may_change_nothing(web: Served) -> None:
    for path in ("goals", "stop", "pose", "lease", "recordings", "login"):
        for headers in (
            {"origin": "http://evil.example"},
            {"sec-fetch-site": "cross-site"},
            {"origin": "null"},
        ):
            answer = web.post(path, {"kind": "move", "distance": 1.0}, headers=headers)
            assert answer.status == 403, (path, headers)
            assert "is not allowed here" in answer.problem
    assert web.get("journal").json == []


@pytest.mark.promise("is refused (DNS rebinding)")
def test_a_name_that_is_not_ours_is_refused_for_everything(web: Served) -> None:
    for path in ("status", "/", "/openapi.json", "access"):
        answer = web.get(path, headers={"host": "evil.example"})
        assert answer.status == 421
        assert "--host-name" in answer.problem


@pytest.mark.promise("admit clients by the same rules", "STOP in the page")
def test_without_the_token_nothing_but_the_page_is_shown(chassis: Chassis) -> None:
    with serving(chassis, token=TOKEN) as web:
        web.token = None
        assert web.get("/").status == 200
        assert web.get("access").json == {
            "needs_token": True,
            "logged_in": False,
            "allow_driving": False,
            "robots": [],
        }
        for method, path in (
            ("GET", "status"),
            ("GET", "snapshot"),
            ("POST", "stop"),
            ("GET", "/openapi.json"),
            ("GET", "map.png"),
            ("GET", "/robots/robot/api/v1/status"),
            ("DELETE", "goals/1"),
        ):
            answer = web.ask(method, path)
            assert answer.status == 401, path
            assert "token" in answer.problem
        assert web.get("status", headers={"authorization": "Bearer wrong"}).status == 401
        assert web.get("status", headers={"authorization": f"Bearer {TOKEN}"}).status == 200


@pytest.mark.promise("a cookie that scripts cannot read and other sites do not send")
def test_the_page_logs_in_with_a_cookie_that_scripts_cannot_read(chassis: Chassis) -> None:
    with serving(chassis, token=TOKEN) as web:
        web.token = None
        assert web.post("login", {"token": "wrong"}).status == 401
        cookie = web.post("login", {"token": TOKEN}).headers["set-cookie"]
        assert "HttpOnly" in cookie
        assert "SameSite=strict" in cookie
        assert TOKEN not in cookie
        sent = {"cookie": cookie.partition(";")[0]}
        assert web.get("status", headers=sent).status == 200
        assert web.get("access", headers=sent).json["logged_in"] is True
        foreign = web.post("stop", headers={**sent, "origin": "http://evil.example"})
        assert foreign.status == 403, "the cookie does not help a foreign page"
        stale = web.get("status", headers={"cookie": f"woosh_token={TOKEN}"})
        assert stale.status == 401, "the token itself is not a cookie"


@pytest.mark.promise("two servers of one host do not accept each other's")
def test_two_servers_of_one_host_keep_their_log_ins_apart(chassis: Chassis) -> None:
    """Browsers send a cookie to every port of its host."""
    with serving(chassis, token=TOKEN) as one, serving(chassis, token=TOKEN) as two:
        first, second = (
            web.post("login", {"token": TOKEN}).headers["set-cookie"].partition(";")[0] for web in (one, two)
        )
        one.token = two.token = None
        assert first.partition("=")[0] != second.partition("=")[0], "none overwrites the other"
        both = {"cookie": f"{first}; {second}"}
        assert [web.get("status", headers=both).status for web in (one, two)] == [200, 200]
        name, value = second.partition("=")[0], first.partition("=")[2]
        for cookie in (first, f"{name}={value}"):
            assert two.get("status", headers={"cookie": cookie}).status == 401


@pytest.mark.promise("so is the same host with another scheme")
def test_a_page_by_another_scheme_is_another_site(web: Served) -> None:
    own = f"127.0.0.1:{web.port}"
    assert web.post("stop", headers={"origin": f"https://{own}"}).status == 403
    assert web.post("stop", headers={"origin": f"http://{own}"}).status == 200


@pytest.mark.promise("answered ten times, then once every six seconds")
def test_who_guesses_tokens_is_slowed_down(chassis: Chassis) -> None:
    with serving(chassis, token=TOKEN) as web:
        wrong = {"authorization": "Bearer wrong-guess"}
        statuses = [web.get("status", headers=wrong).status for _ in range(12)]
        assert statuses[:10] == [401] * 10
        assert statuses[-1] == 429
        assert web.get("status").status == 200


def test_orders_come_at_most_five_a_second_and_stops_always(web: Served) -> None:
    answers = [web.post("lease") for _ in range(30)]
    assert 429 in {answer.status for answer in answers}
    assert "at most five a second" in next(a for a in answers if a.status == 429).problem
    assert all(web.post("stop").status == 200 for _ in range(3))


@pytest.mark.promise("(Content-Security-Policy without exceptions)")
def test_the_page_has_a_strict_policy_and_nothing_is_framed(web: Served) -> None:
    for path in ("/", "status", "/nothing"):
        headers = web.get(path).headers
        policy = headers["content-security-policy"]
        assert "default-src 'none'" in policy
        assert "unsafe" not in policy
        assert "frame-ancestors 'none'" in policy
        assert headers["x-content-type-options"] == "nosniff"
    assert web.get("status").headers["cache-control"] == "no-store"


@pytest.mark.promise("on another address it does not start without a token")
def test_off_this_computer_only_with_a_token(chassis: Chassis) -> None:
    from woosh_pure import web
    from woosh_pure.web.server import WebServer

    for bind in ("0.0.0.0", "::", "192.168.1.7"):
        with pytest.raises(ValueError, match="give a token"):
            WebServer(web.app(chassis), bind=bind, port=0)


def test_files_that_are_no_certificate_are_refused_before_the_server_starts(
    chassis: Chassis, tmp_path: Path
) -> None:
    from woosh_pure import web
    from woosh_pure.web.server import WebServer

    wrong = tmp_path / "wrong.pem"
    wrong.write_text("no certificate")
    with pytest.raises(ValueError, match=r"wrong\.pem is not a PEM certificate with its unencrypted key"):
        WebServer(web.app(chassis), port=0, tls_cert=wrong)
    with pytest.raises(FileNotFoundError):
        WebServer(web.app(chassis), port=0, tls_cert=tmp_path / "missing.pem")


PREFIXED = {
    "a proxy that removes the prefix": ({}, {"x-forwarded-prefix": "/hall/robot"}),
    "and ends it with a slash": ({}, {"x-forwarded-prefix": "/hall/robot/"}),
    "a root_path": ({"root_path": "/hall/robot"}, {}),
    "both": ({"root_path": "/hall/robot"}, {"x-forwarded-prefix": "/hall/robot"}),
}


@pytest.mark.parametrize("name", PREFIXED)
def test_addresses_in_answers_have_the_prefix_of_a_proxy(chassis: Chassis, name: str) -> None:
    """Location, the servers of the OpenAPI document, the path of the cookie, the addresses of robots."""
    options, sent = PREFIXED[name]
    with serving(chassis, token=TOKEN) as web:
        web.app.root_path = options.get("root_path", "")  # type: ignore[attr-defined]
        made = web.post("goals", {"kind": "rotate", "angle": 0.1}, headers=sent)
        assert made.headers["location"] == f"/hall/robot/api/v1/goals/{made.json['id']}"
        assert web.get("/openapi.json", headers=sent).json["servers"] == [{"url": "/hall/robot"}]
        cookie = web.post("login", {"token": TOKEN}, headers=sent).headers["set-cookie"]
        assert "; Path=/hall/robot;" in cookie
        assert web.get("robots", headers=sent).json[0]["page"] == "/hall/robot/robots/robot/"
        assert web.get("/", headers=sent).status == 200
        assert web.post("/robots/robot/api/v1//stop", headers=sent).status == 200


@pytest.mark.parametrize(
    "prefix", ["//evil.example", "http://evil.example", "/a b", "/a;x", "/../x", "robot"]
)
def test_a_prefix_that_is_not_a_path_is_passed_over(web: Served, prefix: str) -> None:
    made = web.post(
        "goals", {"kind": "rotate", "angle": 0.1, "replace": True}, headers={"x-forwarded-prefix": prefix}
    )
    assert made.headers["location"] == f"/api/v1/goals/{made.json['id']}"
