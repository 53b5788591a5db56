"""The sequence of checks of `woosh doctor`. It moves nothing and sends nothing to the robot.

Each check covers one link of the chain from our network card to the values of the robot, and stops the
chain if the following checks would only repeat its failure.
"""

from __future__ import annotations

import ipaddress
import math
import socket
import statistics
import time
from collections.abc import Generator, Iterator, Mapping, Sequence
from contextlib import closing

import rosproto
from rosproto.errors import ConnectionLost, RosError, RosTimeout
from rosproto.sentence import both, say
from rosproto.transport import Deadline, HostNames, hosts_advice, parse_uri
from rosproto.watchdog import is_watchdog_name
from woosh_pure import interface
from woosh_pure.doctor.checks import (
    Finding,
    Level,
    bad,
    chassis_nodes,
    check_definitions,
    check_nodes,
    ok,
    warn,
)
from woosh_pure.errors import ApiRefused
from woosh_pure.feed.feed import Feed
from woosh_pure.interface.schema import Row
from woosh_pure.robot_api.api import RobotApi, robot_api_at
from woosh_pure.robot_api.http import only_robot_api
from woosh_pure.values.messages import message_type

CORE = ("/robot_status", "/exec_task", "/move_base")
"""Present on every chassis; all other rows depend on the model."""
_CABLE = ipaddress.ip_network("169.254.128.0/24")
_FIRST, _LAST = ipaddress.IPv4Address("169.254.128.20"), ipaddress.IPv4Address("169.254.128.49")
_RATE_SECONDS = 0.3  # a shorter time says nothing about a rate: messages arrive in bursts
_ASKED, _SLOW_MS = 20, 150.0
_HARMLESS = "/rgbled"
"""Advertised without publishing: the chassis's node still connects back to us."""


def examine(
    master_uri: str,
    *,
    host: str | None = None,
    listen: float = 3.0,
    timeout: float = 3.0,
    resolve: Mapping[str, str] | None = None,
    robot_api: str | bool | None = None,
) -> Iterator[Finding]:
    """Check everything from this computer to a chassis; yield findings as they are made.

    Args:
        master_uri: The master.
        host: Our own address; None to detect it.
        listen: Seconds to listen to the topics.
        timeout: Seconds for each connection.
        resolve: Host name -> address, for names that this computer cannot resolve.
        robot_api: As of `Chassis`; False leaves it out.
    """
    name, port = parse_uri(master_uri)
    hosts = HostNames(resolve, master=name, quiet=True)
    address = yield from _name(name, hosts)
    if address is None:
        return
    yield _own_address(address, port, host)
    reached = _reach(address, port, timeout)
    yield reached
    without_ros = only_robot_api(master_uri) is not None
    if robot_api is not False or without_ros:
        with closing(robot_api_at(robot_api or None, master_uri, resolve)) as api:
            yield _robot_api(api)
            if without_ros:
                yield _latency(api)
                return
    if reached.level is Level.PROBLEM:
        return
    with rosproto.MasterClient(master_uri, "/woosh_doctor", timeout=timeout, hosts=hosts) as client:
        answered = _master(client)
        yield answered
        if answered.level is Level.PROBLEM:
            return
        state = client.get_system_state()
        found = _rows(state)
        yield found
        if found.level is Level.PROBLEM and not chassis_nodes(state):
            return
        yield from check_nodes(client, state, hosts, timeout)
    yield from _competitors(state)
    guessed = dict.fromkeys(hosts.unknown, address)  # already reported
    yield from _with_a_node(master_uri, host, state, listen, timeout, {**hosts.given, **guessed})


def _name(name: str, hosts: HostNames) -> Generator[Finding, None, str | None]:
    try:
        address = hosts.resolve(name)[0]
    except (ConnectionLost, RosTimeout) as error:
        advice = both(
            "use the numeric address, 169.254.128.2 on the debug port",
            say("or {advice}", advice=hosts_advice(name, None)),
        )
        yield bad("name", "the name {name} does not resolve: {error}", advice, name=name, error=error)
        return None
    yield ok("name", "the master is at {address}", address=address)
    return address


def _own_address(address: str, port: int, given: str | None) -> Finding:
    family = socket.AF_INET6 if ":" in address else socket.AF_INET
    try:
        with socket.socket(family, socket.SOCK_DGRAM) as probe:
            probe.connect((address, port or 1))  # sends nothing, only looks up the route
            own = given or str(probe.getsockname()[0])
    except OSError as error:
        advice = "connect the cable or the Wi-Fi; give this computer an address of the robot's network"
        return bad("own_address", "no route to {address}: {error}", advice, address=address, error=error)
    return check_own_address(address, own)


