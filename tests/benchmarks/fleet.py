"""What vehicles of a fleet manager cost: many of ours in one process against one broker, Debian's mosquitto.

    python -m tests.benchmarks fleet [--vehicles 1,8,50,200] [--real 1,8] [--peers 8,50] [--seconds 15] [--away 5]
                                     [--only cost,restart,orders] [--orders 100,300,1000] [--nodelay]
                                     [--beside CHECKOUT]

* cost: processor and memory for a vehicle that stands and one that drives; messages and bytes; the delay from an
  order to the first motion, and from an arrival to the manager's knowing.
* restart: the broker is killed with all vehicles connected, is away for a while and comes back: how long until
  every vehicle is ONLINE and has told its state, how many messages, how much processor time.
* orders: how the cost of an order grows with its nodes, without and with an action at each: processor time of the
  order machine with its file, of the state messages, and what is written to disk; the exponents are those from the
  first size to the last.

`--vehicles` have a light stand-in for the chassis: it tells its pose ten times a second, needs no network, and
drives 1 m/s in a straight line; what the stand-ins themselves cost was measured before the vehicles were opened, and is
taken off. `--real` ones have a whole `Chassis` on a simulated one, whose process is not counted. `--peers` are
vehicles of others in a process of theirs: vda5050-sdk's VehicleClient with its reference executor (asyncio,
Python), and vda-5050-lib's virtual AGV (node), both told to send no visualization (see tests/support/fleet_peers.py).
`--nodelay` tells mosquitto not to hold messages back (`set_tcp_nodelay`; Debian's does, up to 40 ms). `--beside` is
another checkout of this project, whose vehicles run in the same rounds.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import queue
import re
import shutil
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from itertools import pairwise
from pathlib import Path
from typing import Any

from tests.support.mosquitto import Mosquitto, mosquitto

TICKS = os.sysconf("SC_CLK_TCK") if hasattr(os, "sysconf") else 100
ROOT = Path(__file__).resolve().parent.parent.parent
PEERS = Path(__file__).resolve().parent / "peers"
HEADER = ("headerId", "timestamp", "version", "manufacturer", "serialNumber")
LEGS = 3  # metres and edges of an order, there or back
ORDER_SECONDS = 60.0  # for one order of a size
SETTLE = 8.0  # s to see what the stand-ins cost


def run(arguments: list[str]) -> None:
    if arguments[:1] == ["vehicles"]:
        from tests.benchmarks.peers.fleet_vehicles import main

        main(*arguments[1:])
        return
    parser = argparse.ArgumentParser(prog="tests.benchmarks fleet")
    parser.add_argument("--vehicles", default="1,8,50,200")
    parser.add_argument("--real", default="1,8")
    parser.add_argument("--peers", default="8,50")
    parser.add_argument("--seconds", type=float, default=15.0)
    parser.add_argument("--away", type=float, default=5.0)
    parser.add_argument("--only", default="cost,restart,orders")
    parser.add_argument("--orders", default="100,300,1000")
    parser.add_argument("--nodelay", action="store_true")
    parser.add_argument("--beside", type=Path)
    args = parser.parse_args(arguments)
    checkouts = [("ours", ROOT), *([("beside", args.beside.resolve())] if args.beside else [])]
    sizes = numbers(args.vehicles)
    if "cost" in args.only:
        print(
            "cost: for one vehicle, processor in thousandths of a core, memory in MB; delays in ms, median and worst"
        )
        print(
            "| vehicles | standing | driving | the broker, driving | memory | threads | files | messages/s driving "
            "| bytes of a state | order to motion | arrival to manager |\n" + "|---" * 11 + "|"
        )
        for size in numbers(args.real):
            cost(f"{size} with a whole chassis", args, size, ours(ROOT, size, real=True))
        for size in sizes:
            for name, place in checkouts:
                cost(f"{size}{'' if place == ROOT else f' ({name})'}", args, size, ours(place, size))
        for size in numbers(args.peers):
            for name, command in peers().items():
                cost(f"{size} of {name}", args, size, command)
    if "restart" in args.only:
        print(
            "\nrestart: seconds from the broker's listening until the manager knew of all that they are ONLINE, and had a state"
        )
        print(
            "| vehicles | half | all | messages | processor of the vehicles, s | of the broker, s |\n"
            + "|---" * 6
            + "|"
        )
        for size in sizes:
            for name, place in checkouts:
                restart(f"{size}{'' if place == ROOT else f' ({name})'}", args, size, ours(place, size))
    if "orders" in args.only:
        print("\norders: seconds of processor time, MB written, and the state messages: seconds, number, MB")
        print(
            "| vehicle | nodes | actions at each | order and file | written | states | messages | MB |\n"
            + "|---" * 8
            + "|"
        )
        for name, place in checkouts:
            for actions in (0, 1):
                orders(name, place, numbers(args.orders), actions)


# -- orders ----------------------------------------------------------------------------------------------------


def orders(row: str, place: Path, sizes: list[int], actions: int) -> None:
    """The growth of one order; what takes longer than ORDER_SECONDS is not waited for."""
    measured: list[tuple[int, dict[str, float]]] = []
    for size in sizes:
        command = [
            "env",
            f"PYTHONPATH={place}",
            sys.executable,
            str(PEERS / "fleet_orders.py"),
            str(size),
            str(actions),
        ]
        try:
            done = subprocess.run(command, capture_output=True, text=True, timeout=ORDER_SECONDS, check=True)
        except subprocess.TimeoutExpired:
            print(f"| {row} | {size} | {actions} | not done in {ORDER_SECONDS:g} s |", flush=True)
            return
        found = json.loads(done.stdout)
        measured.append((size, found))
        print(
            f"| {row} | {size} | {actions} | {found['seconds']:.3f} | {found['written'] / 1e6:.2f} "
            f"| {found['told']:.3f} | {found['messages']} | {found['message_bytes'] / 1e6:.1f} |",
            flush=True,
        )
    (small, first), (large, last) = measured[0], measured[-1]
    if small != large:
        growth = {
            key: math.log(last[key] / first[key]) / math.log(large / small)
            for key in ("seconds", "written", "told")
        }
        print(
            f"| {row} | exponent | {actions} | {growth['seconds']:.2f} | {growth['written']:.2f} | {growth['told']:.2f} |",
            flush=True,
        )


def numbers(text: str) -> list[int]:
    return [int(part) for part in text.split(",") if part]


# -- processes -------------------------------------------------------------------------------------------------


def ours(place: Path, size: int, *, real: bool = False) -> list[str]:
    """Vehicles of a checkout; the stand-ins are of this one."""
    return ["env", f"PYTHONPATH={place}", f"FLEET_BENCHMARK={ROOT}", sys.executable,
            str(PEERS / "fleet_vehicles.py"), str(size), "real" if real else "light"]  # fmt: skip


def peers() -> dict[str, list[str]]:
    from tests.support.fleet_peers import NPM, PYPI, _folder

    found = {}
    python = _folder() / "venv" / "bin" / "python"
    if python.exists():
        found[PYPI] = ["env", "PYTHONPATH=", str(python), str(PEERS / "fleet_sdk.py")]
    modules = _folder() / "node_modules"
    if shutil.which("node") and (modules / "vda-5050-lib").exists():
        found[NPM] = ["env", f"NODE_PATH={modules}", "node", str(PEERS / "fleet_lib.js")]
    return found


class Vehicles:
    """The process under test. It says "standing" when it has made what it needs, and opens vehicles on "open"."""

    def __init__(self, command: list[str], size: int, broker: Mosquitto) -> None:
        words = [*command, str(size)] if "fleet_vehicles.py" not in " ".join(command) else command
        self.process = subprocess.Popen(
            [*words, broker.url], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1
        )
        self.lines: queue.Queue[str] = queue.Queue()
        self.log: list[dict[str, Any]] = []
        threading.Thread(target=self._read, daemon=True).start()
        self.wait_for("standing")

    def _read(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            if line.startswith("{"):
                self.log.append(json.loads(line))
            else:
                self.lines.put(line.strip())

    def wait_for(self, word: str, seconds: float = 120.0) -> None:
        while self.lines.get(timeout=seconds) != word:
            pass

    def tell(self, word: str) -> None:
        assert self.process.stdin is not None
        self.process.stdin.write(word + "\n")
        self.process.stdin.flush()

    @property
    def processor(self) -> float:
        return processor_of(self.process.pid)

    def figures(self) -> tuple[float, int, int]:
        """MB, threads, files."""
        status = Path(f"/proc/{self.process.pid}/status").read_text()
        found = {
            name: int(re.search(rf"^{name}:\s+(\d+)", status, re.MULTILINE)[1])
            for name in ("VmRSS", "Threads")
        }  # type: ignore[index]
        return found["VmRSS"] / 1024, found["Threads"], len(os.listdir(f"/proc/{self.process.pid}/fd"))

    def close(self) -> None:
        assert self.process.stdin is not None
        self.process.stdin.close()
        try:
            self.process.wait(60.0)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait(10.0)


def processor_of(pid: int) -> float:
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / TICKS


# -- the manager -----------------------------------------------------------------------------------------------


class Manager:
    """Hears all vehicles, and sends one after the other there and back."""

    def __init__(self, broker: Mosquitto, size: int) -> None:
        import paho.mqtt.client as mqtt

        self.size, self.port = size, broker.port
        self.came = threading.Condition()
        self.states: dict[str, dict[str, Any]] = {}
        self.online: dict[str, float] = {}
        self.told: dict[str, float] = {}
        self.counts: Counter[str] = Counter()
        self.bytes: Counter[str] = Counter()
        self.errors: Counter[str] = Counter()
        self.driving = self.real = False
        self.version = "2.1.0"
        self.orders: Counter[str] = Counter()
        self.sent: dict[tuple[str, str], float] = {}
        self.known: dict[tuple[str, str], float] = {}
        self.client = mqtt.Client(mqtt.CallbackAPIVersion.VERSION2)
        self.client.on_message = self._on_message
        self.client.on_connect = lambda client, *_: client.subscribe("uagv/v2/Woosh/+/+", 0)
        self.client.on_subscribe = lambda *_: self._ask()
        self.client.reconnect_delay_set(1, 1)

    def _ask(self) -> None:
        """Vehicles that were quicker than this have told their state to nobody: as every manager, ask for it."""
        for serial in serials(self.size):
            action = {
                "actionId": f"ask-{time.monotonic()}", "actionType": "stateRequest", "blockingType": "NONE",
                "actionParameters": [],
            }  # fmt: skip
            header = {key: value for key, value in order_json(serial, "", [0], 0.0).items() if key in HEADER}
            message = json.dumps({**header, "actions": [action]})
            self.client.publish(f"uagv/v2/Woosh/{serial}/instantActions", message)

    def connect(self) -> None:
        self.client.connect("127.0.0.1", self.port)
        self.client.loop_start()

    def close(self) -> None:
        self.client.disconnect()
        self.client.loop_stop()

    def _on_message(self, client: Any, data: Any, message: Any) -> None:
        now = time.monotonic()
        _, _, _, serial, topic = message.topic.split("/")
        if topic in ("order", "instantActions"):
            return
        with self.came:
            self.counts[topic] += 1
            self.bytes[topic] += len(message.payload)
            if topic == "connection":
                if json.loads(message.payload)["connectionState"] == "ONLINE":
                    self.online.setdefault(serial, now)
            elif topic == "state":
                state = json.loads(message.payload)
                self.states[serial] = state
                self.errors.update(error["errorType"] for error in state["errors"])
                self.told.setdefault(serial, now)
                self._go_on(serial, state, now)
            self.came.notify_all()

    def _go_on(self, serial: str, state: dict[str, Any], now: float) -> None:
        number = self.orders[serial]
        order, last = f"o{number}", f"{serial}-{LEGS if number % 2 else 0}"
        there = state["orderId"] == order and state["lastNodeId"] == last and not state["nodeStates"]
        if number and there and (serial, order) not in self.known:
            self.known[serial, order] = now
            if self.driving:
                self.send(serial)

    def send(self, serial: str) -> None:
        self.orders[serial] += 1
        number = self.orders[serial]
        way = list(range(LEGS + 1))
        if number % 2 == 0:
            way.reverse()
        order = order_json(serial, f"o{number}", way, 0.0 if self.real else float(serial[1:]))
        order["version"] = self.version
        self.sent[serial, f"o{number}"] = time.monotonic()
        self.client.publish(f"uagv/v2/Woosh/{serial}/order", json.dumps(order))

    def all_ready(self) -> bool:
        return len(self.online) >= self.size and len(self.told) >= self.size and all(
            state.get("agvPosition", {}).get("positionInitialized") and state["operatingMode"] == "AUTOMATIC"
            for state in self.states.values()
        )  # fmt: skip

    def wait(self, accept: Any, seconds: float, what: str) -> None:
        with self.came:
            if not self.came.wait_for(accept, seconds):
                missing = [s for s in serials(self.size) if s not in self.told or s not in self.online]
                raise TimeoutError(f"{what}: not within {seconds:g} s; missing {len(missing)}: {missing[:5]}")


def serials(size: int) -> list[str]:
    return [f"v{number}" for number in range(size)]


def order_json(serial: str, name: str, way: list[int], y: float) -> dict[str, Any]:
    nodes = [
        {
            "nodeId": f"{serial}-{place}", "sequenceId": 2 * n, "released": True, "actions": [],
            "nodePosition": {"x": float(place), "y": y, "theta": 0.0, "mapId": "hall",
                             "allowedDeviationXY": 0.3, "allowedDeviationXy": 0.3, "allowedDeviationTheta": math.pi},
        }
        for n, place in enumerate(way)
    ]  # fmt: skip
    edges = [
        {
            "edgeId": f"{serial}-{a}-{b}", "sequenceId": 2 * n + 1, "released": True, "actions": [],
            "startNodeId": f"{serial}-{a}", "endNodeId": f"{serial}-{b}",
        }
        for n, (a, b) in enumerate(pairwise(way))
    ]  # fmt: skip
    return {
        "headerId": 1, "timestamp": "2026-01-01T00:00:00.00Z", "version": "2.1.0", "manufacturer": "Woosh",
        "serialNumber": serial, "orderId": name, "orderUpdateId": 0, "nodes": nodes, "edges": edges,
    }  # fmt: skip


@contextmanager
def hall(
    args: Any, command: list[str], size: int
) -> Iterator[tuple[Mosquitto, Manager, Vehicles, float, float]]:
    """A broker, a manager, and the open vehicles; and what their process cost and took before they were opened."""
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        options = "allow_anonymous true\nset_tcp_nodelay true" if args.nodelay else ""
        broker = stack.enter_context(mosquitto(folder, options))
        manager = Manager(broker, size)
        manager.connect()
        stack.callback(manager.close)
        vehicles = Vehicles(command, size, broker)
        stack.callback(vehicles.close)
        time.sleep(0.5)
        before, memory = vehicles.processor, vehicles.figures()[0]
        time.sleep(SETTLE)
        idle = (vehicles.processor - before) / SETTLE
        vehicles.tell("open")
        vehicles.wait_for("open")
        manager.wait(manager.all_ready, 120.0, "all are ONLINE and AUTOMATIC")
        time.sleep(1.0)
        yield broker, manager, vehicles, idle, memory


def cost(row: str, args: Any, size: int, command: list[str]) -> None:
    with hall(args, command, size) as (broker, manager, vehicles, idle, memory):
        assert broker.process is not None
        manager.real = "real" in command
        manager.version = "2.0.0" if command[-1].endswith(".js") else "2.1.0"
        stood = rate(vehicles, args.seconds)
        mb, threads, files = vehicles.figures()
        with manager.came:
            manager.driving = True
            for serial in serials(size):
                manager.send(serial)
        time.sleep(2.0)
        manager.counts.clear()
        manager.bytes.clear()
        carried = processor_of(broker.process.pid)
        drove = rate(vehicles, args.seconds)
        carried = (processor_of(broker.process.pid) - carried) / args.seconds
        counts, sizes = Counter(manager.counts), Counter(manager.bytes)
        manager.driving = False
        vehicles.tell("log")
        vehicles.wait_for("logged")
        moved = {(e["serial"], e["order"]): e["at"] for e in vehicles.log if e["event"] == "motion"}
        arrived = {(e["serial"], e["order"]): e["at"] for e in vehicles.log if e["event"] == "arrival"}
        motion = [1000 * (moved[key] - at) for key, at in manager.sent.items() if key in moved]
        knowing = [1000 * (at - arrived[key]) for key, at in manager.known.items() if key in arrived]
        print(
            f"| {row} | {1000 * (stood - idle) / size:.2f} | {1000 * (drove - idle) / size:.2f} | {1000 * carried / size:.2f} | {(mb - memory) / size:.2f} "
            f"| {threads} | {files} | {sum(counts.values()) / args.seconds / size:.2f} "
            f"| {sizes['state'] / max(1, counts['state']):.0f} | {delays(motion)} | {delays(knowing)} |",
            flush=True,
        )
        complain(manager)


def complain(manager: Manager) -> None:
    """A run with errors measures something else."""
    if manager.errors:
        print(f"    states told of {dict(manager.errors)}", flush=True)


def rate(vehicles: Vehicles, seconds: float) -> float:
    before, began = vehicles.processor, time.monotonic()
    time.sleep(seconds)
    return (vehicles.processor - before) / (time.monotonic() - began)


def delays(values: list[float]) -> str:
    return f"{statistics.median(values):.1f}, {max(values):.0f} ({len(values)})" if values else ""


def restart(row: str, args: Any, size: int, command: list[str]) -> None:
    with hall(args, command, size) as (broker, manager, vehicles, _, _):
        manager.close()
        broker.kill()
        time.sleep(args.away)
        after = Manager(broker, size)
        broker.start()
        began, before = time.monotonic(), vehicles.processor
        after.connect()
        try:
            after.wait(lambda: len(after.online) >= size and len(after.told) >= size, 90.0, "all are back")
            each = sorted(max(after.online[s], after.told[s]) - began for s in serials(size))
            time.sleep(max(0.0, 10.0 - (time.monotonic() - began)))
            assert broker.process is not None
            print(
                f"| {row} | {each[size // 2]:.2f} | {each[-1]:.2f} | {sum(after.counts.values())} "
                f"| {vehicles.processor - before:.2f} | {processor_of(broker.process.pid):.2f} |",
                flush=True,
            )
        except TimeoutError as error:
            print(f"| {row} | {error} |", flush=True)
        finally:
            after.close()
