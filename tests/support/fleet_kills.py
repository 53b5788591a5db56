"""Kill -9 of the broker, the robot or our own process at a random moment of an order.

    with Hall(folder, seed) as hall:
        print(hall.trial("process"))

A trial sends an order of three nodes with an action on each, the last node as horizon; releases it by an update at
a random moment; kills; restarts after a random time; and checks the messages that the manager receives. An order, an
update or the end of an action that a state acknowledged must be kept; others are sent again, as by a manager, and an
order that our process holds after its restart is resumed. In the end the order must be done, no node skipped, no
action begun twice.
"""

from __future__ import annotations

import json
import math
import os
import random
import subprocess
import sys
import time
from contextlib import ExitStack
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from types import TracebackType
from typing import Any

from tests.support.fleet_master import Master, errors, order_over, statuses
from tests.support.fleet_peers import ROOT
from tests.support.mosquitto import mosquitto
from tests.support.ports import unused_port

__all__ = ["VICTIMS", "Hall", "Trial"]

VICTIMS = ("process", "broker", "robot")
PREFIX = "uagv/v2/Woosh/A-17"
SPEED = 3.0
ROBOT = """
import sys
from woosh_pure import SimulatedChassis
with SimulatedChassis(speed=float(sys.argv[2]), port=int(sys.argv[1])) as sim:
    print("ready", flush=True)
    for line in sys.stdin:
        with sim.lock:
            pose = sim.world.body.pose
        print(pose.x, pose.y, flush=True)
"""
BEEP = """
import json, sys, time
name = json.loads(sys.stdin.readline())["actionId"]
with open(sys.argv[1], "a") as file:
    file.write(name + "\\n")
time.sleep(0.2)
"""


@dataclass
class Trial:
    """The result of a trial.

    Attributes:
        true_after: Seconds from the restart until a correct state came.
        online_after: Seconds from the restart until ONLINE, or until the broker accepted our connection.
        wrong: Violations; empty if there are none.
    """

    victim: str
    seed: str
    true_after: float
    online_after: float
    wrong: list[str]
    processor: float = (
        math.nan
    )  # seconds that our process had used then: what it takes where nothing else runs


