"""STOP stops first, whatever the request looks like and however busy the server is, and complains afterwards."""

from __future__ import annotations

import socket
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from typing import Any

import pytest

from tests.support.waiting import until

pytest.importorskip("fastapi", reason="needs the extra `web`")
pytest.importorskip("uvicorn", reason="needs the extra `web`")
pytest.importorskip("websockets", reason="needs the extra `web`")

from tests.support.gateway_flood import Crowd, PageProcess
from tests.support.load import crowd
from tests.support.web import PageClient, Served, serving
from woosh_pure import Chassis, SimulatedChassis
from woosh_pure.web.middleware import MAX_BODY

FIRST = 5.0
"""Seconds within which a stop has begun: also on a busy computer long before the end of what it may not wait for,
10 s for a body and 20 s for everything else."""
JSON = {"content-type": "application/json"}


@pytest.fixture
def web(chassis: Chassis) -> Iterator[Served]:
    """A server for one robot."""
    with serving(chassis, allow_driving=True) as served:
        yield served


def robot_of(web: Served) -> Any:
    return web.app.state.context.robot(None)  # type: ignore[attr-defined]


def stops(web: Served) -> list[Any]:
    """The stops that the journal tells of."""
    return [entry for entry in robot_of(web).journal.entries() if entry.what.startswith("stop")]


def has_begun(web: Served, count: int = 1) -> bool:
    """Whether so many stops begin, before what they may not wait for."""
    until(lambda: len(stops(web)) >= count, FIRST, "the stop")
    return True


ODD: dict[str, tuple[str, str, dict[str, str], bytes | None, int]] = {
    "a session of before": ("POST", "stop", {"x-woosh-session": "of a server that has ended"}, None, 200),
    "a beacon": ("POST", "stop", {"content-type": "text/plain;charset=UTF-8"}, b"", 200),
    "only ours": ("POST", "stop", JSON, b'{"everything": false}', 200),
    "a form": ("POST", "stop", {"content-type": "application/x-www-form-urlencoded"}, b"a=b", 422),
    "no JSON": ("POST", "stop", JSON, b"{", 422),
    "no object": ("POST", "stop", JSON, b"[]", 422),
    "another member": ("POST", "stop", JSON, b'{"now": true}', 422),
    "no truth value": ("POST", "stop", JSON, b'{"everything": "no"}', 422),
    "a number without end": ("POST", "stop", JSON, b'{"everything": ' + b"1" * 9000 + b"}", 422),
    "no text": ("POST", "stop", JSON, b"\xff\xfe\x00", 422),
    "deeply nested": ("POST", "stop", JSON, b"[" * 20000, 422),
    "a body that is too large": ("POST", "stop", JSON, b"x" * (MAX_BODY + 1), 413),
    "a slash at the end": ("POST", "stop/", {}, None, 200),
    "slashes in between": ("POST", "//api//v1///stop", {}, None, 200),
    "a question behind it": ("POST", "stop?now=1&robot=%00", {}, None, 200),
    "another method": ("PUT", "stop", {}, None, 405),
    "a method of nobody": ("BREW", "stop/", JSON, b"{", 405),
    "a robot's name": ("POST", "robots/robot/stop", {}, None, 200),
    "a robot's page": ("POST", "/robots/robot/api/v1/stop/", {}, None, 200),
    "a robot of before": ("POST", "/robots/yesterday/api/v1/stop", {}, None, 404),
}


@pytest.mark.promise("STOP in the page")
@pytest.mark.parametrize("name", ODD)
def test_a_stop_stops_first_and_complains_afterwards(web: Served, name: str) -> None:
    method, path, headers, body, status = ODD[name]
    answer = web.ask(method, path, body, headers=headers)
    done = [(entry.what, entry.state) for entry in stops(web)]
    ours, everything = ("stop what is ours", "stands still"), ("stop", "stands still")
    assert set(done) == ({ours} if name == "only ours" else {ours, everything} if body else {everything})
    assert answer.status == status, answer
    assert answer.json["stands_still"] is True
    if status != 200:
        assert answer.problem.startswith("stopped anyway: the robot stands still")


def test_a_page_of_before_the_server_was_started_again_stops_its_robot(web: Served) -> None:
    """The page sends the session that it had; the goal is cancelled all the same."""
    number = web.post("goals", {"kind": "mark", "mark": "B1"}).json["id"]
    answer = web.post("stop", headers={"x-woosh-session": "yesterday"})
    assert (answer.status, answer.json["stands_still"]) == (200, True)
    assert web.get(f"goals/{number}").json["state"] == "cancelled"
    assert stops(web)[0].who == "page of another session at 127.0.0.1"


def test_looking_is_no_stop(web: Served) -> None:
    for method in ("GET", "HEAD", "OPTIONS", "TRACE"):
        for path in ("stop", "stop/", "robots/robot/stop"):
            assert web.ask(method, path).status in (404, 405)
    assert stops(web) == []


def begun(web: Served, head: str, stack: ExitStack) -> socket.socket:
    """A request of which only so much has been sent."""
    one = stack.enter_context(socket.create_connection(("127.0.0.1", web.port), timeout=20))
    one.sendall(f"{head}\r\nHost: 127.0.0.1\r\n".encode())
    return one


