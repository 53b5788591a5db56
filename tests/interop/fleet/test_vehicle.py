"""A simulated chassis as a vehicle, through Debian's mosquitto: what becomes of broker, robot and process."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import threading
import time
import zipfile
from collections.abc import Iterator
from contextlib import ExitStack
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import pytest

from tests.support.fleet_master import Master, errors, order_over, statuses
from tests.support.fleet_peers import vehicle
from tests.support.load import crowd
from tests.support.mosquitto import Mosquitto, mosquitto
from woosh_pure import Chassis, SimulatedChassis
from woosh_pure.enums import RobotMode
from woosh_pure.fleet import Broker, Store, Vehicle, VehicleConfig
from woosh_pure.maps import GridMap

pytestmark = [pytest.mark.interop, pytest.mark.slow]
pytest.importorskip("paho.mqtt.client", reason="paho-mqtt is not installed")
CONFIG = VehicleConfig(
    manufacturer="Woosh", serial="A-17", map_id="hall", marks=True, charger="C1", undock=-0.5,
    map_actions=True, triggers={"button": ""},
)  # fmt: skip


class Hall:
    """A broker, a simulated chassis, our vehicle on it, and a master."""

    def __init__(self, broker: Mosquitto, sim: SimulatedChassis, vehicle: Vehicle, master: Master) -> None:
        self.broker, self.sim, self.vehicle, self.master = broker, sim, vehicle, master

    def order(self, *args: Any, **options: Any) -> None:
        self.master.send("order", order_over(*args, **options))


def outlined(chassis: Chassis) -> Chassis:
    """With the outline that costmap_2d has as its parameter."""
    chassis.node.params["/move_base/local_costmap/footprint"] = (
        "[[0.4,0.3],[-0.4,0.3],[-0.4,-0.3],[0.4,-0.3]]"
    )
    return chassis


@pytest.fixture
def hall(tmp_path: Path) -> Iterator[Hall]:
    with (
        mosquitto(tmp_path) as broker,
        SimulatedChassis(speed=3) as sim,
        Chassis(sim.master_uri) as chassis,
        Master(broker.port) as master,
        Vehicle(outlined(chassis), CONFIG, Broker(broker.url), Store(tmp_path, "Woosh", "A-17")) as ours,
    ):
        master.until(lambda s: s["agvPosition"]["positionInitialized"] and s["operatingMode"] == "AUTOMATIC")
        yield Hall(broker, sim, ours, master)


def moved(hall: Hall) -> None:
    hall.master.until(lambda s: s["driving"])


def test_it_comes_online_and_leaves_in_order(hall: Hall) -> None:
    """ONLINE and OFFLINE are retained; header ids go up by one; the factsheet has the robot's outline."""
    hall.master.until(lambda c: c["connectionState"] == "ONLINE", topic="connection")
    # The first factsheet may come before the navigation has told both; another follows then.
    hall.master.until(
        lambda f: (
            f["physicalParameters"]["speedMax"] > 0.0
            and f["physicalParameters"]["length"] == pytest.approx(0.8)
        ),
        topic="factsheet",
    )
    hall.vehicle.close()
    hall.master.until(lambda c: c["connectionState"] == "OFFLINE", topic="connection")
    ids = [state["headerId"] for state in hall.master.all()]
    assert ids == list(range(ids[0], ids[0] + len(ids)))
    with Master(hall.broker.port) as late:
        assert late.until(lambda c: True, topic="connection")["connectionState"] == "OFFLINE"
        sheet = late.until(lambda c: True, topic="factsheet")
        assert sheet["physicalParameters"]["speedMax"] > 0.0
        assert sheet["physicalParameters"]["length"] == pytest.approx(0.8), (
            "as the navigation's parameter has it"
        )


