"""The dead man over real sockets: whatever becomes of the hand, zero velocity is sent within half a second.

The time is taken at a node that hears the velocity topic, from the moment the hand fails to the zero after which
nothing else comes; the time in which others had the processor is taken off. DEAD_MAN_TRIALS=125 in the environment repeats each way so often and prints the longest times
(`-s` shows them): nine ways make 1,125 trials.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass, field

import pytest

from tests.support.waiting import until

pytest.importorskip("fastapi", reason="needs the extra `web`")
pytest.importorskip("uvicorn", reason="needs the extra `web`")
pytest.importorskip("websockets", reason="needs the extra `web`")

from tests.support.load import waited_for_the_processor
from tests.support.proxy import FaultProxy
from tests.support.web import PageClient, Served, Velocities, serving
from tests.support.woosh_command import woosh_process
from woosh_pure import Chassis, SimulatedChassis

TRIALS = int(os.environ.get("DEAD_MAN_TRIALS", "2"))
PROMISED = 0.5
STALL = 0.02
"""Seconds at a stretch without the processor, and more, are the computer's."""
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


def speed(number: int) -> float:
    """m/s, of one trial."""
    return -0.2 if number % 2 else 0.2


class Meter:
    """How long a thread of this process stood ready at a stretch while others had the processor: what an overloaded
    computer adds. Short waits are not counted, and not one for another thread of ours: that is ours.

    0.0 where the system does not tell (it does on Linux). A wait for another thread of ours is not counted: that is ours.
    """

    def __init__(self) -> None:
        self._over = threading.Event()
        self._waited: list[tuple[float, float]] = []
        self._thread = threading.Thread(target=self._run, daemon=True)

    def __enter__(self) -> Meter:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._thread.join(5)

    def _run(self) -> None:
        before = waited_for_the_processor()
        while not self._over.wait(0.01):
            now = waited_for_the_processor()
            if now - before > STALL:
                self._waited.append((time.monotonic(), now - before))
            before = now

    def between(self, since: float, until: float) -> float:
        """Seconds of that."""
        return sum(waited for at, waited in list(self._waited) if since <= at <= until + 0.05)


@pytest.fixture(scope="module")
def meter() -> Iterator[Meter]:
    """Runs as long as the trials."""
    with Meter() as running:
        yield running


@dataclass
class Trials:
    """Times of one way to fail."""

    way: str
    witness: Velocities
    meter: Meter
    times: list[float] = field(default_factory=list)
    alone: list[float] = field(default_factory=list)

    def count(self, began: float, watch: float = 1.0) -> None:
        """One more, watched for `watch` s; fails when it took too long."""
        seconds = self.witness.seconds_to_zero(began, watch)
        alone = max(0.0, seconds - self.meter.between(began, began + seconds))
        said = [(round(at - began, 3), vx) for at, vx, _ in self.witness.heard if at > began - 0.5][-40:]
        text = f"{self.way}: {seconds:.3f} s until zero, {alone:.3f} s without others; heard: {said}"
        assert alone < PROMISED, text
        self.times.append(seconds)
        self.alone.append(alone)
        if len(self.times) % 25 == 0:
            self.tell()

    def tell(self) -> None:
        """The longest, for the log."""
        longest, alone = 1000 * max(self.times), 1000 * max(self.alone)
        over = sum(seconds >= PROMISED for seconds in self.times)
        print(
            f"\ndead man, {self.way}: {len(self.times)} trials, longest {longest:.0f} ms by the clock ({over} over "
            f"{1000 * PROMISED:.0f} ms), {alone:.0f} ms without stalls of the computer"
        )


def driving(page: PageClient, witness: Velocities, number: int = 0) -> None:
    """Hold, until the robot is told to move; forth and back in turn, or many trials end at a wall."""
    for _ in range(10):
        since = time.monotonic()
        page.drive(speed(number))
        if witness.moves(since):
            return
        page.let_go()
        time.sleep(0.2)
    raise AssertionError("driving, and never told to move")


def let_go(page: PageClient, proxy: FaultProxy) -> None:
    page.let_go()


def freeze(page: PageClient, proxy: FaultProxy) -> None:
    page.stop_beating()


def close(page: PageClient, proxy: FaultProxy) -> None:
    page.socket.close()


def reset(page: PageClient, proxy: FaultProxy) -> None:
    proxy.reset()


def cut(page: PageClient, proxy: FaultProxy) -> None:
    proxy.stall()


def reload(page: PageClient, proxy: FaultProxy) -> None:
    """The new page connects, and the old connection is still there: nothing of it has come to the server."""
    with PageClient(proxy.port, f"/api/v1/live?session={page.session}") as new:
        new.of("hello")


WAYS = {
    "the page is reloaded": reload,
    "the finger is up": let_go,
    "the page is frozen": freeze,
    "the tab is closed": close,
    "the socket is reset": reset,
    "the network is cut": cut,
}