class Hall:
    """A broker, a robot, our process and a manager, each of which can be killed; use it in a `with` block."""

    def __init__(self, folder: Path, seed: int = 0) -> None:
        self.folder, self.seed = folder, seed
        self.number = 0
        self.silence_after = 0.0
        self.beeps = folder / "beeps"
        self.robot_port = unused_port()
        self._stack = ExitStack()

    def __enter__(self) -> Hall:
        with ExitStack() as stack:
            self.broker = stack.enter_context(mosquitto(self.folder))
            stack.callback(lambda: end(self.robot))
            self.start_robot()
            script = self.folder / "beep.py"
            script.write_text(BEEP)
            command = json.dumps(f"!{sys.executable} {script} {self.beeps}")
            self.config = self.folder / "fleet.toml"
            self.config.write_text(
                f'[broker]\nurl = "{self.broker.url}"\n[[vehicle]]\nmanufacturer = "Woosh"\nserial = "A-17"\n'
                f'map_id = "hall"\nchassis = "http://127.0.0.1:{self.robot_port}/"\nactions = {{ beep = {command} }}\n'
            )
            stack.callback(lambda: self.master.__exit__(None, None, None))
            self.master = Master(self.broker.port).__enter__()
            stack.callback(lambda: end(self.process))
            self.start_process()
            self.master.until(ready, 30.0)
            self._stack = stack.pop_all()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stack.close()

    def start_robot(self) -> None:
        command = [sys.executable, "-c", ROBOT, str(self.robot_port), str(SPEED)]
        self.robot = subprocess.Popen(
            command, cwd=ROOT, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        assert self.robot.stdout is not None
        assert self.robot.stdout.readline() == "ready\n"

    def start_process(self) -> None:
        """Start our process with cached bytecode, as of an installed package: compiling takes longest."""
        command = [sys.executable, "-m", "woosh_pure", "vda5050", "--config", str(self.config)]
        env = {key: value for key, value in os.environ.items() if key != "PYTHONDONTWRITEBYTECODE"}
        env["PYTHONPYCACHEPREFIX"] = str(self.folder / "bytecode")
        with (self.folder / "vehicle.log").open("a") as log:
            self.process = subprocess.Popen(
                [*command, "--state", str(self.folder)],
                cwd=ROOT,
                env=env,
                stdout=log,
                stderr=subprocess.STDOUT,
            )

    def start_broker(self) -> None:
        """Start the broker with a connected manager, so that only the vehicle's return is measured."""
        self.master.__exit__(None, None, None)
        self.broker.start()
        self.master = Master(self.broker.port).__enter__()
        self.master.instant(f"state-{self.number}-{time.monotonic()}", "stateRequest")

    def where(self) -> tuple[float, float]:
        assert self.robot.stdin is not None
        assert self.robot.stdout is not None
        self.robot.stdin.write("\n")
        self.robot.stdin.flush()
        x, y = self.robot.stdout.readline().split()
        return float(x), float(y)

    def trial(self, victim: str) -> Trial:
        """One order, one kill."""
        self.number += 1
        name = f"{self.seed}-{self.number}"
        chance = random.Random(name)
        way = ["n1 n2 n3", "n3 n2 n1"][self.master.all()[-1]["lastNodeId"] == "n3"].split()
        beeps = {node: [beep(f"{name}-{node}", chance)] for node in way}
        order = order_over(name, " ".join(way), released=2, actions=beeps)
        more = order_over(name, " ".join(way[1:]), first=2, update=1, actions=beeps)
        self.master.send("order", order)
        self.master.until(lambda s: s["orderId"] == name)
        update_at = chance.uniform(0.0, 1.5)
        kill_at = chance.uniform(0.0, 3.0)
        away = chance.uniform(1.0, 3.0) if victim == "robot" else chance.uniform(0.0, 1.5)
        sent = update_at < kill_at
        if sent:
            time.sleep(update_at)
            self.master.send("order", more)
        time.sleep(kill_at - (update_at if sent else 0.0))
        self.kill(victim)
        gone = time.monotonic()
        told = self.master.all()
        acknowledged = max(s["orderUpdateId"] for s in told if s["orderId"] == name)
        ended = {k: v for k, v in statuses(told[-1]).items() if v == "FINISHED"}
        time.sleep(away)
        wrong: list[str] = []
        if victim == "robot":
            self.look_for_silence(gone, wrong)
        began = time.monotonic()
        getattr(self, f"start_{victim}")()
        if victim == "robot":
            began = time.monotonic()  # it is back when it says so
        true_after, online_after = self.watch(began, name, acknowledged, ended, wrong)
        processor = self.processor()
        if true_after < 60.0:
            self.finish(name, way, more, wrong)
        return Trial(victim, name, true_after, online_after, wrong, processor)

    def processor(self) -> float:
        stat = Path(f"/proc/{self.process.pid}/stat")
        if not stat.exists():
            return math.nan
        fields = stat.read_text().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def kill(self, victim: str) -> None:
        {"broker": self.broker.kill, "robot": lambda: end(self.robot), "process": lambda: end(self.process)}[
            victim
        ]()

    def look_for_silence(self, gone: float, wrong: list[str]) -> None:
        """Check that the loss of the robot is reported."""
        try:
            self.master.until(lambda s: "robotLost" in errors(s), 10.0)
        except AssertionError:
            wrong.append("the robot's silence was not told")
        else:
            at = next(
                at
                for at, topic, s, _ in self.master.heard
                if at > gone and topic == "state" and "robotLost" in errors(s)
            )
            self.silence_after = at - gone

    def watch(
        self, began: float, name: str, acknowledged: int, ended: dict[str, str], wrong: list[str]
    ) -> tuple[float, float]:
        """Note the time of the first correct state. Old states may come late; one that denies an acknowledgement is wrong."""
        seen, online = 0, math.inf
        deadline = began + 60.0
        while time.monotonic() < deadline:
            with self.master._changed:
                self.master._changed.wait_for(lambda seen=seen: len(self.master.heard) > seen, 1.0)
                new = self.master.heard[seen:]
                seen += len(new)
            for at, topic, message, retained in new:
                if at < began or retained:
                    continue
                if topic == "connection" and message["connectionState"] == "ONLINE":
                    online = min(online, at - began)
                if topic != "state":
                    continue
                if message["orderId"] != name or message["orderUpdateId"] < acknowledged:
                    wrong.append(
                        f"lost: {message['orderId']} {message['orderUpdateId']}, acknowledged {acknowledged}"
                    )
                lost = [k for k in ended if statuses(message).get(k) != "FINISHED"]
                if lost:
                    wrong.append(f"ended actions are forgotten: {lost}")
                if wrong:
                    return at - began, online
                if ready(message) and "robotLost" not in errors(message):
                    x, y = self.where()
                    position = message["agvPosition"]
                    far = math.hypot(position["x"] - x, position["y"] - y)
                    if far < 0.2 + 1.2 * SPEED * (time.monotonic() - at + 0.15):
                        return at - began, online
        wrong.append("no true state within a minute")
        return 60.0, online

    def finish(self, name: str, way: list[str], more: dict[str, Any], wrong: list[str]) -> None:
        """The order comes to its end; the manager sends the update until it is acknowledged."""
        deadline = time.monotonic() + 60.0
        done = False
        while not done and time.monotonic() < deadline:
            state = self.master.all()[-1]
            done = state["lastNodeId"] == way[2] and not state["nodeStates"] and not running(state)
            if not done and state["orderUpdateId"] == 0:
                self.master.send("order", more)
            if not done and "orderHeld" in errors(
                state
            ):  # after a restart of ours somebody must say that it goes on
                self.master.instant(f"go-{name}-{time.monotonic()}", "stopPause")
            with self.master._changed:
                if not done:
                    self.master._changed.wait(1.0)
        states = [s for s in self.master.all() if s["orderId"] == name]
        if not done:
            wrong.append(f"the order is not done: {states[-1:]}")
            return
        begun = self.beeps.read_text().split() if self.beeps.exists() else []
        for action, status in statuses(states[-1]).items():
            times = begun.count(action)
            if not action.startswith(name):
                continue  # of the manager's own
            if times > 1:
                wrong.append(f"{action} was begun {times} times")
            if status == "FINISHED" and not times:
                wrong.append(f"{action} is told as FINISHED and was not begun")
            if status not in ("FINISHED", "FAILED"):
                wrong.append(f"{action} is {status}")
        missing = [f"{name}-{node}" for node in way if f"{name}-{node}" not in statuses(states[-1])]
        if missing:
            wrong.append(f"actions are missing: {missing}")
        places = [way.index(s["lastNodeId"]) for s in states if s["lastNodeId"] in way]
        if any(b < a for a, b in pairwise(places)):
            wrong.append(f"nodes went backwards: {places}")


def end(process: subprocess.Popen[Any]) -> None:
    process.kill()
    process.wait(10.0)


def beep(name: str, chance: random.Random) -> dict[str, Any]:
    blocking = chance.choice(["NONE", "SOFT", "HARD"])
    return {"actionId": name, "actionType": "beep", "blockingType": blocking, "actionParameters": []}


def ready(state: dict[str, Any]) -> bool:
    position = state.get("agvPosition")
    return bool(
        position
        and position["positionInitialized"]
        and state["operatingMode"] in ("AUTOMATIC", "SEMIAUTOMATIC")
    )


def running(state: dict[str, Any]) -> bool:
    return any(status not in ("FINISHED", "FAILED") for status in statuses(state).values())
