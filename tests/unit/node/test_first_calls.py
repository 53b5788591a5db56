"""A callback does not run before the constructor that was given it has returned, and its caller has gone on."""

from __future__ import annotations

import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from rosproto import ActionServer
from rosproto.master import Master
from rosproto.node import Node
from rosproto.node.call_site import PATIENCE, CallSite, _stack_of
from rosproto.node.graph.registrations import Registrations
from rosproto.node.incoming.subscription import Subscription
from tests.support.victim import eventually

ROOT = Path(__file__).parents[3]
String = "std_msgs/String"


@pytest.fixture(autouse=True)
def eager_threads() -> Iterator[None]:
    """Other threads get their turn at every moment, also between a call and the assignment behind it."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-5)
    yield
    sys.setswitchinterval(before)


class Program:
    """Notes whether `made` was there when it was called."""

    def __init__(self) -> None:
        self.made: Any = None
        self.seen: list[bool] = []

    def __call__(self, *_: object) -> None:
        self.seen.append(self.made is not None)


def wait_for_first(program: Program) -> None:
    eventually(lambda: program.seen)
    assert program.seen[0]


@pytest.fixture
def slow_return(monkeypatch: pytest.MonkeyPatch) -> threading.Event:
    """The master's answer is there, links are made and have received; then the registration takes its time."""
    waited = threading.Event()
    add = Registrations.add

    def slowly(self: Registrations, *arguments: Any) -> None:
        add(self, *arguments)
        waited.wait(0.1)  # the callback would have come by now

    monkeypatch.setattr(Registrations, "add", slowly)
    return waited


@pytest.mark.usefixtures("slow_return")
@pytest.mark.parametrize("inline", [False, True])
def test_a_latched_message_waits_for_the_constructor(nodes: tuple[Node, Node], inline: bool) -> None:
    a, b = nodes
    a.publisher("/kept", String, latch=True).publish(data="x")
    program = Program()
    program.made = b.subscriber("/kept", String, program, inline=inline)
    wait_for_first(program)


def test_it_waits_in_a_storm_of_threads(nodes: tuple[Node, Node]) -> None:
    """Without any help of slowness: fifty times, each between two bytecodes of the caller."""
    a, b = nodes
    publisher = a.publisher("/kept", String, latch=True)
    publisher.publish(data="x")
    for _ in range(50):
        program = Program()
        program.made = b.subscriber("/kept", String, program)
        wait_for_first(program)
        program.made.close()


def test_a_second_subscriber_gets_the_latched_message_afterwards_and_first(nodes: tuple[Node, Node]) -> None:
    """It is handed over in the constructor itself; what comes live meanwhile comes after it."""
    a, b = nodes
    publisher = a.publisher("/kept", String, latch=True)
    publisher.publish(data="0")
    with b.subscriber("/kept", String) as other:
        other.next(20)
        program = Program()
        texts: list[str] = []

        def callback(message: Any) -> None:
            program(message)
            texts.append(message.data)

        program.made = b.subscriber("/kept", String, callback)
        for number in range(1, 6):
            publisher.publish(data=str(number))
        eventually(lambda: texts[-1:] == ["5"])
        assert program.seen[0]
        assert texts == sorted(texts)
        assert texts[0] == "0"


@pytest.mark.usefixtures("slow_return")
def test_a_service_waits_for_its_constructor(nodes: tuple[Node, Node]) -> None:
    a, b = nodes
    program = Program()

    def call() -> None:
        b.wait_for_service("/early", timeout=20)
        b.service_client("/early", "std_srvs/Empty").call(timeout=20)

    client = threading.Thread(target=call)
    client.start()
    program.made = a.service_server("/early", "std_srvs/Empty", program)
    client.join(30)
    wait_for_first(program)


@pytest.mark.usefixtures("slow_return")
def test_on_connect_waits_for_the_publisher(nodes: tuple[Node, Node]) -> None:
    a, b = nodes
    with b.subscriber("/wanted", String):
        program = Program()
        program.made = a.publisher("/wanted", String, on_connect=program)
        wait_for_first(program)


