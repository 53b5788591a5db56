"""The live connection of the page: what is sent, at whose pace, and who may drive when."""

from __future__ import annotations

import json
import math
import socket
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

from tests.support.waiting import until

pytest.importorskip("fastapi", reason="needs the extra `web`")
pytest.importorskip("uvicorn", reason="needs the extra `web`")
pytest.importorskip("websockets", reason="needs the extra `web`")

import rosproto
from rosproto import Node
from tests.support.load import crowd
from tests.support.proxy import FaultProxy
from tests.support.slow_link import SlowLink
from tests.support.web import PageClient, Served, serving
from woosh_pure import Chassis, SimulatedChassis, interface
from woosh_pure.geometry import Pose2D
from woosh_pure.maps.gridmap import GridMap, grid_message
from woosh_pure.web import server
from woosh_pure.web.camera import COSTMAP as COSTMAP_ROW
from woosh_pure.web.live import deadman, frame_pacing, page_driving, robot_state, viewer
from woosh_pure.web.live.frames import CAMERA, COSTMAP, PART, SCAN

ZEROS = 1.0


@pytest.fixture
def web(chassis: Chassis) -> Iterator[Served]:
    """A server that allows driving."""
    with serving(chassis, allow_driving=True) as served:
        yield served


@pytest.fixture
def page(web: Served) -> Iterator[PageClient]:
    """A page on it."""
    with PageClient(web.port) as hand:
        hand.of("hello")
        yield hand


def hub_of(web: Served) -> Any:
    return web.app.state.context.hubs["robot"]  # type: ignore[attr-defined]


def test_a_page_is_shown_everything(page: PageClient) -> None:
    hello = page.of("hello")
    assert hello["allow_driving"] is True
    assert hello["limits"] == {"vx": 0.3, "wz": 0.5}
    for kind in ("pose", "map", "marks", "plan", "journal", "lease"):
        page.of(kind)
    assert set(page.of("pose")) == {"t", "x", "y", "yaw", "age"}
    page.wait(lambda d: d["t"] == "state" and d.get("battery"))
    page.wait(lambda d: d["t"] == "state" and d.get("readiness"))
    ages = page.wait(lambda d: d["t"] == "state" and d["ages"].get("pose") is not None)["ages"]
    assert ages["pose"] < 10.0
    assert len(page.frame(SCAN)) > 24


def test_a_robot_that_brakes_after_a_drive_by_hand_is_not_under_way() -> None:
    """Neither the word nor the path of an earlier, cancelled goal comes back when the control is let go."""
    with (
        SimulatedChassis() as simulated,
        Chassis(simulated.master_uri) as chassis,
        serving(chassis, allow_driving=True) as web,
        PageClient(web.port) as page,
    ):
        goal = chassis.go_to(4.0, 2.0)
        page.wait(lambda d: d["t"] == "plan" and d["points"])
        goal.cancel()
        page.wait(lambda d: d.get("activity") == "idle")
        page.ready()
        page.drive(0.3)
        until(lambda: simulated.world.body.velocity.vx > 0.25, 5.0)
        page.forget()
        page.let_go()
        page.wait(lambda d: d.get("activity", "driven") != "driven")
        until(lambda: robot_state.activity(web.app.state.context.robots["robot"]) == "idle", 5.0)  # type: ignore[attr-defined]
        assert "under way" not in [d.get("activity") for d in page.heard]
        assert not [d for d in page.heard if d["t"] == "plan" and d["points"]]


def test_parts_that_did_not_change_are_not_sent_again(page: PageClient) -> None:
    page.wait(lambda d: d["t"] == "state" and d.get("readiness"))
    page.forget()
    for _ in range(3):
        page.forget()
        page.of("pose")
    assert not [d for d in page.heard if d["t"] in ("map", "marks", "footprint")]


def test_the_camera_is_subscribed_only_while_somebody_looks(web: Served, page: PageClient) -> None:
    camera = web.app.state.context.robot(None).cameras["color"]  # type: ignore[attr-defined]
    assert not camera.open
    page.say(t="look", camera="color", costmap=False)
    frame = page.frame(CAMERA)
    assert frame[1] == 0
    assert frame[2:4] == b"\xff\xd8"
    page.say(t="look", camera=None)
    until(lambda: not camera.open, what="the end of the camera")


