"""Once something moves, no module, file, connection or thread is needed to drive on and to stop.

FILES_TRIALS=50 in the environment repeats the trials with strangers that take the files so often.
"""

from __future__ import annotations

import os
import socket
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, suppress

import pytest

from tests.support.driving_commands import moving
from tests.support.extras import needs
from tests.support.refused_means import RefusedMeans
from woosh_pure import SimulatedChassis

TRIALS = int(os.environ.get("FILES_TRIALS", "1"))
PROGRAM = """
import sys, threading
from woosh_pure import Chassis
chassis = Chassis(sys.argv[1])
what = sys.argv[2]
if what.startswith("velocity"):
    drive = chassis.velocity(
        bypasses_protection=True, feedback_timeout=None if "heartbeat" in what else 1.0
    ).__enter__()
    drive.set(0.1, valid_for=5.0)
else:
    handle = {"goal": lambda: chassis.go_to(2.5, 0.0), "steps": lambda: chassis.move(2.0),
              "task": lambda: chassis.go_to_mark("B1")}[what]()
print("MOVING", flush=True)
while True:
    ending = next_line()
    try:
        if ending == "hold":
            drive.hold(0.1, seconds=1.5)
            drive.set(0.1, valid_for=5.0)
        elif ending == "lapse":
            drive.set(0.1, valid_for=0.2)
        elif ending == "zero":
            drive.set(0.0)
        elif ending == "leave":
            drive.__exit__(None, None, None)
        elif ending == "stop":
            chassis.stop(timeout=2.0)
        elif ending == "cancel":
            handle.cancel(2.0)
        elif ending == "time-out":
            handle.wait(0.1, raises=False)
        elif ending == "close":
            chassis.close()
        print("DONE", flush=True)
    except Exception as error:
        print("DONE", type(error).__name__, error, flush=True)
"""
ENDINGS = {
    "velocity": ["lapse", "zero", "leave", "stop", "close"],
    "velocity, heartbeat": ["lapse", "leave"],
    "goal": ["cancel", "stop", "time-out", "close"],
    "steps": ["cancel", "stop"],
    "task": ["cancel", "stop", "time-out", "close"],
}
STANDS = 4.0
"""Seconds in which the robot stands, its own ramp and a busy computer included."""


@pytest.fixture(autouse=True)
def in_real_time(real_time):
    """What is seen while it moves."""


@pytest.fixture
def program(sim: SimulatedChassis) -> Iterator[Callable[..., RefusedMeans]]:
    begun: list[RefusedMeans] = []

    def begin(*words: str, **options: int) -> RefusedMeans:
        begun.append(RefusedMeans(*words, **options))
        return begun[-1]

    yield begin
    for each in begun:
        each.__exit__()


def stands(sim: SimulatedChassis) -> bool:
    end = time.monotonic() + STANDS
    while not sim.world.body.velocity.is_standing(0.0, 0.0):
        if time.monotonic() > end:
            return False
        time.sleep(0.01)
    return True


@pytest.mark.slow
@pytest.mark.promise("the system gives no more threads or files")
@pytest.mark.parametrize(
    ("what", "ending"), [(what, ending) for what, endings in ENDINGS.items() for ending in endings]
)
def test_it_stops_without_a_module_file_connection_or_thread(sim, until, program, what, ending):
    refused = program("-c", PROGRAM, sim.master_uri, what)
    refused.line("MOVING")
    until(lambda: moving(sim))
    refused.refuse()
    if what.startswith("velocity"):
        refused.say("hold")
        assert refused.line("DONE") == "", "it drives on"
        assert moving(sim)
    refused.say(ending)
    assert stands(sim)
    refused.line("DONE")
    assert sim.world.motion is None
    assert not sim.world.tasks.busy
    assert refused.asked_for == []


# -- the web server ------------------------------------------------------------------------------------------


def served(
    program: Callable[..., RefusedMeans], sim: SimulatedChassis, **options: int
) -> tuple[RefusedMeans, int]:
    """`woosh web`, and its port."""
    needs("web")
    words = ("web", "--master", sim.master_uri, "--port", "0", "--no-browser", "--allow-driving")
    refused = program("-m", "woosh_pure", *words, **options)
    return refused, int(refused.line("the page: http://127.0.0.1:").strip("/"))


@pytest.mark.slow
@pytest.mark.promise("driving by hand from the page of `woosh web` is interrupted")
@pytest.mark.parametrize("ending", ["release", "silence", "STOP", "POST", "gone"])
def test_so_does_a_page_drive(sim, until, program, ending):
    refused, port = served(program, sim)
    from tests.support.web import PageClient, Served

    with PageClient(port) as page:
        page.of("hello")
        page.ready()
        page.drive(0.2)
        until(lambda: moving(sim))
        refused.refuse()
        time.sleep(1.0)  # it drives on, and frames go to the page
        if ending == "release":
            page.let_go()
        elif ending == "silence":
            page.stop_beating()
        elif ending == "STOP":
            page.say(t="stop", n=1)
        elif ending == "POST":
            assert Served(port).post("stop", timeout=10.0).status == 200
        else:
            page.stop_beating()
            page.socket.close()
        assert stands(sim)
        # FastAPI reads the source of a function for its error texts, and goes without.
        assert [what for _, what, _ in refused.asked_for if not what.endswith(".py")] == []


@pytest.mark.slow
@pytest.mark.promise("STOP in the page, or POST `stop`, by anybody")
@pytest.mark.skipif(os.name == "nt", reason="there is no such limit")
@pytest.mark.parametrize("trial", range(TRIALS))
@pytest.mark.parametrize(("files", "strangers"), [(256, 320), (256, 150), (150, 320)])
def test_a_page_drive_and_a_stop_have_files_in_reserve(sim, until, program, files, strangers, trial):
    """However many strangers have connected and say nothing; 256 is the limit of macOS."""
    _, port = served(program, sim, files=files)
    from tests.support.web import PageClient, Served

    with PageClient(port) as page, ExitStack() as stack:
        page.of("hello")
        page.ready()
        page.drive(0.2)
        until(lambda: moving(sim))
        for _ in range(strangers):
            with suppress(BlockingIOError):
                stranger = stack.enter_context(socket.socket())
                stranger.setblocking(False)
                stranger.connect(("127.0.0.1", port))
        time.sleep(1.0)  # all that can be accepted is
        began = time.monotonic()
        answer = Served(port).post("stop", timeout=30.0)
        assert answer.status == 200
        assert time.monotonic() - began < 8.0  # 10 s are those of the strangers' time limit
        assert stands(sim)