def answer_of(one: socket.socket) -> str:
    """All that comes until the connection is closed, or the answer is complete."""
    got = b""
    while part := one.recv(65536):
        got += part
        if got.endswith(b"}"):
            break
    return got.decode()


@pytest.mark.promise("STOP in the page")
@pytest.mark.parametrize("announced", ["Content-Length: 60000", "Transfer-Encoding: chunked"])
def test_a_body_that_never_ends_holds_no_stop_up(web: Served, announced: str) -> None:
    web.post("goals", {"kind": "mark", "mark": "B1"})
    with ExitStack() as stack:
        one = begun(web, "POST /api/v1/stop HTTP/1.1", stack)
        one.sendall(f"{announced}\r\nContent-Type: application/json\r\n\r\n".encode())
        assert has_begun(web)
        answer = answer_of(one)
    assert answer.startswith("HTTP/1.1 408")
    assert "stopped anyway: the robot stands still" in answer
    assert web.get("goals/1").json["state"] == "cancelled"


@pytest.mark.promise("A stop is executed before its body is read")
def test_a_body_of_100_megabytes_holds_no_stop_up(web: Served) -> None:
    size, part = 100_000_000, b"x" * 1_000_000
    with ExitStack() as stack:
        one = begun(web, "POST /api/v1/stop HTTP/1.1", stack)
        one.sendall(f"Content-Length: {size}\r\nContent-Type: application/json\r\n\r\n".encode())
        assert has_begun(web)
        for _ in range(size // len(part)):
            one.sendall(part)
        answer = answer_of(one)
    assert answer.startswith("HTTP/1.1 413")
    assert "stopped anyway" in answer


def test_the_answer_is_not_lost_while_the_body_is_still_being_sent(
    web: Served, until: Callable[..., None]
) -> None:
    """A server that closes the connection then resets it, and the client may lose the answer."""
    size, part = 20_000_000, b"x" * 1_000_000
    with ExitStack() as stack:
        one = begun(web, "POST /api/v1/stop HTTP/1.1", stack)
        one.sendall(f"Content-Length: {size}\r\nContent-Type: application/json\r\n\r\n".encode() + part)
        answer = answer_of(one)
        assert answer.startswith("HTTP/1.1 413")
        assert "stopped anyway" in answer
        assert {entry.state for entry in stops(web)} == {"stands still"}
        for _ in range(size // len(part) - 1):
            one.sendall(part)
        assert one.recv(1) == b"", "the connection ends when the body has come"


def test_only_ours_is_stopped_where_the_body_says_so(web: Served, chassis: Chassis) -> None:
    """A body in a packet of its own is waited for a moment; what is ours ends before it has come."""
    wanted: list[bool] = []
    stop = chassis.stop

    def watched(**options: Any) -> Any:
        wanted.append(options["everything"])
        return stop(**options)

    chassis.stop = watched  # type: ignore[method-assign]
    body = b'{"everything": false}'
    with ExitStack() as stack:
        one = begun(web, "POST /api/v1/stop HTTP/1.1", stack)
        one.sendall(f"Content-Length: {len(body)}\r\nContent-Type: application/json\r\n\r\n".encode())
        assert has_begun(web)
        one.sendall(body)
        assert answer_of(one).startswith("HTTP/1.1 200")
    assert wanted == [False]


@pytest.mark.promise("STOP in the page")
def test_a_stop_begins_although_all_threads_of_requests_and_stops_wait(web: Served, chassis: Chassis) -> None:
    """Fifty requests wait in threads, and another robot's stops for a robot that does not answer."""
    go_on = threading.Event()
    with Chassis(chassis.master_uri) as other, serving({"hall": chassis, "yard": other}) as both:
        context = both.app.state.context  # type: ignore[attr-defined]
        waiting: list[str] = []

        def wait(what: str) -> Any:
            waiting.append(what)
            return go_on.wait(30.0)

        context.robot("hall").map.get = lambda: wait("a request")
        other.stop = lambda **options: wait("a stop")  # type: ignore[method-assign, assignment]
        try:
            with ExitStack() as stack:
                for number in range(100):
                    one = stack.enter_context(socket.create_connection(("127.0.0.1", both.port), timeout=10))
                    slow = ("GET /api/v1/map", "POST /api/v1/robots/yard/stop")[number % 2]
                    one.sendall(f"{slow} HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n".encode())
                # All of them: forty for requests, eight for the stops of the other robot.
                until(lambda: len(waiting) >= 48, what=lambda: f"48 threads that wait, not {len(waiting)},")
                stop = ThreadPoolExecutor(1).submit(both.post, "stop")
                assert has_begun(both)
                go_on.set()
                assert stop.result(20.0).status == 200
        finally:
            go_on.set()


def test_a_stop_while_another_is_under_way_ends_what_has_begun_meanwhile(
    web: Served, chassis: Chassis
) -> None:
    """The first one waits for a robot that does not come to rest: the second is a stop of its own."""
    go_on, begun = threading.Event(), []
    stop = chassis.stop

    def slow(**options: Any) -> Any:
        begun.append(options)
        go_on.wait(20.0)
        return stop(**options)

    chassis.stop = slow  # type: ignore[method-assign]
    first = threading.Thread(target=web.post, args=("stop",))
    first.start()
    assert has_begun(web)
    chassis.stop = stop  # type: ignore[method-assign]
    number = web.post("goals", {"kind": "mark", "mark": "B1"}).json["id"]
    try:
        assert web.post("stop").json["stands_still"] is True
        assert web.get(f"goals/{number}").json["state"] == "cancelled"
    finally:
        go_on.set()
        first.join(20.0)


@pytest.mark.promise("A stop is executed before its body is read")
def test_a_flood_of_stops_takes_few_threads_and_the_last_one_counts(web: Served, chassis: Chassis) -> None:
    stop, most, now = chassis.stop, [0], [0]
    lock = threading.Lock()

    def counted(**options: Any) -> Any:
        with lock:
            now[0] += 1
            most[0] = max(most[0], now[0])
        try:
            return stop(**options)
        finally:
            with lock:
                now[0] -= 1

    chassis.stop = counted  # type: ignore[method-assign]
    with ExitStack() as stack:
        asked = [begun(web, "POST /api/v1/stop HTTP/1.1", stack) for _ in range(60)]
        for one in asked:
            one.sendall(b"\r\n")
        assert all(answer_of(one).startswith("HTTP/1.1 200") for one in asked)
    assert 1 <= most[0] <= 8


def test_a_stop_needs_no_thread_that_can_be_started(
    web: Served, chassis: Chassis, monkeypatch: pytest.MonkeyPatch
) -> None:
    done = threading.Event()
    stop = chassis.stop

    def told(**options: Any) -> Any:
        monkeypatch.undo()
        done.set()
        return stop(**options)

    chassis.stop = told  # type: ignore[method-assign]

    def refuse(thread: threading.Thread) -> None:
        raise RuntimeError("can't start new thread")

    connection = socket.create_connection(("127.0.0.1", web.port), timeout=20)
    with connection:
        monkeypatch.setattr(threading.Thread, "start", refuse)
        connection.sendall(b"POST /api/v1/stop HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n")
        assert done.wait(FIRST)
        assert answer_of(connection).startswith("HTTP/1.1 200")


def test_a_page_stops_over_its_connection_too(web: Served, chassis: Chassis) -> None:
    """It is told at once that the stop has begun, and then what stands still. No lease, no confirmation."""
    number = web.post("goals", {"kind": "mark", "mark": "B1"}).json["id"]
    assert chassis.lease.acquire("the night shift")
    with PageClient(web.port) as page:
        page.of("hello")
        page.say(t="stop", n=7)
        page.of("stop", n=7, state="begun")
        assert page.of("stop", n=7, state="done")["stands_still"] is True
        assert stops(web)[0].who.startswith("page 1 ")
    assert web.get(f"goals/{number}").json["state"] == "cancelled"


@pytest.mark.promise("STOP in the page")
def test_a_stop_over_the_connection_waits_for_nothing_that_was_asked_before(
    web: Served, until: Callable[..., None]
) -> None:
    """The camera takes its time to be subscribed, and all threads that look at the robot wait."""
    go_on = threading.Event()
    robot_of(web).cameras["color"].add_viewer = lambda: go_on.wait(20.0)
    with PageClient(web.port) as page:
        page.of("hello")
        try:
            page.say(t="look", camera="color")
            page.say(t="stop", n=1)
            assert has_begun(web)
            page.of("stop", n=1, state="done")
        finally:
            go_on.set()


@pytest.mark.promise("a viewer that floods does not delay STOP, a zero or the end of a drive")
@pytest.mark.slow
@pytest.mark.parametrize("clients", [1, 63])
@pytest.mark.parametrize("what", ["tiny invalid messages", "messages of 3000 frames", "pings", "pongs"])
def test_a_viewer_that_floods_delays_no_stop(sim: SimulatedChassis, what: str, clients: int) -> None:
    """The robot turns, and stands still as soon as it does with nobody else there; by its odometry.

    By the robot's own time: on a busy computer the simulator, in this process, may get nothing to compute for
    seconds, and the stop then waits for a robot that cannot brake.
    """

    def own_seconds() -> float:
        with sim.lock:
            return sim.world.time / sim.speed

    with Chassis(sim.master_uri) as chassis, PageProcess(sim.master_uri, stop_seconds=25.0) as server:
        web = Served(server.port)
        with Crowd(server.port, what, clients, "/api/v1/live"):
            chassis.rotate(60.0, several_turns=True)
            until(lambda: abs(chassis.odometry.wait(timeout=20).velocity.wz) > 0.05, 30.0, "the turning")
            began = own_seconds()
            answer = web.post("stop")
            assert own_seconds() - began < 2.0 * crowd(), answer
            assert answer.json["stands_still"] is True, answer
            until(lambda: abs(chassis.odometry.wait(timeout=20).velocity.wz) < 0.01, what="standing")