def test_a_broker_that_dies_leaves_the_robot_to_its_base(hall: Hall) -> None:
    """It goes to the end of the base and stands there; the state is true when the broker is back."""
    hall.order("one", "n1 n2 n3 n1", released=3)
    moved(hall)
    hall.broker.kill()
    deadline = time.monotonic() + 20.0
    while (hall.vehicle._order.state.last_node, hall.vehicle._order.state.driving) != ("n3", False):
        assert time.monotonic() < deadline
        time.sleep(0.05)
    hall.broker.start()
    began = time.monotonic()
    hall.master.until(lambda c: c["connectionState"] == "ONLINE", 40.0, topic="connection", after=began)
    hall.master.instant("now", "stateRequest")  # the vehicle may be there before its manager
    found = hall.master.until(lambda s: s["lastNodeId"] == "n3", 40.0, after=began)
    assert [node["nodeId"] for node in found["nodeStates"]] == ["n1"]
    assert found["newBaseRequest"]
    online = next(at for at, topic, _, _ in hall.master.heard if topic == "connection" and at > began)
    state = next(at for at, topic, _, _ in hall.master.heard if topic == "state" and at > began)
    assert state - online < 2.0 * crowd()


def test_a_robot_that_is_lost_is_told_within_two_seconds(hall: Hall) -> None:
    """As FATAL; and it is over when the robot is heard again."""
    hall.sim.fall_silent(4.0)
    began = time.monotonic()
    found = hall.master.until(lambda s: "robotLost" in errors(s), 10.0)
    assert time.monotonic() - began < 2.0 * crowd()
    assert not found["agvPosition"]["positionInitialized"] or found["errors"][0]["errorLevel"] == "FATAL"
    hall.master.until(lambda s: "robotLost" not in errors(s), 20.0)


@pytest.mark.promise("Retained orders and instant actions are not obeyed")
def test_a_retained_order_is_not_obeyed(tmp_path: Path) -> None:
    """An order of yesterday would move the robot whenever it connects."""
    with (
        mosquitto(tmp_path) as broker,
        SimulatedChassis(speed=3) as sim,
        Chassis(sim.master_uri) as chassis,
        Master(broker.port) as master,
    ):
        master.send("order", order_over("old", "n1 n2"), retain=True)
        master.instant("sync", "stateRequest")
        with Vehicle(chassis, CONFIG, Broker(broker.url)):
            master.until(lambda s: s["operatingMode"] == "AUTOMATIC")
            master.instant("now", "stateRequest")
            assert master.until(lambda s: "now" in statuses(s))["orderId"] == ""


@pytest.mark.parametrize("topic", ["order", "instantActions"])
def test_clearing_a_retained_message_is_no_error(hall: Hall, topic: str) -> None:
    """The broker passes an empty message on to all who listen, as it came."""
    hall.master.send(topic, b"", retain=True)
    hall.master.instant("after", "stateRequest")
    assert hall.master.until(lambda s: "after" in statuses(s))["errors"] == []


@pytest.mark.promise("is answered with `validationError` and changes nothing")
@pytest.mark.parametrize("topic", ["order", "instantActions"])
def test_what_does_not_fit_is_answered(hall: Hall, topic: str) -> None:
    """By a validationError each; the vehicle lives on, and an order ends the warning."""
    for payload in (b" ", b"\xff\xfe", b"[]", b'{"headerId": 5}', b"{" * 10_000):
        hall.master.send(topic, payload)
    found = hall.master.until(lambda s: errors(s).count("validationError") >= 2)
    assert {"referenceKey": "topic", "referenceValue": topic} in found["errors"][-1]["errorReferences"]
    hall.order("one", "n1 n2")
    assert hall.master.until(lambda s: s["lastNodeId"] == "n2")["errors"] == []


def test_the_path_that_the_chassis_plans_is_told(hall: Hall) -> None:
    """6.10.1: as soon as the drive has it, from where the robot is to the node."""
    hall.order("one", "n1 n2 n3")
    for edge, end in (("n1n2", (1.0, -0.5)), ("n2n3", (3.0, 1.0))):
        driven = hall.master.until(lambda s: "trajectory" in (s["edgeStates"] or [{}])[0])["edgeStates"][0]
        assert driven["edgeId"] == edge
        way, knots = driven["trajectory"]["controlPoints"], driven["trajectory"]["knotVector"]
        assert (way[-1]["x"], way[-1]["y"]) == pytest.approx(end, abs=0.3)
        assert len(knots) == len(way) + 2
        assert knots == sorted(knots)
        assert (knots[0], knots[-1]) == (0.0, 1.0)
        hall.master.until(lambda s, e=edge: all(each["edgeId"] != e for each in s["edgeStates"]))


