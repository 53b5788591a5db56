"""The requests and answers of the REST API as pydantic models. They check requests, with the limits of the
library, and describe the API in /openapi.json.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypedDict, TypeVar

from pydantic import BaseModel, ConfigDict, Field, SkipValidation, model_validator

from rosproto.sentence import say
from woosh_pure.enums import Direction
from woosh_pure.geometry import MAX_COORDINATE_METRES
from woosh_pure.motion.steps import MAX_DISTANCE, MAX_SPEED, MAX_TURN_RATE

if TYPE_CHECKING:
    from pydantic.config import JsonDict
    from pydantic.fields import FieldInfo

    from woosh_pure.chassis import Chassis
    from woosh_pure.motion.action_goal import NavigationHandle, StepHandle
    from woosh_pure.motion.task import TaskHandle
    from woosh_pure.sim import SimulatedChassis

    MotionHandle = TaskHandle | NavigationHandle | StepHandle


def _number(
    unit: str,
    more: str = "",
    *,
    ge: float | None = None,
    gt: float | None = None,
    le: float,
    way: bool = False,
) -> FieldInfo:
    """A number with a unit, within pydantic's limits; a way is not 0."""
    extra: JsonDict = {"x-unit": unit, **({"not": {"const": 0}} if way else {})}
    field: FieldInfo = Field(
        ge=ge, gt=gt, le=le, allow_inf_nan=False, description=unit + more, json_schema_extra=extra
    )
    return field


OURS = "; 0 is the chassis's own"
Metres = Annotated[float, _number("m", ge=-MAX_COORDINATE_METRES, le=MAX_COORDINATE_METRES)]
Radians = Annotated[float, _number("rad", ", counter-clockwise", ge=-math.tau, le=math.tau)]
Seconds = Annotated[float, _number("s", "; without it the library's own", gt=0.0, le=86400.0)]
MarkName = Annotated[
    str,
    Field(min_length=1, max_length=200, description="as on the chassis's own map", examples=["A1"]),
]


class Request(BaseModel):
    """Base of all requests: no type is converted, and no unknown member is ignored."""

    model_config = ConfigDict(extra="forbid", strict=True)


Words = Annotated[str, SkipValidation]
"""A sentence that stays one, for a reader in another language."""


class Answer(BaseModel):
    """Base of all answers; later versions may add members."""

    model_config = ConfigDict(extra="allow")


# -- requests ------------------------------------------------------------------------------------------------


class MotionOptions(TypedDict, total=False):
    """The options of all verbs."""

    timeout: float
    replace: bool


class MotionRequest(Request):
    """What all goals accept. Each goal has `start`, which is the chassis's verb."""

    timeout: Seconds | None = None
    replace: Annotated[bool, Field(description="end what this server has under way that moves the robot")] = (
        False
    )

    @property
    def options(self) -> MotionOptions:
        """What all verbs accept."""
        options: MotionOptions = {"replace": self.replace}
        if self.timeout is not None:
            options["timeout"] = self.timeout
        return options


class AtMark(MotionRequest):
    """What all goals at a mark accept."""

    kind: str  # comes first in the description and its examples
    mark: MarkName


class MarkGoal(AtMark):
    """Drive to a mark."""

    kind: Literal["mark"]

    def start(self, chassis: Chassis) -> TaskHandle:
        return chassis.go_to_mark(self.mark, **self.options)


class ParkGoal(AtMark):
    """Drive to a mark and park there."""

    kind: Literal["park"]

    def start(self, chassis: Chassis) -> TaskHandle:
        return chassis.park(self.mark, **self.options)


class ChargeGoal(AtMark):
    """Drive to a charger and charge."""

    kind: Literal["charge"]

    def start(self, chassis: Chassis) -> TaskHandle:
        return chassis.charge(self.mark, **self.options)


class CarryGoal(AtMark):
    """Drive to a mark and load or unload there."""

    kind: Literal["carry"]
    direction: Literal["load", "unload"]

    def start(self, chassis: Chassis) -> TaskHandle:
        return chassis.carry(self.mark, Direction[self.direction.upper()], **self.options)


_HasHeading = TypeVar("_HasHeading", "Place", "MarkPlace")


def _one_heading(schema: dict[str, Any]) -> None:
    """No default is shown: a generated client would send it under both names."""
    members = schema["properties"]
    del members["yaw"]["default"], members["theta"]["default"]
    members["theta"]["deprecated"] = True
    schema["not"] = {"required": ["yaw", "theta"]}


def _take_theta(place: _HasHeading) -> _HasHeading:
    if "theta" in place.model_fields_set:
        if "yaw" in place.model_fields_set:
            raise ValueError(say("yaw and theta are the same heading: send yaw alone"))
        place.yaw = place.theta
    return place


