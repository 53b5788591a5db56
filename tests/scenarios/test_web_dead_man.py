"""The dead man over real sockets: whatever becomes of the hand, zero velocity is sent within half a second.

The time is taken at a node that hears the velocity topic, from the moment the hand fails to the zero after which
nothing else comes. DEAD_MAN_TRIALS=125 in the environment repeats each way so often and prints the longest times
(`-s` shows them): eight ways make 1,000 trials.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack

import pytest

pytest.importorskip("fastapi", reason="needs the extra `web`")
pytest.importorskip("uvicorn", reason="needs the extra `web`")
pytest.importorskip("websockets", reason="needs the extra `web`")

from tests.support.proxy import FaultProxy
from tests.support.web import Hand, Served, Velocities, serving
from tests.support.woosh_command import woosh_process
from woosh_pure import Chassis, SimulatedChassis

TRIALS = int(os.environ.get("DEAD_MAN_TRIALS", "2"))
PROMISED = 0.5
POSIX = pytest.mark.skipif(os.name != "posix", reason="needs SIGSTOP and SIGTERM")


@pytest.fixture
def web(chassis: Chassis, real_time: Callable[[], None]) -> Iterator[Served]:
    """A server that allows driving, and a robot in real time."""
    with serving(chassis, allow_driving=True) as served:
        yield served


@pytest.fixture
def witness(sim: SimulatedChassis) -> Iterator[Velocities]:
    """Hears what is sent to the robot."""
    with Velocities(sim.master_uri) as heard:
        yield heard


def judge(way: str, times: list[float]) -> None:
    print(f"\ndead man, {way}: {len(times)} trials, longest {max(times) * 1000:.0f} ms")
    assert max(times) < PROMISED, f"{way}: {sorted(times)[-3:]} s until zero"


def driving(page: Hand, witness: Velocities) -> None:
    """Hold, until the robot is told to move; on a busy computer a press may be refused as any late one is."""
    said = {}
    for _ in range(10):
        since = time.monotonic()
        page.forget()
        page.hold(0.2)
        said = page.wait(lambda d: d["t"] == "drive" and d["state"] != "opening")
        if said["state"] == "driving" and witness.moves(since):
            return
        page.let_go()
    raise AssertionError(f"never driving: {said}")


def let_go(page: Hand, proxy: FaultProxy) -> None:
    page.let_go()


def freeze(page: Hand, proxy: FaultProxy) -> None:
    page.stop_beating()


def close(page: Hand, proxy: FaultProxy) -> None:
    page.socket.close()


def reset(page: Hand, proxy: FaultProxy) -> None:
    proxy.reset()


def cut(page: Hand, proxy: FaultProxy) -> None:
    proxy.stall()


WAYS = {
    "the finger is up": let_go,
    "the page is frozen": freeze,
    "the tab is closed": close,
    "the socket is reset": reset,
    "the network is cut": cut,
}


@pytest.mark.slow
@pytest.mark.parametrize("way", WAYS)
def test_zero_follows_within_half_a_second(web: Served, witness: Velocities, way: str) -> None:
    times = []
    for _ in range(TRIALS):
        with FaultProxy("127.0.0.1", web.port) as proxy, Hand(proxy.port) as page:
            web.app.state.house.robot(None).chassis.lease.release(_holder(web))  # type: ignore[attr-defined]
            page.of("hello")
            page.ready()
            driving(page, witness)
            began = time.monotonic()
            WAYS[way](page, proxy)
            times.append(witness.seconds_to_zero(began))
            said = [(round(at - began, 3), vx) for at, vx, _ in witness.heard[-12:]]
            assert times[-1] < PROMISED, f"{way}: {times[-1]:.3f} s until zero; heard: {said}"
            page.stop_beating()
            proxy.resume()
        _free(web)
    judge(way, times)


def _holder(web: Served) -> str:
    return web.app.state.house.robot(None).chassis.lease.holder or ""  # type: ignore[attr-defined]


def _free(web: Served) -> None:
    """Wait until nobody sits in the driver's seat."""
    seat, until = web.app.state.house.robot(None).seat, time.monotonic() + 10.0  # type: ignore[attr-defined]
    while seat.driver is not None and time.monotonic() < until:
        time.sleep(0.02)
    assert seat.driver is None


