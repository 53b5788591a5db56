"""`RobotApi`: what the robot tells by its Robot API and not by ROS 1: marks, maps, zones, history, settings.

Every method asks the robot and waits for its answer, in the thread that calls it. None of them is used by a
feed or a stop, and of the verbs by `task_list` alone.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from typing import Any

from rosproto.errors import RosError
from rosproto.logs import get_logger
from rosproto.sentence import say
from rosproto.text import near_names
from rosproto.transport import Deadline, HostNames, parse_uri
from woosh_pure.enums import RobotState
from woosh_pure.errors import ChassisError, MotionRefused
from woosh_pure.robot_api import values, wire
from woosh_pure.robot_api.http import ApiRequests, api_address, only_robot_api

SCENE_SECONDS = 30.0
"""Seconds for an answer with pictures of maps."""
LOCALISED_SECONDS, SETTLED_SECONDS, _LOOK_SECONDS = 10.0, 1.0, 0.2
"""After a switch of the map: how long it is waited for that the robot is localised, and how long it must say
so, because it may say it of the map before."""
_SWITCHES_IN = (RobotState.UNINITIALISED, RobotState.IDLE, RobotState.CHARGING, RobotState.FAULT)
_MAX_PAGES, _PAGE = 50, 100
_log = get_logger("woosh_pure.robot_api")


class RobotApi:
    """The Robot API of one robot, by plain HTTP: `chassis.robot_api`.

    Nothing is asked before a method is called. A robot without it is asked once a minute at most.

    Args:
        requests: Asks the robot; None if the Robot API is switched off.
        require_free_base: Raises `MotionRefused` while the base is commanded by the caller's program.
    """

    def __init__(self, requests: ApiRequests | None, require_free_base: Callable[[str], object]) -> None:
        self._requests = requests
        self._require_free_base = require_free_base

    def __repr__(self) -> str:
        return f"<RobotApi {self._requests or 'off'}>"

    def available(self) -> bool:
        """Whether the robot answers. Waits 1.5 s at most."""
        try:
            self._ask("woosh.robot.RobotState", timeout=1.5)
        except RosError as error:
            _log.debug("= no Robot API: %s", error)
            return False
        return True

    def request(
        self,
        type: str,
        body: Mapping[str, Any] | None = None,
        *,
        change: bool = False,
        timeout: float = 5.0,
    ) -> dict[str, Any]:
        """Send any request that does not move the robot, and return all fields of the answer.

        Args:
            type: "woosh.robot.Battery", or its last words, "Battery", "setting.Sound".
            body: Its fields by their names, as the vendor's manual has them; absent ones have their defaults.
            change: True sends also what changes something: settings (with `AutoCharge` and `AutoPark` the
                robot starts driving by itself), maps, the robot's pose.

        Raises:
            ValueError: There is no such request or field, or it changes something and `change` is false.
            MotionRefused: The request moves the robot: use the verbs of `Chassis`, which know how to stop.
            ApiRefused: The robot refused.
            ConnectionLost, RosTimeout, RemoteProtocolError: See `available`; or the answer is not valid.
        """
        name = request_named(type)
        kind = wire.requests()[name].kind
        if kind == "move":
            text = "{name} moves the robot; use the verbs of Chassis, which know how to stop it"
            raise MotionRefused(say(text, name=name))
        if kind == "change" and not change:
            raise ValueError(say("{name} changes something on the robot: give change=True", name=name))
        return self._ask(name, body, timeout=timeout)

    # -- what it is, and how it is

    def identity(self) -> values.RobotIdentity:
        """Name, model, size and versions."""
        name = self.settings().get("identity", {}).get("name", "")
        return values.identity_of(self._ask("woosh.robot.General"), name)

    def facts(self) -> values.DeviceFacts:
        """State, mode, emergency stop, localised, occupied, taskable."""
        state, mode = self._ask("woosh.robot.RobotState"), self._ask("woosh.robot.Mode")
        return values.facts_of(state, mode, self._device_state(), self._ask("woosh.robot.OperationState"))

    def outline(self) -> values.Outline:
        """The outline that the robot drives with now."""
        return values.outline_of(self._ask("woosh.robot.Model"))

    def settings(self) -> dict[str, Any]:
        """Its settings by the names of the interface (woosh.robot.Setting); `request` changes them."""
        return self._ask("woosh.robot.Setting")

    # -- maps

    def scene(self) -> values.Scene:
        """The scene and map in use."""
        body = self._ask("woosh.robot.Scene")
        name, current = body["sceneName"], body["mapName"]
        return values.Scene(name, (current,) if current else (), current, body["version"])

    def scenes(self) -> list[values.Scene]:
        """All scenes with their maps."""
        return values.scenes_of(self._ask("woosh.map.SceneList"), self.scene())

    def marks(self, scene: str = "", *, timeout: float = SCENE_SECONDS) -> list[values.RobotMark]:
        """The marks of all maps of a scene; "" is the one in use."""
        return values.marks_of(self._ask("woosh.map.SceneDataEasy", {"name": scene}, timeout=timeout))

    def zones(self, scene: str = "", *, timeout: float = SCENE_SECONDS) -> list[values.Zone]:
        """The zones of all maps of a scene; "" is the one in use. Slow: pictures of the maps come along."""
        return values.zones_of(self._ask("woosh.map.SceneData", {"name": scene}, timeout=timeout))

    def switch_map(self, scene: str, map: str = "", *, timeout: float = 60.0) -> values.Scene:
        """Let the robot use another map that it has; wait until it does.

        The robot may not know where it is on the new map: look at `localised` of the result, and give it its
        pose with `Chassis.set_pose`.

        Args:
            scene: Name of the scene.
            map: Name of the map; "" leaves the choice to the robot.
            timeout: Seconds until the robot must name the new map.

        Returns:
            The scene in use now; `localised` is false if the robot does not know where it is 10 s later.

        Raises:
            MotionRefused: The base is not free, or the robot's state does not allow it; nothing was sent.
            ApiRefused: The robot refused: it has no such map, or is in manual mode.
            RosTimeout: It has not named the new map in time; it may still do so.
            ConnectionLost, RemoteProtocolError: It does not answer, or the answer is not valid.
            ValueError: The name is empty.
        """
        if not scene.strip():
            raise ValueError("switch_map: give the name of a scene")
        self._require_free_base("switch_map")
        state = RobotState(self._ask("woosh.robot.RobotState")["state"])
        if state not in _SWITCHES_IN:
            wrong = "switch_map refused, nothing was sent: the robot is {state}; wait until it is idle"
            raise MotionRefused(say(wrong, state=state))
        deadline = Deadline(timeout)
        body = {"sceneName": scene, "mapName": map}
        self._ask("woosh.robot.SwitchMap", body, timeout=timeout)
        while not ((now := self.scene()).name == scene and map in ("", now.current_map)):
            deadline.check(
                say("switch_map: the robot uses {map} of {scene}", map=now.current_map, scene=now.name)
            )
            time.sleep(_LOOK_SECONDS)
        return values.Scene(now.name, now.maps, now.current_map, now.version, self._localised_at_last())

    def _localised_at_last(self) -> bool | None:
        """Whether the robot says for `SETTLED_SECONDS` that it is localised; None if it cannot say."""
        patience, since = Deadline(LOCALISED_SECONDS), math.inf
        while not patience.expired:
            if (device := self._device_state()) is None:
                return None
            since = min(since, time.monotonic()) if device["software"] & 1 else math.inf
            if time.monotonic() - since >= SETTLED_SECONDS:
                return True
            time.sleep(_LOOK_SECONDS)
        return False

    # -- what it did

    def task_history(self) -> list[values.TaskRecord]:
        """The last tasks (up to 50), the oldest first."""
        records = map(values.task_of, self._ask("woosh.robot.TaskHistory")["tes"])
        return sorted(records, key=lambda record: record.time)

    def task_lists(self, *, timeout: float = 5.0) -> list[values.TaskList]:
        """The task lists that are stored in the robot; the step `task_list` of a mission carries one out."""
        return values.task_lists_of(self._ask("woosh.task.TaskInfo", timeout=timeout))

    def events(self) -> list[values.RobotEvent]:
        """The last status codes (up to 50), the oldest first."""
        events = map(values.event_of, self._ask("woosh.robot.count.StatusCodes")["scs"])
        return sorted(events, key=lambda event: event.time)

    def unresolved(self) -> list[values.RobotEvent]:
        """The faults and warnings that are not over."""
        return [values.event_of(each) for each in self._ask("woosh.robot.count.AbnormalCodes")["scs"]]

    def statistics(self, days: float = 7.0) -> values.Statistics:
        """Distance, time and tasks of the last days, by the robot's clock and this computer's."""
        now = int(time.time())
        body = {"bucket": {"start": now - round(days * 86400.0), "end": now}}
        answers = [self._ask("woosh.robot.CountData", body)]
        pages = min(_MAX_PAGES, -(-answers[0]["taskQty"] // _PAGE))
        for page in range(1, pages):
            answers.append(self._ask("woosh.robot.CountData", {**body, "countType": 2, "taskPage": page}))
        return values.statistics_of(answers)

    def close(self) -> None:
        """Close the connection; the Chassis does it."""
        if self._requests is not None:
            self._requests.close()

    def _ask(
        self, request: str, body: Mapping[str, Any] | None = None, *, timeout: float = 5.0
    ) -> wire.Values:
        return self._required().ask(request, body, timeout=timeout)

    def _required(self) -> ApiRequests:
        if self._requests is None:
            raise ChassisError("the Robot API of this Chassis is switched off (robot_api=False)")
        return self._requests

    def _device_state(self) -> wire.Values | None:
        """The robot's DeviceState; None if it has the form of before 1.1.1, which says something else."""
        body = self._required().ask_raw("woosh.robot.DeviceState")
        if not isinstance(body, dict) or not body.keys() & {"hardware", "software"}:
            return None
        return self._required().loaded("woosh.robot.DeviceState", body)