def test_speed_of_an_edge_is_told_to_the_chassis(hall: Hall) -> None:
    """And taken back with an edge that has none."""
    hall.order("slow", "n1 n2", edge={"maxSpeed": 0.4})
    moved(hall)
    with hall.sim.lock:
        assert hall.sim.world.navigation.max_speed == pytest.approx(0.4)
    hall.master.until(lambda s: s["lastNodeId"] == "n2" and not s["nodeStates"])
    hall.order("fast", "n2 n3")
    hall.master.until(lambda s: s["orderId"] == "fast" and s["driving"])
    with hall.sim.lock:
        assert hall.sim.world.navigation.max_speed == 0.0


def test_an_emergency_stop_is_told_and_the_order_goes_on_after_it(hall: Hall) -> None:
    """eStop MANUAL; the drive fails, and is tried again when the chassis is free."""
    hall.order("one", "n1 n2 n3")
    moved(hall)
    hall.sim.press_emergency_stop()
    hall.master.until(lambda s: s["safetyState"]["eStop"] == "MANUAL")
    hall.sim.release_emergency_stop()
    hall.master.until(lambda s: s["safetyState"]["eStop"] == "NONE")
    hall.master.until(lambda s: s["lastNodeId"] == "n3" and not s["nodeStates"], 40.0)


def test_manual_mode_clears_the_order(hall: Hall) -> None:
    """6.10.6; and orders are rejected in it."""
    hall.order("one", "n1 n2 n3")
    moved(hall)
    hall.sim.set_mode(RobotMode.MANUAL)
    hall.master.until(lambda s: s["operatingMode"] == "MANUAL" and not s["nodeStates"] and not s["driving"])
    hall.order("two", "n1 n2")
    hall.master.until(lambda s: errors(s).count("orderError") >= 2)
    hall.sim.set_mode(RobotMode.AUTOMATIC)
    assert hall.master.until(lambda s: s["operatingMode"] == "AUTOMATIC")["orderId"] == "one"


def test_a_local_driver_who_asks_gets_the_robot(hall: Hall) -> None:
    """One owner at a time: the fleet has the lease while it drives, then the mode is MANUAL and the order is cleared."""
    lease = hall.vehicle.chassis.lease
    hall.order("one", "n1 n2 n3")
    moved(hall)
    deadline = time.monotonic() + 5.0
    while lease.holder is None and time.monotonic() < deadline:
        time.sleep(0.02)
    assert lease.holder == "fleet manager of A-17"
    assert not lease.acquire("viewer 1")
    assert lease.request("viewer 1")
    hall.master.until(lambda s: s["operatingMode"] == "MANUAL" and not s["nodeStates"])
    assert lease.holder == "viewer 1"
    hall.order("two", "n1 n2")
    hall.master.until(lambda s: errors(s).count("orderError") >= 2)
    lease.release("viewer 1")
    hall.master.until(lambda s: s["operatingMode"] == "AUTOMATIC")


def test_marks_are_driven_to_and_charging_begins(hall: Hall) -> None:
    """A node without a position is a mark, and startCharging goes to the charger."""
    order = order_over("one", "n1 n2")
    del order["nodes"][1]["nodePosition"]
    order["nodes"][1]["nodeId"] = order["edges"][0]["endNodeId"] = "A1"
    hall.master.send("order", order)
    found = hall.master.until(lambda s: s["lastNodeId"] == "A1" and not s["nodeStates"], 40.0)
    assert found["agvPosition"]["x"] == pytest.approx(3.0, abs=0.1)
    hall.master.instant("charge", "startCharging")
    found = hall.master.until(lambda s: statuses(s).get("charge") == "FINISHED", 60.0)
    assert found["batteryState"]["charging"]
    hall.master.instant("off", "stopCharging")
    found = hall.master.until(lambda s: statuses(s).get("off") in ("FINISHED", "FAILED"), 30.0)
    assert (statuses(found)["off"], found["batteryState"]["charging"]) == ("FINISHED", False)