def test_a_costmap_that_does_not_change_is_shown_to_the_next_page_too(
    page: PageClient, sim: SimulatedChassis
) -> None:
    """It is latched, and sent once; a page that looks again soon gets it although nothing new has come."""
    with Node("costs", master_uri=sim.master_uri, anonymous=True) as node:
        message = grid_message(GridMap(np.full((4, 4), 1, np.int8), 0.05, Pose2D(0.0, 0.0)))
        publisher = node.publisher(COSTMAP_ROW.name, "nav_msgs/OccupancyGrid", latch=True)
        publisher.publish(message)
        for _ in range(2):
            page.say(t="look", costmap=True)
            page.frame(COSTMAP)
            page.say(t="look", costmap=False)
            page.forget()


def test_with_the_last_page_everything_rests(web: Served) -> None:
    with PageClient(web.port) as page:
        page.say(t="look", camera="depth", costmap=False)
        page.frame(CAMERA)
    hub, camera = hub_of(web), web.app.state.context.robot(None).cameras["depth"]  # type: ignore[attr-defined]
    until(lambda: not hub._tasks and not camera.open, what=lambda: f"the rest of {hub._tasks}, {camera.open}")


def test_a_lost_robot_is_said_in_words_within_two_seconds(sim: SimulatedChassis, page: PageClient) -> None:
    page.of("lost", text=None)
    page.frame(SCAN)
    page.forget()
    began = time.monotonic()
    with sim.lock:  # the robot freezes: its links stay open, and nothing comes
        lost = page.wait(lambda d: d["t"] == "lost" and d["text"])
        seconds = time.monotonic() - began
    assert "nothing was heard of the robot" in lost["text"]
    assert seconds < 2.5 * crowd(), "1.5 s of silence, and a busy computer"
    page.forget()
    page.of("lost", text=None)


