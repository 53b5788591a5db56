"""The REST API on the simulated chassis: state, map, camera, feeds, recordings, several robots; its description, and mounting."""

from __future__ import annotations

import itertools
import json
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.support.waiting import until

pytest.importorskip("fastapi", reason="needs the extra `web`")
pytest.importorskip("uvicorn", reason="needs the extra `web`")
pytest.importorskip("websockets", reason="needs the extra `web`")

from tests.support.web import Served, serving
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


def test_status_and_snapshot_say_what_the_robot_is(web: Served, chassis: Chassis) -> None:
    chassis.battery.wait(10.0, new=False)
    chassis.pose.wait(10.0, new=False)
    shown = web.get("snapshot").json
    assert shown["battery"]["percent"] > 0
    assert set(shown["pose"]) == {"x", "y", "yaw", "theta"}
    assert shown["pose"]["theta"] == shown["pose"]["yaw"], "the old name of the same number"
    assert shown["ages"]["pose"] is not None
    assert shown["readiness"]["answer"] in ("yes", "no", "not known")
    status = web.get("status").json
    assert status["robot"] == "robot"
    assert status["battery_percent"] == shown["battery"]["percent"]
    assert web.get("faults").json["active"] == []
    assert web.get("readiness").json["answer"] == status["ready"]


def test_the_map_is_a_picture_with_facts(web: Served) -> None:
    facts, answer = web.get("map").json, web.get("map.png")
    assert answer.headers["content-type"] == "image/png"
    assert struct.unpack(">II", answer.body[16:24]) == (facts["width"], facts["height"])
    tag = answer.headers["etag"]
    assert web.get("map.png", headers={"if-none-match": tag}).status == 304
    assert b"resolution: 0.05" in web.get("map.yaml").body
    assert web.get("plan").json == {"points": []}


def test_marks_are_those_that_were_given(web: Served) -> None:
    assert [(m["name"], m["charger"]) for m in web.get("marks").json] == [("A1", False), ("C1", True)]


@pytest.mark.parametrize(("path", "magic"), [("color.jpg", b"\xff\xd8"), ("depth.png", b"\x89PNG")])
def test_a_picture_is_taken_and_the_camera_let_go(
    web: Served, chassis: Chassis, path: str, magic: bytes
) -> None:
    answer = web.get(f"camera/{path}")
    assert answer.status == 200, answer
    assert answer.body.startswith(magic)
    camera = web.app.state.context.robot(None).cameras[path.partition(".")[0]]  # type: ignore[attr-defined]
    camera.close_idle(0.0)
    assert not camera.open


def test_feeds_are_listed_and_read_and_pictures_are_not_among_them(web: Served, chassis: Chassis) -> None:
    names = {feed["name"] for feed in web.get("feeds").json}
    assert {"battery", "pose", "scan"} <= names
    assert "camera" not in names
    chassis.measured_velocity.wait(10.0, new=False)
    value = web.get("feeds/velocity").json
    assert (value["name"], set(value["value"])) == ("velocity", {"vx", "vy", "wz"})
    assert web.get("feeds/camera").status == 415
    assert "near names" in web.get("feeds/batery").problem


def test_a_feed_is_streamed_as_events(web: Served) -> None:
    import http.client

    connection = http.client.HTTPConnection("127.0.0.1", web.port, timeout=10)
    connection.request("GET", "/api/v1/feeds/velocity/stream?rate=20")
    response = connection.getresponse()
    assert response.getheader("content-type", "").startswith("text/event-stream")
    said = (response.readline().decode().rstrip("\n") for _ in range(200))
    lines = list(itertools.islice((line for line in said if line and not line.startswith(":")), 6))
    connection.close()
    assert lines[0] == lines[3] == "event: velocity"
    first, second = (json.loads(lines[at].removeprefix("data: ")) for at in (2, 5))
    assert first["value"].keys() == second["value"].keys() == {"vx", "vy", "wz"}
    context = web.app.state.context  # type: ignore[attr-defined]
    until(lambda: context.streams == 0, what="the end of the stream of one who goes")