def check_own_address(robot: str, own: str) -> Finding:
    """Check that our address fits the robot's network. Pure."""
    if ipaddress.ip_address(robot) not in _CABLE:
        return ok("own_address", "our address towards it is {own}", own=own)
    if not _FIRST <= ipaddress.IPv4Address(own) <= _LAST:
        return bad(
            "own_address",
            "our address on the cable is {own}, outside of {first} to {last}",
            say(
                "give the wired interface a static address such as {first}, netmask 255.255.255.0",
                first=_FIRST,
            ),
            own=own,
            first=_FIRST,
            last=_LAST,
        )
    return ok("own_address", "our address on the cable is {own}", own=own)


def _reach(address: str, port: int, timeout: float) -> Finding:
    began = time.monotonic()
    try:
        socket.create_connection((address, port), timeout).close()
    except ConnectionRefusedError:
        advice = "is this the right port (11311)? the robot may still be starting: wait a minute"
        return bad(
            "reach", "{address} refuses the connection: no master there", advice, address=f"{address}:{port}"
        )
    except OSError as error:
        if isinstance(error, TimeoutError):
            text = say("{address} does not answer", address=f"{address}:{port}")
        else:
            text = say("{address} cannot be reached: {error}", address=f"{address}:{port}", error=error)
        advice = say(
            "ping {address}; check cable, Wi-Fi, address and firewall of this computer", address=address
        )
        return bad("reach", text, advice)
    return ok("reach", "connected in {time:.0f} ms", time=(time.monotonic() - began) * 1000)


def _master(client: rosproto.MasterClient) -> Finding:
    try:
        client.get_pid()
    except RosError as error:
        advice = "something listens there, but it is not a ROS master; check the port"
        return bad("master", "no ROS master answers: {error}", advice, error=error)
    return ok("master", "the ROS master answers")


def _robot_api(api: RobotApi) -> Finding:
    """A robot without it is as well: whether it has one, and what it says, is for the owner to know."""
    try:
        began = time.monotonic()
        scene = api.scene()
        seconds = time.monotonic() - began
        identity, marks = api.identity(), api.marks()
    except ApiRefused as error:
        return warn("robot_api", "the Robot API refuses: {error}", error=error)
    except (ConnectionLost, RosTimeout) as error:
        without = "no Robot API, so the robot's own marks and maps are not known; driving needs none: {why}"
        return ok("robot_api", without, why=say(error.why) if error.why else error)
    except RosError as error:
        advice = "another program may use that port; see docs/robot-api.md"
        return warn(
            "robot_api", "the Robot API gives answers that are not understood: {error}", advice, error=error
        )
    return ok(
        "robot_api",
        "the Robot API answers within {time} ms: {model} {software}, map {map} of {scene}, {marks} marks",
        time=math.ceil(seconds * 1000),
        model=identity.model,
        software=identity.software,
        map=scene.current_map,
        scene=scene.name,
        marks=len(marks),
    )


def _latency(api: RobotApi) -> Finding:
    """How long an answer takes: a velocity is on its way as long, and so is a stop."""
    times = []
    try:
        for _ in range(_ASKED):
            began = time.monotonic()
            api.request("OperationState")
            times.append(1000.0 * (time.monotonic() - began))
    except RosError as error:
        advice = "another program may use that port; see docs/robot-api.md"
        return bad("latency", "the Robot API does not answer: {error}", advice, error=error)
    median = math.ceil(statistics.median(times))
    text = "the Robot API answers within {median} ms (median of {count})"
    if median <= _SLOW_MS:
        return ok("latency", text, median=median, count=_ASKED)
    advice = "driving by velocity is not advisable: it would be obeyed, and stopped, so much later"
    return warn("latency", text, advice, median=median, count=_ASKED)


def _there(page: int, missing: Sequence[str]) -> str:
    if len(missing) == page:
        return "nothing is registered"
    registered = "{count} of {page} rows of its interface are registered"
    return say(registered, count=page - len(missing), page=page)


def _rows(state: rosproto.node.SystemState) -> Finding:
    missing = [row.name for row in interface.ROWS if row.source == "page" and not _is_there(row, state)]
    page = sum(row.source == "page" for row in interface.ROWS)
    if core := [name for name in CORE if name in missing]:
        text = both(
            say("no Woosh chassis here, or not all of it: {names} missing", names=core), _there(page, missing)
        )
        advice = "it may be another robot's master, or the chassis's programs have not started: wait a minute"
        return bad("interface", text, advice)
    if missing:
        advice = "this chassis may not have them (cameras, shelf lights), or a node has not started"
        return warn("interface", "not registered: {names}", advice, names=", ".join(missing))
    return ok("interface", "all {page} rows of the vendor's page are registered", page=page)


def _is_there(row: Row, state: rosproto.node.SystemState) -> bool:
    names = (row.name, *row.aliases)
    if row.kind == "service":
        return any(name in state.services for name in names)
    if row.kind == "action":
        return f"{row.name}/goal" in state.subscribers
    table = state.publishers if row.flow == "read" else state.subscribers
    return any(name in table for name in names)