@pytest.mark.slow
def test_after_a_cut_nothing_resumes_when_the_network_is_back(web: Served, witness: Velocities) -> None:
    """What waited in the network is delivered in one heap: old wishes, and nothing moves."""
    with FaultProxy("127.0.0.1", web.port) as proxy, Hand(proxy.port) as page:
        page.of("hello")
        page.ready()
        driving(page, witness)
        proxy.stall()
        began = time.monotonic()
        assert witness.seconds_to_zero(began, 1.2) < PROMISED
        back = time.monotonic()
        proxy.resume()  # the hand has beaten all the time, and goes on
        time.sleep(1.0)
        page.stop_beating()
        assert [h for h in witness.heard if h[0] > back and (h[1] or h[2])] == []


@pytest.mark.slow
def test_beats_that_a_slow_network_delivers_late_do_not_drive(web: Served, witness: Velocities) -> None:
    """The delay begins while it is held: from the first late beat on there is no sign of life."""
    with FaultProxy("127.0.0.1", web.port) as proxy, Hand(proxy.port) as page:
        page.of("hello")
        page.ready()
        driving(page, witness)
        began = time.monotonic()
        proxy.delay(0.6)
        assert witness.seconds_to_zero(began, 2.0) < PROMISED
        page.stop_beating()


@pytest.mark.slow
def test_a_stop_that_another_person_gives_ends_the_drive_in_zero(web: Served, witness: Velocities) -> None:
    times = []
    for _ in range(TRIALS):
        with Hand(web.port) as page:
            web.app.state.house.robot(None).chassis.lease.release(_holder(web))  # type: ignore[attr-defined]
            page.of("hello")
            page.ready()
            driving(page, witness)
            began = time.monotonic()
            web.post("stop")
            times.append(witness.seconds_to_zero(began))
            page.stop_beating()
        _free(web)
    judge("somebody else stops", times)


@POSIX
@pytest.mark.slow
@pytest.mark.parametrize("name", ["SIGSTOP", "SIGKILL"])
def test_a_page_whose_process_is_stopped_or_killed(web: Served, witness: Velocities, name: str) -> None:
    times = []
    for _ in range(TRIALS):
        web.app.state.house.robot(None).chassis.lease.release(_holder(web))  # type: ignore[attr-defined]
        since = time.monotonic()
        process = subprocess.Popen(
            [sys.executable, "-m", "tests.support.web_hand", str(web.port)], stdout=subprocess.PIPE, text=True
        )
        try:
            assert process.stdout is not None
            assert process.stdout.readline() == "driving\n"
            witness.wait_moving(since)
            began = time.monotonic()
            process.send_signal(getattr(signal, name))
            times.append(witness.seconds_to_zero(began))
        finally:
            process.kill()
            process.communicate(timeout=10)
        _free(web)
    judge(f"{name} of the page", times)


@POSIX
@pytest.mark.slow
def test_a_server_that_is_ended_by_sigterm(
    sim: SimulatedChassis, witness: Velocities, real_time: Callable[[], None]
) -> None:
    times = []
    for _ in range(TRIALS):
        with ExitStack() as stack:
            process = woosh_process(
                "--master", sim.master_uri, "--json", "web", "--port", "0", "--no-browser", "--allow-driving"
            )
            stack.callback(process.communicate, timeout=20)
            stack.callback(process.kill)
            assert process.stdout is not None
            port = json.loads(process.stdout.readline())["port"]
            page = stack.enter_context(Hand(port))
            page.of("hello")
            page.ready()
            driving(page, witness)
            began = time.monotonic()
            process.send_signal(signal.SIGTERM)
            times.append(witness.seconds_to_zero(began))
            page.stop_beating()
            process.wait(20)
            assert process.returncode == 143
    judge("SIGTERM of the server", times)