def test_maps_are_downloaded_enabled_and_deleted(hall: Hall, tmp_path: Path) -> None:
    """6.7, with a map server; the chassis gets the map at once, and a mark of a report and a trigger on the way."""
    (tmp_path / "served").mkdir()
    with hall.sim.lock:
        before = hall.sim.world.map_seen
    wall = before.cells.copy()
    wall[0:12, :] = 100
    GridMap(wall, before.resolution, before.origin).save(tmp_path / "new.yaml")
    with zipfile.ZipFile(tmp_path / "served" / "hall.zip", "w") as file:
        for name in ("new.yaml", "new.pgm"):
            file.write(tmp_path / name, name)
    handler = partial(SimpleHTTPRequestHandler, directory=str(tmp_path / "served"))
    with ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, args=(0.05,), daemon=True).start()
        link = f"http://127.0.0.1:{server.server_address[1]}/hall.zip"
        given = {"mapId": "hall", "mapVersion": "2"}

        def done(name: str, kind: str, **parameters: Any) -> tuple[str, list[tuple[str, str, str]]]:
            hall.master.instant(name, kind, **parameters)
            found = hall.master.until(lambda s: statuses(s).get(name) in ("FINISHED", "FAILED"))
            maps = [(each["mapId"], each["mapVersion"], each["mapStatus"]) for each in found["maps"]]
            return statuses(found)[name], maps

        own = ("hall", "1", "ENABLED")
        assert done("e0", "enableMap", **given) == ("FAILED", [own])
        assert done("d1", "downloadMap", mapDownloadLink=link, **given) == (
            "FINISHED", [own, ("hall", "2", "DISABLED")]
        )  # fmt: skip
        assert done("d2", "downloadMap", mapDownloadLink=link, **given)[0] == "FAILED"
        server.shutdown()
    new = [("hall", "1", "DISABLED"), ("hall", "2", "ENABLED")]
    assert done("e1", "enableMap", **given) == ("FINISHED", new)
    with hall.sim.lock:
        assert (hall.sim.world.map_seen.cells == wall).all()
        assert hall.sim.world.located
    assert done("x1", "deleteMap", **given) == ("FAILED", new)
    assert done("i1", "initPosition", x=0.0, y=0.0, theta=0.0, mapId="cellar", lastNodeId="")[0] == "FAILED"
    assert done("r1", "logReport", reason="why not")[0] == "FINISHED"
    report = hall.master.all()[-1]["information"][0]
    assert report["infoType"] == "logReport"
    assert (tmp_path / "logs" / report["infoDescription"]).exists()
    wait = {
        "actionId": "w", "actionType": "waitForTrigger", "blockingType": "HARD",
        "actionParameters": [{"key": "triggerType", "value": "button"}],
    }  # fmt: skip
    hall.order("one", "n1 n2", actions={"n1": [wait]})
    hall.master.until(lambda s: statuses(s).get("w") == "RUNNING" and s["lastNodeId"] == "n1")
    deadline = time.monotonic() + 10.0  # RUNNING is told before the function runs
    while not hall.vehicle.trigger("button"):
        assert time.monotonic() < deadline
        time.sleep(0.02)
    hall.master.until(lambda s: statuses(s).get("w") == "FINISHED" and s["lastNodeId"] == "n2")


def test_a_robot_that_does_not_know_where_it_is_takes_no_order(hall: Hall) -> None:
    """noRouteError until initPosition: then pose and last node are those of its parameters."""
    hall.sim.lose_localization()
    hall.master.until(lambda s: not s["agvPosition"]["positionInitialized"])
    hall.order("one", "n1 n2")
    hall.master.until(lambda s: errors(s).count("noRouteError") == 1)
    hall.master.instant("init", "initPosition", x=0.0, y=0.0, theta=0.05, mapId="hall", lastNodeId="n1")
    found = hall.master.until(lambda s: statuses(s).get("init") in ("FINISHED", "FAILED"))
    assert statuses(found)["init"] == "FINISHED"
    assert found["lastNodeId"] == "n1"
    hall.master.until(lambda s: s["agvPosition"]["positionInitialized"])
    hall.order("one", "n1 n2")
    hall.master.until(lambda s: s["lastNodeId"] == "n2")