@pytest.mark.usefixtures("slow_return")
def test_an_action_server_waits_for_its_constructor(nodes: tuple[Node, Node]) -> None:
    a, b = nodes
    goals = b.publisher("/act/goal", "move_base_msgs/MoveBaseActionGoal", latch=True)
    goals.publish()
    program = Program()
    program.made = ActionServer(a, "/act", "move_base_msgs/MoveBaseAction", program)
    wait_for_first(program)
    program.made.close()


def test_a_decoder_is_made_by_the_link() -> None:
    """It takes 2 ms, and no constructor waits for that."""
    with Master() as master, Node("/n", master_uri=master.uri, rosout=False) as node:
        subscription: Subscription = node.subscriber("/nobody", "sensor_msgs/CameraInfo")._subscription
        assert "delivery" not in vars(subscription)
        first = subscription.delivery
        assert subscription.delivery is first
        with pytest.raises(AttributeError, match="nothing"):
            _ = subscription.nothing


def told(act: Callable[[CallSite], None]) -> CallSite:
    site = CallSite(sys._getframe(1))
    act(site)
    return site


def test_a_call_site() -> None:
    """Left as soon as the caller is past the call, also when another one at the same place is under way."""
    inside: list[bool] = []
    site = told(lambda site: inside.extend([site.is_here, site.is_left]))
    assert inside == [True, False]
    assert site.is_left
    assert not site.is_here
    site.wait()

    made: list[CallSite] = []
    released = threading.Event()
    thread = threading.Thread(target=lambda: told(lambda site: (made.append(site), released.wait(20))))  # type: ignore[arg-type, return-value]
    thread.start()
    eventually(lambda: made)
    assert not made[0].is_left
    began = threading.Event()
    began.wait(0)
    made[0].wait()  # nobody returns: it is bounded
    assert not made[0].is_left
    assert PATIENCE <= 1
    released.set()
    thread.join(20)
    assert made[0].is_left


COLLECTED_MEANWHILE = """
import gc, sys, threading
from rosproto.node.call_site import CallSite

class Knot:
    def __init__(self):
        self.itself, self.local = self, threading.local()
        self.local.value = 1

def ask():
    return site.is_left

def made():
    return CallSite(sys._getframe(1))

site = made()
gc.set_threshold(1, 1000, 1000)
for _ in range(200):
    gc.disable()
    Knot()
    spare = [{} for _ in range(20)]  # when they are freed, the next dict is one of them, and collects nothing
    del spare
    gc.enable()
    assert ask()
print("went on")
"""


def test_a_stack_is_whole_however_fast_its_thread_goes_on() -> None:
    """From the innermost call to the thread's first; of a thread that has ended there is none."""
    going_on = True

    def descend(depth: int) -> int:
        return descend(depth - 1) + sum(number for number in range(3)) if depth else 0

    def work() -> None:
        while going_on:
            descend(20)

    thread = threading.Thread(target=work)
    thread.start()
    depths = set()
    try:
        looks, end = 0, time.monotonic() + 20.0
        # A busy machine lets the other thread go on rarely.
        while looks < 2000 or (len(depths) < 2 and time.monotonic() < end):
            stack = _stack_of(thread.ident or 0)
            assert stack[-1].f_code.co_name == "_bootstrap"
            depths.add(len(stack))
            looks += 1
    finally:
        going_on = False
        thread.join()
    assert len(depths) > 1
    assert _stack_of(thread.ident or 0) == []


def test_looking_at_a_thread_survives_a_collection() -> None:
    """An old interpreter holds its list of threads while it tells where they are, and a `threading.local` needs it."""
    path = f"import sys; sys.path.insert(0, {str(ROOT)!r})"
    # Isolated: the audit hook of these tests would collect before the interpreter does.
    done = subprocess.run(
        [sys.executable, "-I", "-c", path + COLLECTED_MEANWHILE], capture_output=True, text=True, timeout=60
    )
    assert done.stdout.strip() == "went on", done.stderr