@pytest.mark.promise("until then at most two frames wait for it")
def test_a_page_that_acknowledges_nothing_gets_two_frames_and_a_sentence(
    web: Served, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(frame_pacing, "NOTHING_READ", 0.5)
    with PageClient(web.port, acks=False) as page:
        page._reader.join(20)
        assert page.socket.close_code == 4408
        assert "stopped reading" in (page.socket.close_reason or "")
        assert page.count <= 4, "hello, and two frames; what is said to it alone is little"


def test_over_a_slow_link_the_pose_keeps_nothing_away(web: Served) -> None:
    """Whenever such a page takes a frame, pose and scan are new again: the others have their turn all the same."""
    with PageClient(web.port, acks=False) as page:
        page.of("hello")
        for frames in range(1, 25):
            until(lambda had=frames: page.count > had, what="the next frame")  # type: ignore[misc]
            time.sleep(0.15)  # in which there is a new pose, and a new scan
            page.say(t="ack", n=frames)
        heard = [document["t"] for document in page.heard]
        assert {"pose", "state", "lost", "map", "marks", "plan", "journal", "lease"} <= set(heard)
        assert heard.count("pose") >= 6
        assert page.frames, "scans"


@pytest.mark.slow  # until a ping without a pong ends it
@pytest.mark.promise("until then at most two frames wait for it")
def test_a_page_that_stops_reading_costs_no_memory(chassis: Chassis, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its socket is not read at all; the server keeps versions of kinds, and no queue."""
    monkeypatch.setattr(server, "PONG_SECONDS", min(2.0 * crowd(), server.PONG_SECONDS))
    with (
        serving(chassis) as web,
        socket.create_connection(("127.0.0.1", web.port)) as raw,
        PageClient(web.port) as other,
    ):
        raw.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 2048)
        raw.sendall(
            b"GET /api/v1/live HTTP/1.1\r\nHost: 127.0.0.1\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            b"Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n"
        )
        other.of("hello")
        context = web.app.state.context  # type: ignore[attr-defined]
        until(lambda: context.viewers == 2, what="both pages")
        until(lambda: context.viewers == 1, what="the end of the one without a pong")
        other.forget()
        other.of("pose")


NONSENSE = [
    "",
    "x",
    "null",
    "[]",
    "1",
    "{}",
    '{"t":7}',
    '{"t":"fly"}',
    '{"t":"ack"}',
    '{"t":"ack","n":-1}',
    '{"t":"ack","n":1e9}',
    '{"t":"ack","n":true}',
    '{"t":"ack","n":99999}',
    '{"t":"beat","seq":"1"}',
    '{"t":"press","seq":1,"at":NaN}',
    '{"t":"press","seq":1,"at":1,"vx":"fast"}',
    '{"t":"press","seq":1,"at":1,"vx":Infinity}',
    '{"t":"press","seq":1.5}',
    '{"t":"press","seq":1,"vx":1e400}',
    '{"t":"look","camera":"rear"}',
    '{"t":"look","camera":null,"costmap":3}',
    '{"t":"lease","op":"steal"}',
    "[" * 4000,
    '{"t":' + '"x' * 1000,
    b"\x00\x01",
    "x" * 5000,
    '{"t":"press","seq":' + "9" * 4000 + "}",
]


@pytest.mark.promise("a message that is not valid ends that connection with an error text")
@pytest.mark.parametrize("text", NONSENSE, ids=lambda text: repr(text[:24]))
def test_nonsense_ends_that_connection_in_a_sentence(
    web: Served, page: PageClient, text: str | bytes
) -> None:
    with PageClient(web.port) as other:
        other.of("hello")
        other.socket.send(text)
        other._reader.join(10)
        assert other.socket.close_code == 1008
        assert other.socket.close_reason
    page.forget()
    page.of("pose")


@pytest.mark.promise("a message that is not valid ends that connection with an error text")
def test_a_flood_ends_that_connection(web: Served) -> None:
    with PageClient(web.port, acks=False) as page:
        page.of("hello")
        try:
            for _ in range(2000):
                page.say(t="confirm")
        except Exception:
            pass  # it was closed while we sent
        page._reader.join(10)
        assert page.socket.close_code == 1008


@pytest.mark.promise("requested by a page of another site")
def test_a_foreign_page_gets_no_connection(web: Served) -> None:
    from websockets.exceptions import InvalidStatus

    for headers in ({"origin": "http://evil.example"},):
        with pytest.raises(InvalidStatus):
            PageClient(web.port, additional_headers=headers)


@pytest.mark.promise("admit clients by the same rules")
def test_without_the_token_the_page_is_told_why(chassis: Chassis) -> None:
    with serving(chassis, token="a-long-secret") as web:
        with PageClient(web.port) as page:
            page._reader.join(10)
            assert page.socket.close_code == 4401
            assert "token" in (page.socket.close_reason or "")
        cookie = web.post("login", {"token": "a-long-secret"}).headers["set-cookie"].partition(";")[0]
        with PageClient(web.port, additional_headers={"cookie": cookie}) as page:
            page.of("hello")


def test_a_robot_that_is_not_there_is_told(web: Served) -> None:
    with PageClient(web.port, "/api/v1/robots/cellar/live") as page:
        page._reader.join(10)
        assert page.socket.close_code == 4404


@pytest.mark.promise("200 goals and 20 bags are kept")
def test_more_pages_than_are_shown_are_told(web: Served, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(web.app.state.context, "max_viewers", 1)
    with PageClient(web.port) as first:
        first.of("hello")
        with PageClient(web.port) as second:
            second._reader.join(10)
            assert second.socket.close_code == 4429


# -- the lease, and driving ----------------------------------------------------------------------------------


def test_the_lease_goes_from_hand_to_hand_only_by_asking(web: Served, chassis: Chassis) -> None:
    with PageClient(web.port) as anna, PageClient(web.port) as bert:
        a, b = anna.of("hello")["you"], bert.of("hello")["you"]
        anna.say(t="lease", op="ask")
        anna.of("lease", yours=True)
        assert chassis.lease.holder == a, "programs see it"
        bert.of("lease", holder=a)
        bert.say(t="lease", op="ask")
        anna.of("lease", asking=[b])
        bert.say(t="lease", op="grant", to=b)
        bert.wait(lambda d: d["t"] == "lease" and d["asking"] == [b])
        assert chassis.lease.holder == a
        anna.say(t="lease", op="grant", to=b)
        bert.of("lease", yours=True)
        bert.say(t="lease", op="give")
        anna.wait(
            lambda d: d["t"] == "lease" and d["holder"] is None and not d["asking"] and d["seconds"] == 0.0
        )


def test_a_closed_page_gives_the_lease_back_though_its_script_said_nothing(
    web: Served, chassis: Chassis, until: Callable[..., None]
) -> None:
    """What a page sends while it is closed need not arrive: the browser's own word is enough."""
    with PageClient(web.port) as page:
        page.say(t="lease", op="ask")
        page.of("lease", yours=True)
        page.socket.close(code=1001)
        until(lambda: chassis.lease.holder is None, what="control being free")


def test_a_page_that_is_cut_off_keeps_the_lease_for_its_return(
    web: Served, chassis: Chassis, until: Callable[..., None]
) -> None:
    """A network that is cut is not a page that was closed."""
    with PageClient(web.port) as page:
        name = page.of("hello")["you"]
        page.say(t="lease", op="ask")
        page.of("lease", yours=True)
        page.socket.socket.shutdown(socket.SHUT_RDWR)
        context = web.app.state.context  # type: ignore[attr-defined]
        until(lambda: context.viewers == 0, what="the connection being gone")
        assert chassis.lease.holder == name


def test_the_lease_of_a_killed_browser_lapses_in_seconds_unless_it_comes_back(
    web: Served, chassis: Chassis, until: Callable[..., None], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(viewer, "GONE_SECONDS", 1.5)
    context = web.app.state.context  # type: ignore[attr-defined]
    with PageClient(web.port) as page:
        hello = page.of("hello")
        page.say(t="lease", op="ask")
        page.of("lease", yours=True)
        page.socket.socket.shutdown(socket.SHUT_RDWR)
        until(lambda: context.viewers == 0, what="the connection being gone")
    with PageClient(web.port, f"/api/v1/live?session={hello['session']}") as back:
        assert back.of("hello")["you"] == hello["you"]
        assert back.of("lease", yours=True)["seconds"] > 30.0, "it has come back"
        back.socket.socket.shutdown(socket.SHUT_RDWR)
        until(lambda: context.viewers == 0, what="the connection being gone again")
    gone = time.monotonic()
    until(lambda: chassis.lease.holder is None, what="control being free")
    assert time.monotonic() - gone < 3.0 * crowd()


def test_a_page_that_has_gone_asks_for_nothing_any_more(
    web: Served, chassis: Chassis, until: Callable[..., None]
) -> None:
    """However it went: the holder is not asked in its name. Whoever holds the lease keeps it for its return."""
    with PageClient(web.port) as first:
        first.say(t="lease", op="ask")
        first.of("lease", yours=True)
        with PageClient(web.port) as second:
            second.say(t="lease", op="ask")
            first.wait(lambda d: d["t"] == "lease" and d["asking"])
            first.forget()
            second.socket.socket.shutdown(socket.SHUT_RDWR)  # nobody says good-bye
            first.wait(lambda d: d["t"] == "lease" and not d["asking"] and d["yours"])
        holder = chassis.lease.holder
        first.socket.socket.shutdown(socket.SHUT_RDWR)
        until(lambda: web.app.state.context.viewers == 0)  # type: ignore[attr-defined]
        assert chassis.lease.holder == holder


def test_orders_of_the_page_count_for_its_lease(web: Served, page: PageClient) -> None:
    session_of = {"x-woosh-session": page.of("hello")["session"]}
    page.ready()
    assert web.post("goals", {"kind": "move", "distance": 0.1}).status == 409
    answer = web.post("goals", {"kind": "move", "distance": 0.1}, headers=session_of)
    assert answer.status == 201
    assert answer.json["who"] == page.of("hello")["you"]
    wrong = web.post("goals", {"kind": "move", "distance": 0.1}, headers={"x-woosh-session": "guess"})
    assert wrong.status == 403
    assert "this session is over" in wrong.problem


def test_a_page_that_comes_back_is_the_same_person(web: Served) -> None:
    with PageClient(web.port) as page:
        hello = page.of("hello")
        page.ready()
    until(lambda: not web.app.state.context.viewers, what="the end of the page")  # type: ignore[attr-defined]
    with PageClient(web.port, f"/api/v1/live?session={hello['session']}") as page:
        assert page.of("hello")["you"] == hello["you"]
        page.of("lease", yours=True)


def test_a_reloaded_page_keeps_its_name_while_its_old_connection_is_open(
    web: Served, chassis: Chassis, until: Callable[..., None], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The old connection and its drive end; the new one has the lease, and has to confirm the warning again."""
    monkeypatch.setattr(viewer, "GONE_SECONDS", 0.5)
    context = web.app.state.context  # type: ignore[attr-defined]
    with PageClient(web.port) as old:
        hello = old.of("hello")
        old.ready()
        old.drive()
        with PageClient(web.port, f"/api/v1/live?session={hello['session']}") as new:
            assert new.of("hello")["you"] == hello["you"]
            old.of("drive", state="ended", reason="gone")
            until(lambda: old.socket.close_code == 4409, what="the end of the old connection")
            until(lambda: context.viewers == 1, what="only the new connection")
            refused(new, "not confirmed")
            new.forget()
            new.say(t="lease", op="keep")
            assert new.of("lease", yours=True)["seconds"] > 30.0
        until(lambda: context.viewers == 0, what="the end of the new connection")
        with PageClient(web.port, f"/api/v1/live?session={hello['session']}") as again:
            assert again.of("hello")["you"] == hello["you"]


def refused(page: PageClient, reason: str) -> dict[str, Any]:
    page.press()
    return page.of("drive", state="refused", reason=reason)


@pytest.mark.promise("driving by velocity needs `--allow-driving`, the lease and")
def test_driving_needs_the_lease_and_the_confirmation(page: PageClient, chassis: Chassis) -> None:
    refused(page, "no lease")
    page.say(t="lease", op="ask")
    page.of("lease", yours=True)
    refused(page, "not confirmed")
    assert not chassis.moved


def test_nobody_drives_through_a_slow_network(web: Served, chassis: Chassis) -> None:
    """A constant delay makes no beat late: what tells it is how long a frame and its acknowledgement take."""
    with FaultProxy("127.0.0.1", web.port) as proxy, PageClient(proxy.port) as page:
        page.of("hello")
        page.ready()
        page.of("pose")
        proxy.delay(0.3)
        page.forget()
        page.wait(lambda d: d["t"] == "state" and "ages" in d)
        time.sleep(1.5)  # what was sent before has arrived
        assert "nobody can drive through that" in refused(page, "slow link")["text"]
    assert not chassis.moved


@pytest.mark.promise("driving by velocity needs `--allow-driving`, the lease and")
def test_driving_is_off_unless_it_was_allowed(chassis: Chassis) -> None:
    with serving(chassis) as web, PageClient(web.port) as page:
        assert page.of("hello")["allow_driving"] is False
        page.ready()
        assert "--allow-driving" in refused(page, "not allowed")["text"]
    assert not chassis.moved


def test_holding_drives_and_letting_go_stands(
    page: PageClient, chassis: Chassis, until: Callable[..., None], real_time: Callable[[], None]
) -> None:
    page.ready()
    page.drive()
    chassis.measured_velocity.wait_for(lambda v: v.vx > 0.1, 10.0)
    page.let_go()
    assert page.of("drive", state="ended")["reason"] == "released"
    chassis.measured_velocity.wait_for(lambda v: v.is_standing(), 10.0)
    page.forget()
    for _ in range(5):  # the finger is still there for a slow page: nothing resumes
        page.beat()
    page.drive()
    page.let_go()


def test_a_press_while_an_earlier_one_is_still_being_opened(
    web: Served,
    page: PageClient,
    chassis: Chassis,
    monkeypatch: pytest.MonkeyPatch,
    until: Callable[..., None],
    real_time: Callable[[], None],
) -> None:
    """The drive of a press that nobody holds any more must not keep others from driving."""
    teleop = web.app.state.context.robot(None).manual_drive  # type: ignore[attr-defined]
    monkeypatch.setattr("woosh_pure.web.live.manual_drive.ZEROS_SECONDS", ZEROS)
    begin, first, go_on = teleop._begin, threading.Event(), threading.Event()

    def slowly() -> Any:
        if not first.is_set():
            first.set()
            go_on.wait(10.0)
        return begin()

    monkeypatch.setattr(teleop, "_begin", slowly)
    page.ready()
    page.press()
    assert first.wait(10.0)
    page.say(t="release")
    page.of("drive", state="ended", reason="released")
    page.drive(state="opening")
    go_on.set()
    said = page.wait(lambda d: d["t"] == "drive" and d["state"] in ("driving", "ended"))
    if said["state"] == "ended":  # on a busy computer the thread that beats may be late
        assert said["reason"] in ("silent", "late"), said
        page.let_go()
        page.drive()
    time.sleep(1.2 * ZEROS)  # what waits for the seat has given up by then
    page.let_go()
    until(lambda: teleop.driver is None, what="the seat being free")
    page.forget()
    page.drive()
    page.let_go()
    until(lambda: teleop.driver is None, what="the seat being free again")


def test_a_page_that_goes_while_another_drives_ends_nothing_of_it(
    web: Served,
    page: PageClient,
    chassis: Chassis,
    monkeypatch: pytest.MonkeyPatch,
    real_time: Callable[[], None],
) -> None:
    """Its own drive was refused, and only after it had gone. The other's heartbeats may be late on a busy computer."""
    teleop = web.app.state.context.robot(None).manual_drive  # type: ignore[attr-defined]
    me = page.of("hello")["you"]
    page.ready()
    page.drive()
    opens, asked, refuse = teleop.open, threading.Event(), threading.Event()

    def late(driver: str) -> None:
        asked.set()
        refuse.wait(10.0)
        opens(driver)

    monkeypatch.setattr(teleop, "open", late)
    context = web.app.state.context  # type: ignore[attr-defined]
    with PageClient(web.port) as other:
        monkeypatch.setattr(page_driving.PageDriving, "_refusal", lambda _: None)
        other.press()
        assert asked.wait(10.0)
    until(lambda: context.viewers == 1, what="the end of the other page")
    refuse.set()
    until(lambda: teleop.driver is None or getattr(chassis.measured_velocity.latest, "vx", 0.0) > 0.1)
    time.sleep(0.3)
    driver = teleop.driver
    page.let_go()
    ended = page.of("drive", state="ended")["reason"]
    assert (driver, ended) == (me, "released") or ended in ("silent", "late")


def test_a_velocity_beyond_the_limits_is_brought_within_them(
    page: PageClient, chassis: Chassis, real_time: Callable[[], None]
) -> None:
    page.ready()
    limit = page.drive(5.0)["limits"]["vx"]
    chassis.measured_velocity.wait_for(lambda v: v.vx > 0.9 * limit, 10.0)
    assert all(reading.value.vx < 1.1 * limit for reading in chassis.measured_velocity.known_history)
    page.let_go()


@pytest.mark.promise("STOP in the page")
def test_a_stop_of_anybody_ends_the_drive_and_nothing_resumes(
    web: Served,
    page: PageClient,
    chassis: Chassis,
    real_time: Callable[[], None],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # A beat that a busy computer delays does not end the drive before the stop.
    monkeypatch.setattr(deadman, "SILENCE_SECONDS", 60.0)
    page.ready()
    page.drive()
    assert web.post("stop").json["stands_still"] is True
    ended = page.of("drive", state="ended")
    assert ended["reason"] == "over"
    assert "stopped the robot" in ended["text"]
    assert chassis.measured_velocity.wait(5.0).is_standing(), "although the beats go on"
    page.stop_beating()


def test_giving_the_lease_back_ends_the_drive(
    page: PageClient, chassis: Chassis, real_time: Callable[[], None]
) -> None:
    page.ready()
    page.drive()
    page.say(t="lease", op="give")
    assert page.of("drive", state="ended")["reason"] == "no lease"
    page.stop_beating()


def test_one_drives_at_a_time(
    web: Served, page: PageClient, chassis: Chassis, real_time: Callable[[], None]
) -> None:
    page.ready()
    page.drive(0.1)
    with PageClient(web.port) as other:
        other.say(t="confirm")
        other.say(t="lease", op="ask")
        refused(other, "no lease")
    page.let_go()


def test_a_press_while_a_goal_is_under_way_is_refused_in_words(web: Served, page: PageClient) -> None:
    session_of = {"x-woosh-session": page.of("hello")["session"]}
    page.ready()
    web.post("goals", {"kind": "mark", "mark": "B1"}, headers=session_of)
    page.hold(0.2)
    assert page.wait(lambda d: d["t"] == "drive" and d["state"] == "refused")["text"]
    page.stop_beating()
    web.post("stop")


def test_what_is_said_is_json_without_nan(page: PageClient) -> None:
    page.wait(lambda d: d["t"] == "state" and "readiness" in d)
    json.dumps(page.heard, allow_nan=False)


def no_numbers(message: Any) -> Any:
    """The message, with nothing in it that is a number."""
    for name, kind in zip(message.__slots__, message._slot_types, strict=True):
        value = getattr(message, name)
        if kind in ("float32", "float64"):
            setattr(message, name, math.nan)
        elif kind.startswith("float") and kind.endswith("[]"):
            setattr(message, name, [math.inf, math.nan] * 10)
        elif hasattr(value, "_slot_types"):
            no_numbers(value)
    return message


NUMBERS = ("odometer", "velocity", "battery", "localization", "information", "scan")


def test_what_is_no_number_takes_nothing_else_along(
    web: Served, sim: SimulatedChassis, caplog: pytest.LogCaptureFixture
) -> None:
    """A peer says NaN on each topic, fifty times a second: poses and the rest go on, and all that is said is JSON."""
    with Node("nan", master_uri=sim.master_uri, anonymous=True) as node, PageClient(web.port) as page:
        page.of("pose")
        saying = []
        for name in NUMBERS:
            row = interface.find(name)
            message = no_numbers(rosproto.message_class(row.type)())
            saying.append((node.publisher(row.name, row.type), message))
        for publisher, _ in saying:
            publisher.wait_for_connection(timeout=10)
        page.forget()
        poses, until = 0, time.monotonic() + 12.0
        while poses <= 15 and time.monotonic() < until:
            for publisher, message in saying:
                publisher.publish(message)
            time.sleep(0.02)
            poses = sum(one["t"] == "pose" for one in page.heard)
        assert poses > 15, "it was one a second"
        for publisher, message in saying:
            publisher.publish(message)
        for path in ("snapshot", "status", "readiness", *(f"feeds/{name}" for name in NUMBERS)):
            answer = web.get(path)
            assert answer.status == 200, answer
            json.loads(answer.body, parse_constant=lambda name: pytest.fail(f"{name} is not JSON"))
    told = [
        record for record in caplog.records if record.exc_info and record.name.startswith("woosh_pure.web")
    ]
    assert told == []


def test_a_large_costmap_keeps_no_drive_away(web: Served, sim: SimulatedChassis) -> None:
    """5000 x 5000 cells over 1 Mbit/s: 25 MB in one frame took 200 s, in which nothing else came. It is scaled, comes
    in parts, and poses and a drive pass between them.
    """
    with (
        Node("costs", master_uri=sim.master_uri, anonymous=True) as node,
        SlowLink("127.0.0.1", web.port, latency=0.0, rate=125_000) as link,
        PageClient(link.port) as page,
    ):
        message = grid_message(GridMap(np.full((5000, 5000), 1, np.int8), 0.05, Pose2D(0.0, 0.0)))
        publisher = node.publisher(COSTMAP_ROW.name, "nav_msgs/OccupancyGrid", latch=True)
        page.of("pose")
        page.ready()
        page.say(t="look", costmap=True)
        publisher.publish(message)
        page.frame(COSTMAP, timeout=30.0)
        frames_so_far = list(page.frames)
        page.forget()
        said = page.drive()
        assert said["state"] == "driving"
        page.of("pose")
        page.let_go()
        parts = [frame for frame in [*frames_so_far, *page.frames] if frame[0] == COSTMAP]
        assert max(map(len, parts)) <= PART + 24