class Place(Request):
    """A place on the map; the heading is 0 if it is left out. It was called `theta` before: both at once are
    refused.
    """

    model_config = ConfigDict(json_schema_extra=_one_heading)

    x: Metres
    y: Metres
    yaw: Radians = 0.0
    theta: Annotated[Radians, Field(exclude=True, description="now: yaw")] = 0.0

    _with_one_heading = model_validator(mode="after")(_take_theta)


class PoseGoal(MotionRequest, Place):
    """Drive to a place on the map."""

    kind: Literal["pose"]

    def start(self, chassis: Chassis) -> NavigationHandle:
        return chassis.go_to(self.x, self.y, self.yaw, **self.options)


class MoveGoal(MotionRequest):
    """Drive straight ahead, or back if negative. Obstacle avoidance stays on."""

    kind: Literal["move"]
    distance: Annotated[float, _number("m", ge=-MAX_DISTANCE, le=MAX_DISTANCE, way=True)]
    speed: Annotated[float, _number("m/s", OURS, ge=0.0, le=MAX_SPEED)] = 0.0

    def start(self, chassis: Chassis) -> StepHandle:
        return chassis.move(self.distance, speed=self.speed, **self.options)


class RotateGoal(MotionRequest):
    """Turn in place, counter-clockwise if positive. Obstacle avoidance stays on."""

    kind: Literal["rotate"]
    angle: Annotated[float, _number("rad", ", counter-clockwise", ge=-math.tau, le=math.tau, way=True)]
    speed: Annotated[float, _number("rad/s", OURS, ge=0.0, le=MAX_TURN_RATE)] = 0.0

    def start(self, chassis: Chassis) -> StepHandle:
        return chassis.rotate(self.angle, speed=self.speed, **self.options)


GoalRequest = Annotated[
    MarkGoal | ParkGoal | ChargeGoal | CarryGoal | PoseGoal | MoveGoal | RotateGoal,
    Field(discriminator="kind"),
]


_NO_PLACE = {"properties": {name: {"type": "null"} for name in ("x", "y", "yaw", "theta")}}
_X_AND_Y = {"properties": {name: {"type": "number"} for name in ("x", "y")}, "required": ["x", "y"]}


def _one_place(schema: dict[str, Any]) -> None:
    """Either `here`, or x and y with or without a heading, or none of them."""
    _one_heading(schema)
    schema["if"] = {"properties": {"here": {"const": True}}, "required": ["here"]}
    schema["then"] = _NO_PLACE
    schema["else"] = {"if": {"properties": {"x": {"type": "number"}}, "required": ["x"]}, "then": _X_AND_Y}
    schema["else"]["else"] = _NO_PLACE


def _some_place(schema: dict[str, Any]) -> None:
    """As `_one_place`; without any, the mark is one of the chassis's own map."""
    _one_place(schema)
    on_chassis = {"on_chassis": {"const": True}}
    properties = {**_NO_PLACE["properties"], **on_chassis}
    schema["else"]["else"] = {"properties": properties, "required": [*on_chassis]}


class MarkPlace(Request):
    """Where a mark is: where the robot stands now, or at x and y in the map."""

    model_config = ConfigDict(json_schema_extra=_one_place)

    here: Annotated[bool, Field(description="where the robot stands now")] = False
    x: Metres | None = None
    y: Metres | None = None
    yaw: Radians | None = None
    theta: Annotated[Radians | None, Field(exclude=True, description="now: yaw")] = None

    _with_one_heading = model_validator(mode="after")(_take_theta)


_SHOWN = r"\p{L}\p{M}\p{N}\p{P}\p{S}"  # what `rosproto.text.printable` leaves as it is, and not blank
NewName = Annotated[
    str,
    Field(
        min_length=1,
        max_length=100,
        description="printable characters; leading and trailing blanks are removed",
        json_schema_extra={"pattern": rf"^[{_SHOWN}\p{{Zs}}]*[{_SHOWN}][{_SHOWN}\p{{Zs}}]*$"},
    ),
]
Note = Annotated[str, Field(max_length=200)]
_ON_CHASSIS = Field(description="the chassis's own map has a mark of this name; else it is a place")


class MarkRequest(MarkPlace):
    """A mark to save. A place of the list needs a pose; a mark of the chassis's own map may have one."""

    model_config = ConfigDict(json_schema_extra=_some_place)

    name: NewName
    note: Note = ""
    charger: bool = False
    on_chassis: Annotated[bool, _ON_CHASSIS] = False


class MarkChange(MarkPlace):
    """What becomes of a mark; what is left out stays."""

    name: NewName | None = None
    note: Note | None = None
    charger: bool | None = None
    on_chassis: Annotated[bool | None, _ON_CHASSIS] = None


class PoseRequest(Place):
    """Where the robot stands, in the map."""