def robot_api_at(
    given: str | bool | None,
    master_uri: str,
    resolve: Mapping[str, str] | None = None,
    require_free_base: Callable[[str], object] = lambda what: None,
) -> RobotApi:
    """The Robot API of the robot with this master; `given` is what `Chassis(robot_api=...)` takes.

    Raises:
        ValueError: `given` is not an address.
    """
    if given is False:
        return RobotApi(None, require_free_base)
    host = parse_uri(master_uri)[0]
    address = only_robot_api(master_uri, given) or api_address(given if isinstance(given, str) else "", host)
    return RobotApi(ApiRequests(address, HostNames(resolve, master=host, quiet=True)), require_free_base)


def requests_of(api: RobotApi) -> ApiRequests:
    """What asks the robot, without the checks of `RobotApi.request`: for motions, which know how to stop."""
    return api._required()


def request_named(name: str) -> str:
    """The request of this name, or whose last words it is.

    Raises:
        ValueError: There is none, or several.
    """
    known = wire.requests()
    found = [each for each in known if f".{each}".endswith(f".{name}")]
    if name in known or len(found) == 1:
        return name if name in known else found[0]
    words = {each.rpartition(".")[2]: each for each in known}
    near = found or [words[word] for word in near_names(name.rpartition(".")[2], words)]
    text = "{name} is not a request of the Robot API; near names: {near}"
    raise ValueError(say(text, name=name, near=near or ["none"]))