@pytest.mark.promise("driving by hand from the page")
@pytest.mark.slow
@pytest.mark.parametrize("way", WAYS)
def test_zero_follows_within_half_a_second(web: Served, witness: Velocities, meter: Meter, way: str) -> None:
    trials = Trials(way, witness, meter)
    for number in range(TRIALS):
        with FaultProxy("127.0.0.1", web.port) as proxy, PageClient(proxy.port) as page:
            web.app.state.context.robot(None).chassis.lease.release(_holder(web))  # type: ignore[attr-defined]
            page.of("hello")
            page.ready()
            driving(page, witness, number)
            began = time.monotonic()
            WAYS[way](page, proxy)
            trials.count(began)
            page.stop_beating()
            proxy.resume()
        _free(web)
    trials.tell()


def _holder(web: Served) -> str:
    return web.app.state.context.robot(None).chassis.lease.holder or ""  # type: ignore[attr-defined]


def _free(web: Served) -> None:
    """Wait until nobody sits in the driver's seat."""
    teleop = web.app.state.context.robot(None).manual_drive  # type: ignore[attr-defined]
    until(lambda: teleop.driver is None, what="the free seat")


@pytest.mark.promise("driving by hand from the page")
@pytest.mark.slow
def test_after_a_cut_nothing_resumes_when_the_network_is_back(
    web: Served, witness: Velocities, meter: Meter
) -> None:
    """What waited in the network is delivered in one heap: old wishes, and nothing moves."""
    with FaultProxy("127.0.0.1", web.port) as proxy, PageClient(proxy.port) as page:
        page.of("hello")
        page.ready()
        driving(page, witness)
        proxy.stall()
        began = time.monotonic()
        Trials("the network is cut", witness, meter).count(began, 1.2)
        back = time.monotonic()
        proxy.resume()  # the hand has beaten all the time, and goes on
        time.sleep(1.0)
        page.stop_beating()
        assert [h for h in witness.heard if h[0] > back and (h[1] or h[2])] == []


@pytest.mark.promise("driving by hand from the page")
@pytest.mark.slow
def test_beats_that_a_slow_network_delivers_late_do_not_drive(
    web: Served, witness: Velocities, meter: Meter
) -> None:
    """The delay begins while it is held: from the first late beat on there is no sign of life."""
    with FaultProxy("127.0.0.1", web.port) as proxy, PageClient(proxy.port) as page:
        page.of("hello")
        page.ready()
        driving(page, witness)
        began = time.monotonic()
        proxy.delay(0.6)
        Trials("late beats", witness, meter).count(began, 2.0)
        page.stop_beating()


@pytest.mark.promise("STOP in the page")
@pytest.mark.slow
def test_a_stop_that_another_person_gives_ends_the_drive_in_zero(
    web: Served, witness: Velocities, meter: Meter
) -> None:
    trials = Trials("somebody else stops", witness, meter)
    for number in range(TRIALS):
        with PageClient(web.port) as page:
            web.app.state.context.robot(None).chassis.lease.release(_holder(web))  # type: ignore[attr-defined]
            page.of("hello")
            page.ready()
            driving(page, witness, number)
            began = time.monotonic()
            web.post("stop")
            trials.count(began)
            page.stop_beating()
        _free(web)
    trials.tell()


@pytest.mark.promise("driving by hand from the page")
@POSIX
@pytest.mark.slow
@pytest.mark.parametrize("name", ["SIGSTOP", "SIGKILL"])
def test_a_page_whose_process_is_stopped_or_killed(
    web: Served, witness: Velocities, meter: Meter, name: str
) -> None:
    trials = Trials(f"{name} of the page", witness, meter)
    for number in range(TRIALS):
        web.app.state.context.robot(None).chassis.lease.release(_holder(web))  # type: ignore[attr-defined]
        process = subprocess.Popen(
            [sys.executable, "-m", "tests.support.web_driving_page", str(web.port), str(speed(number))],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        try:
            _told_to_move(process, witness)
            began = time.monotonic()
            process.send_signal(getattr(signal, name))
            trials.count(began)
        finally:
            process.kill()
            process.communicate(timeout=10)
        _free(web)
    trials.tell()


def _told_to_move(process: subprocess.Popen[str], witness: Velocities) -> None:
    """As `driving`: on a busy computer a drive may end before the robot is told to move."""
    assert process.stdin is not None
    assert process.stdout is not None
    for line in ("begin", *["again"] * 9):
        since = time.monotonic()
        print(line, file=process.stdin, flush=True)
        assert process.stdout.readline() == "driving\n"
        if witness.moves(since):
            return
    raise AssertionError("driving, and never told to move")


@pytest.mark.promise("SIGTERM to `woosh web`")
@POSIX
@pytest.mark.slow
def test_a_server_that_is_ended_by_sigterm(
    sim: SimulatedChassis, witness: Velocities, meter: Meter, real_time: Callable[[], None]
) -> None:
    trials = Trials("SIGTERM of the server", witness, meter)
    for number in range(TRIALS):
        with ExitStack() as stack:
            process = woosh_process(
                "--master", sim.master_uri, "--json", "web", "--port", "0", "--no-browser", "--allow-driving"
            )
            stack.callback(process.communicate, timeout=20)
            stack.callback(process.kill)
            assert process.stdout is not None
            port = json.loads(process.stdout.readline())["port"]
            page = stack.enter_context(PageClient(port))
            page.of("hello")
            page.ready()
            driving(page, witness, number)
            began = time.monotonic()
            process.send_signal(signal.SIGTERM)
            trials.count(began)
            page.stop_beating()
            process.wait(20)
            assert process.returncode == 143
    trials.tell()