def _competitors(state: rosproto.node.SystemState) -> Iterator[Finding]:
    """Find programs that send commands to the chassis, except its own nodes."""
    others: dict[str, list[str]] = {}
    topics = {f"{row.name}/goal": row.name for row in interface.actions()}
    topics |= {row.name: row.name for row in interface.topics("write") if row.bypasses_protection}
    for topic, name in topics.items():
        for node in set(state.publishers.get(topic, [])) - interface.ROBOT_NODES:
            if not is_watchdog_name(node):
                others.setdefault(node, []).append(name)
    for node, names in sorted(others.items()):
        advice = "end that program, or agree who drives: two clients interrupt each other"
        yield warn("competitor", "{node} also commands {names}", advice, node=node, names=", ".join(names))
    if not others:
        yield ok("competitor", "nobody else commands the chassis")


def _with_a_node(
    master_uri: str,
    host: str | None,
    state: rosproto.node.SystemState,
    listen: float,
    timeout: float,
    resolve: Mapping[str, str] | None,
) -> Iterator[Finding]:
    try:
        node = rosproto.Node(
            "/woosh_doctor", master_uri=master_uri, host=host, anonymous=True, resolve=resolve
        )
    except RosError as error:
        yield bad("join", "we cannot join the graph: {error}", "see the text", error=error)
        return
    with node:
        yield ok("join", "we joined as {node} at {uri}", node=node.name, uri=node.uri)
        yield _connect_back(node, state, timeout)
        yield from _topics(node, state, listen)


def _connect_back(node: rosproto.Node, state: rosproto.node.SystemState, timeout: float) -> Finding:
    if _HARMLESS not in state.subscribers:
        return warn("back", "{name} has no subscriber: the way back was not tested", name=_HARMLESS)
    publisher = node.publisher(_HARMLESS, message_type(interface.row(_HARMLESS).type))
    try:
        publisher.wait_for_connection(timeout=timeout)
    except RosTimeout:
        caller = ", ".join(state.subscribers[_HARMLESS])
        text = say(
            "we reach the chassis, but {caller} does not reach us at {uri}", caller=caller, uri=node.uri
        )
        advice = "allow Python through the firewall, or give our correct address with --host"
        return bad("back", text, advice)
    finally:
        publisher.close()
    return ok("back", "the chassis connects back to us")


def _topics(node: rosproto.Node, state: rosproto.node.SystemState, listen: float) -> Iterator[Finding]:
    heavy = ("sensor_msgs/Image", "sensor_msgs/PointCloud2")
    rows = [r for r in interface.feeds() if r.name in state.publishers and r.type not in heavy]
    feeds = [Feed[object](row, lambda: node).open() for row in rows]
    deadline = Deadline(listen)
    while not deadline.expired and not all(feed.heard or feed.row.on_change for feed in feeds):
        time.sleep(0.05)
    yield from check_definitions(node, state)
    silent = [f.topic for f in feeds if not f.heard and not f.row.on_change and f.row.source == "page"]
    if silent:
        advice = "the node behind it hangs, or its links are blocked; restart the robot if it stays like that"
        text = say("registered, but silent for {listen:g} s: {names}", listen=listen, names=", ".join(silent))
        yield warn("silent", text, advice)
    else:
        yield ok("silent", "{count} topics were heard", count=sum(f.heard for f in feeds))
    yield from _clock(feeds)
    for feed in feeds:
        feed.close()


def _rate(feeds: list[Feed[object]]) -> float | None:
    """Seconds of the robot's stamps in one second of ours; None when too little was heard."""
    rates = []
    for feed in feeds:
        stamped = [(reading.received, reading.stamp) for reading in feed.history if reading.stamp is not None]
        if stamped and stamped[-1][0] - stamped[0][0] > _RATE_SECONDS:
            (began, first), (ended, last) = stamped[0], stamped[-1]
            rates.append((last - first) / (ended - began))
    return statistics.median(rates) if rates else None


def _clock(feeds: list[Feed[object]]) -> Iterator[Finding]:
    offsets = [
        reading.stamp - (time.time() - reading.age)
        for feed in feeds
        for reading in feed.history[-5:]
        if reading.stamp is not None
    ]
    if not offsets:
        return
    rate = _rate(feeds)
    if rate is not None and not 0.67 < rate < 1.5:  # its offset from ours is another one each second
        text = say(
            "the robot's clock runs {rate:.1f} times as fast as ours: it is simulated, or being set",
            rate=rate,
        )
        yield ok("clock", text)
        return
    offset = statistics.median(offsets)
    if offset > 0:
        text = say("the robot's clock is {time:.2f} s ahead of ours", time=offset)
    else:
        text = say("the robot's clock is {time:.2f} s behind ours", time=-offset)
    if abs(offset) > 1.0:
        advice = (
            "our goals carry no stamp and ages use our own clock, so driving works; but of a ROS program "
            "that stamps its goals itself, as rospy's do, goals stamped before the last one are dropped, and "
            "while its clock is ahead of the robot's it shuts out everybody else: set the clocks if you run "
            "one, or use the stamps"
        )
        yield warn("clock", text, advice)
    else:
        yield ok("clock", text)
