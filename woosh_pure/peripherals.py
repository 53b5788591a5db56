"""Lights, voice, footprint, costmaps, maps, plans, localisation: neither readings nor motion."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from typing import Any, Literal

from rosproto.coercion import as_float, whole
from rosproto.errors import RosTimeout
from rosproto.sentence import advice, both, hint, say
from woosh_pure.components import Components
from woosh_pure.enums import COLOURS, LedState, NavDirection, NavigationMode
from woosh_pure.errors import ChassisError, StaleState
from woosh_pure.geometry import Footprint, Pose2D
from woosh_pure.hints import COLOUR_WORDS, meant
from woosh_pure.interface.table import row
from woosh_pure.maps.gridmap import GridMap, grid_from_message, grid_message
from woosh_pure.motion.action_goal import ActionHandle, ActionMotion
from woosh_pure.motion.steps import MAX_SPEED
from woosh_pure.values.messages import (
    as_pose,
    message_type,
    polygon,
    pose_of,
    pose_with_covariance,
    stamped_pose,
)

_STRIPS = {"base": ("/rgbled",), "shelf": ("/rgbled_shelf", "/kShelfLedColorPubName")}
_FOOTPRINTS = {
    "local": "/move_base/local_costmap/set_footprint",
    "global": "/move_base/global_costmap/set_footprint",
}


class Peripherals:
    """The part of `Chassis` for devices on the robot, maps and localisation; needs no permission to move."""

    _components: Components

    # -- light and voice -------------------------------------------------------------------------------------

    def light(
        self,
        state: LedState | str = LedState.NONE,
        *,
        color: int | str | Sequence[int] | None = None,
        strip: str = "base",
        module: int = 0,
        urgency: bool = False,
        abnormal: bool = False,
    ) -> None:
        """Set a light strip: `/rgbled`, or `/rgbled_shelf` and `/kShelfLedColorPubName`.

        Args:
            state: A named state of the strip, or a colour: "red", "task-paused".
            color: 24-bit RGB, (red, green, blue) with 0 to 255 each, "ff8000", or a name of `COLOURS`.
            strip: "base", "shelf" or "both".
            module: 0 all, 1 to 8 one module.
            urgency: Show "under maintenance".
            abnormal: Show "fault".

        Raises:
            ValueError: A number is out of range.
            FirmwareLimit: The chassis's definition has no field for one of the values; nothing was sent.
            RosTimeout: The chassis has no such strip.
        """
        state, rgb = light_of(state, color, module)
        if strip not in (*_STRIPS, "both"):
            raise ValueError(
                say('strip {strip!r} is not known; expected "base", "shelf" or "both"', strip=strip)
            )
        message = message_type("woosh_msgs/LED")()
        message.submodule, message.normal, message.color = module, int(state), rgb or 0
        message.urgency, message.abnormal = 0xFF * urgency, 0xFF * abnormal
        for name in _STRIPS if strip == "both" else (strip,):
            self._send_to_any(_STRIPS[name], "woosh_msgs/LED", message)

    def _send_to_any(self, topics: Sequence[str], type_name: str, message: Any) -> None:
        """Send on those spellings of a topic that have a subscriber."""
        clients = self._components.clients
        publishers = [clients.publisher(topic, type_name) for topic in topics]
        clients.wait_any(publishers, self._components.connection.timeout)
        for publisher in [each for each in publishers if each.connections]:
            clients.deliver(publisher, message)

    def say(self, text: str) -> None:
        """Let the chassis speak (`/voice_synthesis`; not every chassis has it).

        Args:
            text: The text to speak.

        Raises:
            RosTimeout: This chassis has no voice.
            CodecError: `text` is not a string.
        """
        message = message_type("std_msgs/String")(data=text)
        self._components.clients.send("/voice_synthesis", message)

    # -- footprint -------------------------------------------------------------------------------------------

    def set_footprint(
        self,
        footprint: Footprint | Iterable[Sequence[float]],
        *,
        padding: float = 0.0,
        local: bool = True,
        global_: bool = True,
    ) -> Footprint:
        """Tell the navigation the robot's outline, for example with a load on it.

        It is sent to `/move_base/local_costmap/set_footprint` and `/move_base/global_costmap/set_footprint`.
        The vendor recommends changing both together, and by default this changes both or none.

        Args:
            footprint: A `Footprint`, or corners (x, y) in m in base_link.
            padding: m added on all sides.
            local: Whether to set it for the local costmap.
            global_: Whether to set it for the global costmap.

        Returns:
            The outline that was sent.

        Raises:
            ValueError: Not a simple polygon around the robot's centre.
            RosTimeout: The navigation does not subscribe to it.
        """
        corners = footprint.points if isinstance(footprint, Footprint) else footprint
        outline = Footprint.from_points(corners, padding)
        message = polygon(outline)
        wanted = {"local": local, "global": global_}
        topics = [_FOOTPRINTS[name] for name, chosen in wanted.items() if chosen]
        if not topics:
            raise ValueError("neither the local nor the global costmap is chosen: nothing would be sent")
        for topic in topics:  # both or none: the two must agree
            self._components.clients.connect(topic, type(message))
        for topic in topics:
            self._components.clients.send(topic, message)
        return outline

    # -- costmaps and maps -----------------------------------------------------------------------------------

    def enable_costmaps(self, on: bool = True) -> None:
        """Let obstacles enter the costmaps, or keep them out (`/move_base/enable_costmaps`).

        Args:
            on: False keeps obstacles out: the navigation drives as if there were none.

        Raises:
            ChassisError: The chassis refused.
            ServiceError, RosTimeout: There is no such service, or no answer in time.
        """
        _require_success(
            self._components.clients.call("/move_base/enable_costmaps", data=on), "enable_costmaps"
        )

    def clear_costmaps(self) -> None:
        """Remove all obstacles from the costmaps (`/move_base/clear_costmaps`); visible ones are added again.

        Raises:
            ServiceError, RosTimeout: There is no such service, or no answer in time.
        """
        self._components.clients.call("/move_base/clear_costmaps")

    def get_map(self) -> GridMap:
        """The current map (`/aic_map_server/get_map`) as numpy; `.save("x.yaml")` writes map_server's files.

        Returns:
            Cells as (height, width) int8, m per cell, and the origin in the map.

        Raises:
            ServiceError, RosTimeout: There is no such service, or no answer within 30 s.
            ValueError: The reply is not a map.
        """
        return grid_from_message(self._components.clients.call("/aic_map_server/get_map", timeout=30.0).map)

    def set_map(self, grid: GridMap, initial_pose: Pose2D | None = None) -> None:
        """Replace the map (`/set_map`).

        Args:
            grid: The new map, for example from `GridMap.load("x.yaml")`; m per cell.
            initial_pose: Where the robot is in this map, m and rad; None is the zero pose, which the vendor
                prescribes for initialisation.

        Raises:
            ChassisError: The chassis refused.
            ValueError: A number of the pose is not finite.
            ServiceError, RosTimeout: There is no such service, or no answer within 30 s.
        """
        if not hasattr(grid, "cells"):
            wrong = "{name} is not a map; give a GridMap, for example of GridMap.load(...)"
            raise TypeError(say(wrong, name=type(grid).__name__))
        pose = pose_with_covariance(
            initial_pose or Pose2D(0.0, 0.0), position_deviation=0.25, yaw_deviation=0.26
        )
        reply = self._components.clients.call(
            "/set_map", timeout=30.0, map=grid_message(grid), initial_pose=pose
        )
        _require_success(reply, "set_map")

    def plan(self, goal: Pose2D, start: Pose2D | None = None, *, tolerance: float = 0.0) -> list[Pose2D]:
        """Plan a path without driving it (`/move_base/make_plan`).

        Args:
            goal: In the map, m and rad.
            start: In the map; None is where the robot is.
            tolerance: How far from a blocked goal the path may end, m; this becomes position error.

        Returns:
            The way points; empty when there is no path.

        Raises:
            StaleState: `start` was not given, and the robot's pose is not known.
            ValueError: A number is not finite, or `tolerance` is not 0 to 5 m.
            ServiceError, RosTimeout: There is no such service, or no answer within 30 s.
        """
        tolerance = as_float(tolerance)
        if not (math.isfinite(tolerance) and 0.0 <= tolerance <= 5.0):
            wrong = "tolerance {tolerance} m: expected 0 to 5, and small: it becomes position error"
            raise ValueError(say(wrong, tolerance=tolerance))
        begin, target = stamped_pose(self._current_pose() if start is None else start), stamped_pose(goal)
        reply = self._components.clients.call(
            "/move_base/make_plan",
            timeout=30.0,
            start=begin,
            goal=target,
            tolerance=tolerance,
        )
        return [
            pose_of(p.pose, p.header.frame_id or reply.plan.header.frame_id or "map")
            for p in reply.plan.poses
        ]

    def _current_pose(self) -> Pose2D:
        feed = self._components.feeds.get("pose")
        try:
            pose: Pose2D = feed.wait(self._components.connection.timeout, new=False)
        except RosTimeout as error:
            raise StaleState(
                advice(
                    "the pose is not known ({topic} is silent); give start=", key="start", topic=feed.topic
                ),
                topic=feed.topic,
            ) from error
        return pose

    # -- navigation mode -------------------------------------------------------------------------------------

    def set_navigation_mode(
        self,
        mode: NavigationMode,
        *,
        waiting_timeout: float | None = None,
        max_speed: float = 0.0,
        passage_id: int = 0,
        permitted_passage: bool = False,
        capacity: int = 0,
        direction: NavDirection = NavDirection.CHASSIS_DECIDES,
        timeout: float = 10.0,
    ) -> None:
        """Set the obstacle avoidance and the speed of the navigation (`/navigation_mode` action).

        Args:
            mode: See `NavigationMode`.
            waiting_timeout: Seconds to wait before driving around, 0 or more; must be given for
                WAIT_THEN_AVOID. What 0 means is not certain: the vendor's page allows it, the message's
                definition says that the chassis takes PRECISE_AVOIDANCE then.
            max_speed: m/s; 0 keeps the configured speed.
            passage_id: The passage concerned.
            permitted_passage: Whether a changed path may be followed.
            capacity: Number of vehicles in the passage.
            direction: Which way round to drive.
            timeout: How long the chassis may take to confirm, s.

        Raises:
            ValueError: A number contradicts the mode, is not finite, or is too large to be in this unit.
            GoalFailed: The chassis did not accept it.
        """
        mode, direction = NavigationMode(mode), NavDirection(direction)
        if mode is NavigationMode.WAIT_THEN_AVOID and waiting_timeout is None:
            raise ValueError(say("WAIT_THEN_AVOID needs waiting_timeout=, in seconds"))
        waiting_timeout = as_float(0.0 if waiting_timeout is None else waiting_timeout)
        max_speed = as_float(max_speed)
        if not (mode.known and direction.known):
            wrong = "mode {mode}, direction {direction}: expected 0 to 3 each"
            raise ValueError(say(wrong, mode=int(mode), direction=int(direction)))
        if max_speed > MAX_SPEED:
            wrong = "max_speed={max_speed:g}: more than {maximum:g} m/s; is it in another unit?"
            raise ValueError(say(wrong, max_speed=max_speed, maximum=MAX_SPEED))
        for name, value in (("waiting_timeout", waiting_timeout), ("max_speed", max_speed)):
            if not (math.isfinite(value) and value >= 0.0):
                raise ValueError(
                    say("{name}={value}: must be a number of at least 0", name=name, value=value)
                )
        goal = message_type("woosh_msgs/NavigationModeGoal")()
        goal.id, goal.navigation_mode, goal.waiting_timeout = passage_id, int(mode), waiting_timeout
        goal.max_speed, goal.permitted_passage = max_speed, permitted_passage
        goal.capacity, goal.nav_dir = capacity, int(direction)
        self._run_action("/navigation_mode", goal, f"navigation mode {mode}", timeout)

    def _run_action(self, name: str, goal: Any, text: str, timeout: float) -> Any:
        motion = ActionMotion(self._components, name, text)
        handle = ActionHandle(motion, timeout)
        motion.begin(goal)
        handle.wait(timeout)
        return handle.result

    # -- where the robot is ----------------------------------------------------------------------------------

    def set_pose(
        self,
        pose: Pose2D,
        *,
        position_deviation: float = 0.25,
        yaw_deviation: float = 0.26,
        via: Literal["topic", "service"] = "topic",
        service: str | None = None,
    ) -> None:
        """Tell the localisation where the robot stands (`/initialpose`), after power-up for example.

        `readiness()`, `faults` and `/status_code` show whether the localisation has succeeded.

        Args:
            pose: In the map, m and rad.
            position_deviation: Uncertainty, 1 sigma, m.
            yaw_deviation: 1 sigma, rad.
            via: "topic" sends to `/initialpose`. "service" calls the chassis's service of type
                woosh_msgs/InitPose, which answers; its name is not documented (the simulator has it at
                `/init_pose`, a name of ours), so it is found by its type, and not every chassis has it.
            service: Name of that service, where you know it: it is called without a search.

        Raises:
            ValueError: A number is not finite, a deviation is not positive, or the pose is not in the map.
            RosTimeout: `/initialpose` has no subscriber.
            ChassisError: This chassis has no such service, or several, or it refused.
        """
        if as_pose(pose).frame.lstrip("/") != "map":
            raise ValueError(
                say("the pose is in {frame!r}; the localisation needs a pose in the map", frame=pose.frame)
            )
        if via not in ("topic", "service"):
            raise ValueError(say('via={via!r}: expected "topic" or "service"', via=via))
        message = pose_with_covariance(
            pose, position_deviation=position_deviation, yaw_deviation=yaw_deviation
        )
        if via == "topic":
            self._components.clients.send("/initialpose", message)
        else:
            self._call_by_type("/init_pose", service=service, initial_pose=message)

    def initialise(self, *, timeout: float = 30.0, service: str | None = None) -> None:
        """Initialise the robot: the chassis's service of type woosh_msgs/WooshInit.

        Its name is not documented (the simulator has it at `/woosh_init`, a name of ours), so it is found by
        its type; what a real chassis does then is not documented either. It takes no values: no units, no
        frame.

        Args:
            timeout: Seconds for the answer.
            service: Name of the service, where you know it: it is called without a search.

        Raises:
            ChassisError: This chassis has no such service, or several, or it refused.
            RosTimeout: No answer in time.
        """
        self._call_by_type("/woosh_init", timeout, service)

    def start_localization(self, on: bool = True) -> None:
        """Start the localisation module, or stop it (`/start_localization`).

        Args:
            on: False stops it. No units, no frame.

        Raises:
            ChassisError: The chassis refused.
            ServiceError: This chassis has no such service.
            RosTimeout: No answer in time.
        """
        _require_success(self._components.clients.call("/start_localization", data=on), "start_localization")

    def _call_by_type(
        self, name: str, timeout: float | None = None, service: str | None = None, **fields: Any
    ) -> None:
        type_name = row(name).type
        found = self._components.clients.services_of_type(type_name) if service is None else [service]
        if not found:
            raise ChassisError(
                say(
                    "this chassis offers no service of type {type_name}; give its position with "
                    'set_pose(..., via="topic"), or initialise it at its own display',
                    type_name=type_name,
                )
            )
        if len(found) > 1:
            raise ChassisError(
                say(
                    "this chassis offers several services of type {type_name}: {names}; say which, with "
                    "service=",
                    type_name=type_name,
                    names=", ".join(found),
                )
            )
        reply = self._components.clients.call_found(found[0], type_name, timeout=timeout, **fields)
        _require_success(reply, f"{found[0]} ({type_name})")


def light_of(
    state: LedState | str, color: int | str | Sequence[int] | None, module: int
) -> tuple[LedState, int | None]:
    """Return the named state and the colour, 24-bit RGB, of `Peripherals.light`; None for no colour.

    Raises:
        ValueError: A name is not known, or a number is out of range.
    """
    if not 0 <= module <= 8:
        raise ValueError(say("module {module}: expected 0 for all, or 1 to 8", module=module))
    if isinstance(state, str):
        if color is None and state.lower() in COLOURS:
            state, color = "none", state
        words = {name.lower().replace("_", "-"): one for name, one in LedState.__members__.items()}
        named = words.get(state.lower().replace("_", "-"))
        if named is None:
            unknown = say("state {state!r} is not known", state=state)
            near = hint(meant(COLOUR_WORDS, state) or state, [*words, *COLOURS])
            raise ValueError(both(unknown, *near, say("one of: {names}", names=[*words, *COLOURS])))
        state = named
    return state, None if color is None else _rgb(color)


def _rgb(color: int | str | Sequence[int]) -> int:
    if isinstance(color, str):
        text = color.lower()
        if text not in COLOURS and not re.fullmatch("#?[0-9a-f]{6}", text):
            wrong = "color {text}: expected six hexadecimal digits RRGGBB, or {names}"
            raise ValueError(say(wrong, text=color, names=list(COLOURS)))
        return COLOURS[text] if text in COLOURS else int(text.lstrip("#"), 16)
    number = whole(color)
    if number is not None:
        if not 0 <= number <= 0xFFFFFF:
            raise ValueError(say("color {color:#x}: expected 24-bit RGB, 0 to 0xFFFFFF", color=number))
        return number
    given = tuple(color) if isinstance(color, Iterable) else ()
    parts = [part for part in map(whole, given) if part is not None and 0 <= part <= 255]
    if len(parts) != 3 or len(given) != 3:
        raise ValueError(
            say(
                "color {color!r}: expected (red, green, blue) with whole numbers of 0 to 255 each",
                color=color,
            )
        )
    return (parts[0] << 16) | (parts[1] << 8) | parts[2]


def _require_success(reply: Any, what: str) -> None:
    """Check that a reply has `success: true`.

    Raises:
        ChassisError: With the chassis's own words.
    """
    if not reply.success:
        wrong = "{what}: the chassis refused: {why}"
        raise ChassisError(say(wrong, what=what, why=say(getattr(reply, "message", "") or "no reason given")))