def test_a_bag_is_recorded_seen_growing_downloaded_and_deleted(web: Served, tmp_path: Path) -> None:
    number = web.post("recordings", {"seconds": 60.0}).json["id"]
    assert "end it first" in web.post("recordings").problem
    assert web.get(f"recordings/{number}/bag").status == 409
    until(lambda: web.get(f"recordings/{number}").json["messages"] >= 5, what="five messages")
    assert "end it first" in web.delete(f"recordings/{number}").problem, "nothing is lost by an old client"
    assert web.post(f"recordings/{number}/end").json["running"] is False
    answer = web.get(f"recordings/{number}/bag")
    assert answer.body.startswith(b"#ROSBAG V2.0")
    assert ".bag" in answer.headers["content-disposition"]
    assert web.delete(f"recordings/{number}").json["id"] == number
    assert not list(tmp_path.iterdir())
    assert web.get(f"recordings/{number}").status == web.delete(f"recordings/{number}").status == 404
    done = [entry["what"] for entry in web.get("journal").json]
    assert done == [f"record bag {number}", f"end bag {number}", f"delete bag {number}"]


@pytest.mark.promise("Clients do not receive paths of this computer")
def test_a_folder_for_recordings_that_is_not_there_is_told_at_the_start(
    chassis: Chassis, tmp_path: Path
) -> None:
    from woosh_pure import web

    with pytest.raises(ValueError, match="there is no folder"):
        web.app(chassis, recordings=tmp_path / "none")
    with Chassis(chassis.master_uri) as other:
        web.app({"a": chassis, "b": other}, recordings=tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a", "b"], "one for each of several robots"


@pytest.mark.promise("Clients do not receive paths of this computer")
def test_a_bag_that_cannot_be_written_is_told_without_its_path(chassis: Chassis, tmp_path: Path) -> None:
    folder = tmp_path / "bags"
    folder.mkdir()
    with serving(chassis, recordings=folder) as web:
        folder.rmdir()
        answer = web.post("recordings")
        assert (answer.status, "the log of the server" in answer.problem) == (503, True)
        assert str(tmp_path).encode() not in answer.body


def test_several_robots_have_one_page_each(chassis: Chassis) -> None:
    with Chassis(chassis.master_uri) as other, serving({"hall": chassis, "yard": other}) as web:
        assert [robot["name"] for robot in web.get("robots").json] == ["hall", "yard"]
        assert web.get("status").json["robot"] == "hall"
        assert web.get("robots/yard/status").json["robot"] == "yard"
        assert web.get("/robots/yard/api/v1/status").json["robot"] == "yard"
        assert b"<html" in web.get("/robots/yard/").body
        assert "there are hall, yard" in web.get("robots/cellar/status").problem


def test_the_description_names_every_operation_once_and_every_error(web: Served) -> None:
    schema = web.get("/openapi.json").json
    operations = [op for path in schema["paths"].values() for op in path.values()]
    names = [op["operationId"] for op in operations]
    assert len(names) == len(set(names)) > 50
    assert {"create_goal", "wait_for_goal", "stop", "create_goal_of_robot"} <= set(names)
    tags = {
        path: operations["post"]["tags"]
        for path, operations in schema["paths"].items()
        if "post" in operations
    }
    assert tags["/api/v1/stop"] == tags["/api/v1/pose"] == ["stop"], (
        "generated clients have a module for each tag"
    )
    text = json.dumps(schema)
    assert "HTTPValidationError" not in text
    for reference in {part.partition('"')[0] for part in text.split('"#/components/schemas/')[1:]}:
        assert reference in schema["components"]["schemas"]
    for operation in operations:
        assert operation.get("summary")
        assert any(code.startswith("2") for code in operation["responses"])
        assert {"413", "421", "429", "500", "503"} <= set(operation["responses"])


def test_the_description_says_who_needs_a_token(chassis: Chassis) -> None:
    with serving(chassis, token=TOKEN) as web:
        document = web.get("/openapi.json").json
    assert document["components"]["securitySchemes"]["token"]["scheme"] == "bearer"
    assert document["security"] == [{"token": []}]
    for path, item in document["paths"].items():
        for operation in item.values():
            is_open = path.endswith(("/access", "/login"))
            assert (operation.get("security") == []) == is_open
            assert "401" in operation["responses"] or is_open
    with serving(chassis) as web:
        assert "security" not in web.get("/openapi.json").json


def test_head_answers_wherever_get_does_and_sends_no_body(web: Served) -> None:
    for path in ("status", "marks", "goals", "map.png", "lease", "feeds/pose/stream", "/", "/openapi.json"):
        head = web.ask("HEAD", path)
        assert (head.status, head.body) == (200, b""), path
        assert head.headers["content-type"]
    assert web.ask("HEAD", "map.yaml").headers["content-length"] == str(len(web.get("map.yaml").body))
    assert web.ask("HEAD", "goals/7").status == 404
    context = web.app.state.context  # type: ignore[attr-defined]
    until(lambda: context.streams == 0, what="the end of the streams")


def test_a_client_made_from_the_description_drives_to_a_mark(web: Served) -> None:
    """Every address, body and answer is taken from /openapi.json; nothing is known beforehand but the names."""
    schema = web.get("/openapi.json").json
    found = {
        op["operationId"]: (method, path, op)
        for path, ops in schema["paths"].items()
        for method, op in ops.items()
    }

    def call(name: str, body: Any = None, **parameters: Any) -> Any:
        method, path, operation = found[name]
        known = {p["name"]: p["in"] for p in operation.get("parameters", [])}
        query = "&".join(f"{k}={v}" for k, v in parameters.items() if known[k] == "query")
        for key, value in parameters.items():
            path = path.replace(f"{{{key}}}", str(value))
        answer = web.ask(method.upper(), path + (f"?{query}" if query else ""), body, timeout=70.0)
        assert str(answer.status) in operation["responses"], answer
        content = operation["responses"][str(answer.status)]["content"]["application/json"]["schema"]
        listed = content.get("items", content)
        required = schema["components"]["schemas"][listed["$ref"].rsplit("/", 1)[1]]["required"]
        for one in answer.json if isinstance(answer.json, list) else [answer.json]:
            assert set(required) <= set(one)
        return answer.json

    mark = call("get_marks")[0]["name"]
    goal = call("create_goal", {"kind": "mark", "mark": mark})
    assert call("wait_for_goal", goal=goal["id"], timeout=60)["arrived"] is True


@pytest.mark.parametrize("outer", ["fastapi", "starlette"])
def test_it_is_mounted_in_somebody_elses_application_and_starts_nothing_by_itself(
    chassis: Chassis, outer: str
) -> None:
    import threading

    import uvicorn
    from fastapi import FastAPI
    from starlette.applications import Starlette
    from starlette.responses import PlainTextResponse
    from starlette.routing import Route

    from woosh_pure import web
    from woosh_pure.web.server import WebServer

    before = {thread.name for thread in threading.enumerate()}
    with Chassis(chassis.master_uri) as mine:
        inner = web.app(mine)
        assert not mine._components.feeds.opened
        assert {t.name for t in threading.enumerate() if t.name.startswith("woosh:web")} <= before

        def hello(request: Any) -> PlainTextResponse:
            return PlainTextResponse("mine")

        host = FastAPI() if outer == "fastapi" else Starlette()
        host.router.routes.append(Route("/mine", hello))
        host.mount("/robot", inner)
        host.state.context = inner.state.context  # only for the server of this test
        assert uvicorn
        with WebServer(host, port=0) as server:  # type: ignore[arg-type]
            served = Served(server.port)
            assert served.get("/mine").body == b"mine"
            assert served.get("/robot/api/v1/status").json["robot"] == "robot"
            assert b"<html" in served.get("/robot/").body
            assert served.get("/robot/api/v1/nothing").status == 404
            assert served.post("/robot/api/v1/stop", headers={"origin": "http://evil.example"}).status == 403
            from tests.support.web import PageClient

            with PageClient(server.port, "/robot/api/v1/live") as page:
                assert page.of("hello")["robot"] == "robot"


@pytest.mark.parametrize("name", ["a b", "a/b", "", "x" * 101, "a?b", "a%b"])
def test_a_name_that_cannot_stand_in_an_address_is_refused(chassis: Chassis, name: str) -> None:
    from woosh_pure import web

    with pytest.raises(ValueError, match="robot name"):
        web.app({name: chassis})