class SwitchMapRequest(Request):
    """Which of its maps the robot is to use; without `map` it chooses one of the scene."""

    scene: Annotated[str, Field(min_length=1, max_length=200)]
    map: Annotated[str, Field(max_length=200)] = ""


class StopRequest(Request):
    """What a stop includes."""

    everything: Annotated[bool, Field(description="also goals and tasks that others have started")] = True


class LeaseRequest(Request):
    """How long the lease is wanted for, and whether it is taken from a program that was asked before."""

    seconds: Annotated[float, _number("s", gt=0.0, le=3600.0)] = 60.0
    take_over: Annotated[bool, Field(description="only from a program, and only after having asked")] = False


class GrantRequest(Request):
    """Who gets the lease: one of those who have asked for it; by default the first of them."""

    to: Annotated[str, Field(min_length=1, max_length=200)] | None = None


class RecordingRequest(Request):
    """How long to record, and whether with pictures."""

    seconds: Annotated[float, _number("s", gt=0.0, le=3600.0)] | None = None
    camera: Annotated[bool, Field(description="also images and point clouds: much data")] = False


SimulatorEvent = Literal[
    "reset", "press_emergency_stop", "release_emergency_stop", "lose_localization", "remove_obstacles"
]
"""Methods of `SimulatedChassis`."""


class SimulatorRequest(Request):
    """What happens to a simulated robot. Members that are left out change nothing."""

    do: SimulatorEvent | None = None
    speed: Annotated[float, _number("simulated seconds per second", ge=0.0, le=100.0)] | None = None
    battery: Annotated[float, _number("%", ge=0.0, le=100.0)] | None = None
    teleport: Place | None = None
    obstacle: Annotated[Place | None, Field(description="one more, round, 0.25 m in radius")] = None

    def apply(self, sim: SimulatedChassis) -> None:
        """Do what is given, in the order of the members."""
        if self.do is not None:
            getattr(sim, self.do)()
        if self.speed is not None:
            sim.speed = self.speed
        if self.battery is not None:
            sim.set_battery(self.battery)
        if self.teleport is not None:
            sim.teleport(self.teleport.x, self.teleport.y, self.teleport.yaw)
        if self.obstacle is not None:
            sim.add_obstacle(self.obstacle.x, self.obstacle.y)


class LoginRequest(Request):
    """The token that the server was started with."""

    token: Annotated[str, Field(max_length=1000)]


class QrRequest(Request):
    """What a QR code contains."""

    text: Annotated[str, Field(min_length=1, max_length=1000)]


# -- answers -------------------------------------------------------------------------------------------------


class Reason(Answer):
    """One reason not to move; `key` and `values` are for programs that have words of their own."""

    key: str
    text: Words
    values: dict[str, object]
    blocking: bool
    doubt: bool


class MapPoint(Answer):
    """x and y in m, in the map."""

    x: float
    y: float


class Said(Answer):
    """A sentence in English and in Chinese."""

    text: str
    text_zh: str


class ProblemDocument(Answer):
    """A problem by RFC 9457; `detail` is the library's sentence."""

    type: str
    title: str
    status: int
    detail: str
    instance: str


class Goal(Answer):
    """A goal. `arrived` is true only on success; `stands_still` is null if it is not known."""

    id: str
    kind: str
    who: Words
    description: str
    begun: float
    state: str
    done: bool
    arrived: bool | None
    progress: str
    percent: Annotated[float | None, Field(description="done part of the way, or of the steps, in %")]
    metres_left: float | None
    pose: Pose | None
    stands_still: bool | None
    text: str
    seconds: float
    can_pause: bool
    key: Annotated[str, Field(description="what was requested; `values` are in m and rad")]
    values: dict[str, object]
    start: MapPoint | None
    target: MapPoint | None
    reasons: Annotated[list[Reason], Field(description="what spoke against moving when it had failed")]
    said: Annotated[Said | None, Field(description="the robot's own words of how it ended")]


class StopAnswer(Answer):
    """Whether the robot stands still, what was cancelled, and what could not be done."""

    stands_still: bool | None
    text: str
    cancelled: list[str]
    problems: list[str]
    pending: Annotated[list[str], Field(description="asked again every second, until it is seen to end")]
    looked: Annotated[bool, Field(description="goals and tasks of others were looked for, too")]


_Theta = Field(description="the same as yaw", json_schema_extra={"deprecated": True})


class Heading(Answer):
    """An answer with a heading; it is sent under its old name, too."""

    @model_validator(mode="before")
    @classmethod
    def _both_names(cls, value: object) -> object:
        if isinstance(value, dict):
            yaw = value.get("yaw")
            return {**value, "yaw": yaw, "theta": yaw}
        return value