def test_a_process_that_is_killed_loses_nothing(tmp_path: Path) -> None:
    """kill -9 on the way: the broker says CONNECTIONBROKEN, the next process has the order, waits for stopPause and
    finishes it; no action runs twice. SIGTERM on the way ends the order, and the process after it moves nothing."""
    counted = tmp_path / "beeps"
    script = tmp_path / "beep.py"
    script.write_text(f"open({str(counted)!r}, 'a').write('x')\n")
    beep = {"actionId": "b1", "actionType": "beep", "blockingType": "HARD", "actionParameters": []}
    with (
        mosquitto(tmp_path) as broker,
        SimulatedChassis(speed=2) as sim,
        Master(broker.port) as master,
    ):
        config = tmp_path / "fleet.toml"
        config.write_text(
            f'[broker]\nurl = "{broker.url}"\n[[vehicle]]\nmanufacturer = "Woosh"\nserial = "A-17"\n'
            f'map_id = "hall"\nchassis = "{sim.master_uri}"\n'
            f"actions = {{ beep = {json.dumps(f'!{sys.executable} {script}')} }}\n"
        )
        with vehicle_of(config, tmp_path) as first:
            master.until(
                lambda s: s["operatingMode"] == "AUTOMATIC" and s["agvPosition"]["positionInitialized"]
            )
            master.send("order", order_over("one", "n1 n2 n3", actions={"n1": [beep]}))
            master.until(lambda s: s["driving"])
            first.kill()
        master.until(lambda c: c["connectionState"] == "CONNECTIONBROKEN", topic="connection")
        began = time.monotonic()
        with vehicle_of(config, tmp_path):
            found = master.until(lambda s: s["orderId"] == "one", after=began)
            assert statuses(found)["b1"] == "FINISHED"
            assert (found["paused"], "orderHeld" in errors(found)) == (True, True)
            master.until(
                lambda s: s["operatingMode"] == "AUTOMATIC" and located(s) and not s["driving"], after=began
            )
            master.instant("go", "stopPause")
            found = master.until(lambda s: s["lastNodeId"] == "n3" and not s["nodeStates"], 40.0)
            assert (found["paused"], errors(found)) == (False, [])
            master.send("order", order_over("two", "n3 n2 n1"))
            master.until(lambda s: s["orderId"] == "two" and s["driving"])
            began = time.monotonic()
        master.until(lambda c: c["connectionState"] == "OFFLINE", topic="connection")
        ended = master.all()[-1]
        assert (ended["orderId"], ended["nodeStates"], errors(ended)) == ("two", [], ["orderError"])
        began = time.monotonic()
        with vehicle_of(config, tmp_path):
            master.until(lambda s: s["operatingMode"] == "AUTOMATIC" and located(s), after=began)
            master.instant("now", "stateRequest")
            found = master.until(lambda s: statuses(s).get("now") == "FINISHED", after=began)
            assert (found["orderId"], found["nodeStates"], found["paused"]) == ("two", [], False)
            assert not any(
                s["driving"] for at, topic, s, _ in master.heard if topic == "state" and at > began
            )
    assert counted.read_text() == "x"


def vehicle_of(config: Path, folder: Path) -> Any:
    return vehicle("", folder, config=config)


def test_a_robot_that_was_switched_off_finishes_its_order_when_it_is_back(tmp_path: Path) -> None:
    """Told as lost, then found again; no node is skipped."""
    with mosquitto(tmp_path) as broker, Master(broker.port) as master:
        first = SimulatedChassis(speed=2)
        first.start()
        port = int(first.master_uri.rstrip("/").rpartition(":")[2])
        with Chassis(first.master_uri) as chassis, Vehicle(chassis, CONFIG, Broker(broker.url)):
            master.until(
                lambda s: s["operatingMode"] == "AUTOMATIC" and s["agvPosition"]["positionInitialized"]
            )
            master.send("order", order_over("one", "n1 n2 n3"))
            master.until(lambda s: s["driving"])
            began = time.monotonic()
            first.close()
            master.until(lambda s: "robotLost" in errors(s), 10.0)
            assert time.monotonic() - began < 4.0 * crowd()
            with SimulatedChassis(speed=2, port=port):
                found = master.until(lambda s: s["lastNodeId"] == "n3" and not s["nodeStates"], 90.0)
                assert "robotLost" not in errors(found)
        last = [state["lastNodeId"] for state in master.all()]
        assert list(dict.fromkeys(last)) == ["", "n1", "n2", "n3"]