class Pose(Heading):
    """x and y in m, yaw in rad, in the map."""

    x: float
    y: float
    yaw: float
    theta: Annotated[float, _Theta]


class Readiness(Answer):
    """Whether the robot would move now: yes, no, or not known."""

    answer: Literal["yes", "no", "not known"]
    text: str
    reasons: list[Reason]


class Fault(Answer):
    """An active fault."""

    code: int
    level: str
    identifier: str
    text: str
    text_zh: str


class Faults(Answer):
    """The active faults. `known` tells whether the list is complete."""

    known: bool
    present: bool | None
    text: str
    active: list[Fault]


class Mark(Heading):
    """A mark; x, y and yaw are null if its pose is not known. To a place that is not on the chassis's own
    map (`on_chassis` is false), a goal of kind `mark` goes by its pose.
    """

    name: str
    x: float | None
    y: float | None
    yaw: float | None
    theta: Annotated[float | None, _Theta]
    charger: bool
    note: str
    on_chassis: bool
    source: Annotated[Literal["list", "robot"], Field(description="robot: named by itself, read only")]


class Zone(Answer):
    """An area of the robot's map with rules of its own."""

    kind: str
    max_speed: Annotated[float | None, Field(description="m/s; null without a limit of its own")]
    points: list[list[float]]


class SceneEntry(Answer):
    """A scene of the robot: one or more maps."""

    name: str
    maps: list[str]


class Scenes(Answer):
    """The robot's maps: the one in use and its zones, and all that it has. Empty without a Robot API."""

    scene: str | None
    map: str | None
    scenes: list[SceneEntry]
    zones: list[Zone]


class SwitchedMap(Answer):
    """The map in use after a switch. `localised` is null if the robot does not say."""

    scene: str
    map: str
    localised: bool | None


class MapFacts(Answer):
    """Size, resolution and origin of the map; the origin is the lower left corner."""

    version: str
    width: int
    height: int
    resolution: float
    origin: Pose


class Points(Answer):
    """Points as [x, y] in m, in the map."""

    points: list[list[float]]


class Feed(Answer):
    """A feed of the chassis."""

    name: str
    topic: str
    type: str
    meaning: str
    unit: str
    on_change: bool


class FeedValue(Answer):
    """The newest value of a feed; value and age are null if nothing was heard."""

    name: str
    value: object
    age: float | None
    stamp: float | None


class Entry(Answer):
    """An entry of the journal."""

    id: Annotated[int, Field(description="grows by one with each entry")]
    at: Annotated[float, Field(description="when it began, s since 1970; `ended` is null before its end")]
    who: Words
    what: Words
    state: Annotated[str, Field(description="`under way`, or how it ended: `arrived`, `refused`, `done` ...")]
    text: Words
    ended: float | None
    goal: Annotated[str, Field(description="id of the goal that the entry is about, or empty")]
    key: Annotated[str, Field(description="what was asked for; `values` are in m and rad")]
    values: dict[str, object]
    reasons: Annotated[list[Reason], Field(description="what spoke against moving when it had failed")]
    said: Annotated[Said | None, Field(description="the robot's own words of how it ended")]


class Recording(Answer):
    """A recorded bag."""

    id: str
    who: Words
    name: str
    begun: float
    running: bool
    end: Annotated[
        Literal["", "asked", "limit", "no-room", "not-written"],
        Field(
            description="why it ended: by request, at its longest time or size, for want of disk, by an error"
        ),
    ]
    seconds: Annotated[float, Field(description="how long it is, or was")]
    bytes: int
    messages: int
    error: str


class LeaseAnswer(Answer):
    """Who commands the robot."""

    holder: str | None
    seconds: float
    asking: list[str]
    you: str
    yours: bool
    holder_is_program: bool


Activity = Annotated[
    str | None,
    Field(description="`driven` by hand, `under way` (a goal of anybody), or else the robot's own state"),
]


class Snapshot(Answer):
    """The whole state at once; a part is null if nothing was heard of it."""

    robot: str
    time: float
    activity: Activity
    status: dict[str, object] | None
    battery: dict[str, object] | None
    velocity: dict[str, object] | None
    odometer: float | None
    pose: Pose | None
    readiness: Readiness
    faults: Faults
    goals: list[Goal]
    lease: dict[str, object]
    driver: str | None
    ages: dict[str, float | None]


class Status(Answer):
    """The state in brief."""

    robot: str
    state: str | None
    activity: Activity
    battery_percent: int | None
    pose: Pose | None
    ready: Literal["yes", "no", "not known"]
    text: str
    age: float | None


class RobotEntry(Answer):
    """A robot of this server."""

    name: str
    page: str
    api: str


class AccessAnswer(Answer):
    """Whether a token is needed, and what this client may do."""

    needs_token: bool
    logged_in: bool
    allow_driving: bool
    robots: list[str]