SIMULATORS = """
import sys
from contextlib import ExitStack
from woosh_pure import SimulatedChassis
with ExitStack() as stack:
    for _ in range(8):
        print(stack.enter_context(SimulatedChassis(speed=1.0)).master_uri, flush=True)
    sys.stdin.read()
"""
"""In a process of their own: paho waits by select, which takes no more than 1024 open files."""


def test_eight_robots_finish_eight_orders(tmp_path: Path) -> None:
    """At the same time, each its own, from one process of ours."""
    command = [sys.executable, "-c", SIMULATORS]
    with (
        mosquitto(tmp_path) as broker,
        subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as robots,
        ExitStack() as stack,
    ):
        assert robots.stdin is not None
        assert robots.stdout is not None
        stack.callback(robots.stdin.close)
        masters = []
        for n in range(8):
            chassis = stack.enter_context(Chassis(robots.stdout.readline().strip()))
            config = VehicleConfig(manufacturer="Woosh", serial=f"R{n}", map_id="hall")
            masters.append(stack.enter_context(Master(broker.port, config.prefix)))
            stack.enter_context(Vehicle(chassis, config, Broker(broker.url)))
        for master in masters:
            master.until(lambda s: s["operatingMode"] == "AUTOMATIC" and located(s), 30.0)
        for n, master in enumerate(masters):
            master.send("order", order_over(f"o{n}", "n1 n2 n3", released=2))
        for n, master in enumerate(masters):
            master.send("order", order_over(f"o{n}", "n2 n3", first=2, update=1))
        for n, master in enumerate(masters):
            found = master.until(lambda s: s["lastNodeId"] == "n3" and not s["nodeStates"], 90.0)
            assert (found["orderId"], found["orderUpdateId"]) == (f"o{n}", 1)


def located(state: dict[str, Any]) -> bool:
    return bool(state.get("agvPosition", {}).get("positionInitialized"))


def test_a_broker_with_tls_and_a_password(tmp_path: Path) -> None:
    """Client certificate, checked broker certificate, user and password; without them the broker refuses."""
    run = lambda *words: subprocess.run(words, cwd=tmp_path, check=True, capture_output=True, timeout=30)  # noqa: E731
    if not (shutil.which("openssl") and shutil.which("mosquitto_passwd")):
        pytest.skip("openssl or mosquitto_passwd is not installed")
    run("openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-keyout", "ca.key", "-out", "ca.pem", "-subj", "/CN=ca", "-days", "2")  # fmt: skip
    (tmp_path / "names").write_text("subjectAltName=IP:127.0.0.1\n")
    for name in ("broker", "ours"):
        run("openssl", "req", "-newkey", "rsa:2048", "-nodes", "-keyout", f"{name}.key", "-out", f"{name}.csr", "-subj", f"/CN={name}")  # fmt: skip
        run("openssl", "x509", "-req", "-in", f"{name}.csr", "-CA", "ca.pem", "-CAkey", "ca.key", "-CAcreateserial", "-out", f"{name}.pem", "-days", "2", "-extfile", "names")  # fmt: skip
    run("mosquitto_passwd", "-b", "-c", "users", "me", "hush")
    for path in tmp_path.iterdir():
        path.chmod(0o644)
    options = "\n".join(
        f"{key} {tmp_path / name}"
        for key, name in (
            ("cafile", "ca.pem"),
            ("certfile", "broker.pem"),
            ("keyfile", "broker.key"),
            ("password_file", "users"),
        )
    )
    tmp_path.chmod(0o755)
    with mosquitto(tmp_path, f"{options}\nrequire_certificate true\nallow_anonymous false") as broker:
        url = broker.url.replace("mqtt://", "mqtts://")
        files = [str(tmp_path / name) for name in ("ca.pem", "ours.pem", "ours.key")]
        for given, comes_in in (
            (("me", "hush", *files), True),
            (("me", "no", *files), False),
            ((None, None, files[0]), False),
        ):
            vehicle = Vehicle(Chassis("127.0.0.1:1"), CONFIG, Broker(url, *given))
            vehicle._connection.open()
            try:
                assert vehicle.wait_connected(10.0 if comes_in else 1.5) is comes_in
            finally:
                vehicle.close()
