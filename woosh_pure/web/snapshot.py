"""The robot's state as parts for JSON. Pure.

Ages are separate from the parts: a part changes only with a new report of the robot, an age always.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

from rosproto import json_values
from rosproto.sentence import say, shown
from rosproto.text import printable
from woosh_pure.faults import Faults, with_words
from woosh_pure.feed.feed import Reading
from woosh_pure.geometry import Pose2D, Velocity
from woosh_pure.language import translated
from woosh_pure.lease import LeaseState
from woosh_pure.reasons import Readiness, Reason
from woosh_pure.stopping.report import StopReport
from woosh_pure.values.state import Battery, RobotStatus

plain = partial(json_values.plain, text=printable)

_NOT_THERE = "a node of the chassis is down, or this chassis does not have it; try `woosh doctor`"
ADVICE = {
    "readiness-and-faults": "see GET readiness and GET faults",
    "readiness": "see GET readiness for what is in the way",
    "block-open": "{what} refused, nothing was sent: somebody drives by hand; wait for the end of it, or "
    "stop the robot",
    "replace": "{what} refused, nothing was sent: {goals} is under way and would be lost; wait for it or "
    'cancel it, or replace it with "replace": true',
    "stopped": "{what}: a stop came while it was being prepared; nothing was sent",
    "not-there": _NOT_THERE,
}
"""What clients of the API are told in place of advice for Python programs: by its key, a template."""
LISTENED = ("status", "pose", "velocity", "battery", "odometer", "localization", "information")
"""The feeds of the snapshot."""


NewestReadings = Mapping[str, Reading[Any] | None]
"""The newest reading of each feed, by its name."""


def text_of(document: object) -> str:
    """Return a document as JSON text. NaN and infinity become null."""
    try:
        return _encode(document)
    except ValueError:
        return _encode(plain(document))


def _encode(document: object) -> str:
    return json.dumps(document, ensure_ascii=False, allow_nan=False, separators=(",", ":"))


def ages(readings: Mapping[str, Reading[object] | None]) -> dict[str, float | None]:
    """Return the age of each feed's value in seconds; None without a value."""
    return {name: None if r is None else round(r.age, 2) for name, r in readings.items()}


def state_parts(readings: NewestReadings) -> dict[str, object]:
    """Return the parts made from feeds; None for a feed without a value."""
    value = {name: r.value for name, r in readings.items() if r is not None}
    status = value.get("status")
    return {
        "status": None if status is None else _status(status),
        "battery": _battery(value["battery"]) if "battery" in value else None,
        "velocity": _velocity(value["velocity"]) if "velocity" in value else None,
        "odometer": _rounded(value["odometer"], 2) if "odometer" in value else None,
    }


def pose_part(pose: Pose2D) -> dict[str, float] | None:
    """A pose in the map, m and rad; None if it has NaN or infinity."""
    if not all(map(math.isfinite, (pose.x, pose.y, pose.yaw))):
        return None
    return {"x": round(pose.x, 4), "y": round(pose.y, 4), "yaw": round(pose.yaw, 5)}


def _status(status: RobotStatus) -> dict[str, object]:
    return {
        "robot_state": status.robot_state.name,
        "robot_mode": status.robot_mode.name,
        "work_mode": status.work_mode.name,
        "task": {
            "id": status.task_id,
            "type": status.task_type.name,
            "state": status.task_state.name,
            "action": status.action_type.name,
            "action_state": status.action_state.name,
            "destination": printable(status.destination),
            "message": printable(status.message),
        },
    }


def _battery(battery: Battery) -> dict[str, object]:
    return {
        "percent": battery.percent,
        "charging": battery.charging,
        "voltage": _rounded(battery.voltage, 2),
        "current": _rounded(battery.current, 2),
        "temperature": battery.temperature_max,
        "cycles": battery.battery_cycles,
    }


def _velocity(velocity: Velocity) -> dict[str, float | None] | None:
    part = {name: _rounded(getattr(velocity, name), 3) for name in ("vx", "vy", "wz")}
    return None if None in part.values() else part


def _rounded(number: float, digits: int) -> float | None:
    return round(float(number), digits) + 0.0 if math.isfinite(number) else None


def readiness_part(readiness: Readiness) -> dict[str, object]:
    """Whether the robot would move ("yes", "no" or "not known"), and why not."""
    return {
        "answer": readiness.answer.value,
        "text": say(str(readiness)),
        "reasons": reasons_part(readiness.reasons),
    }


def reasons_part(reasons: Iterable[Reason]) -> list[dict[str, object]]:
    """Reasons not to move, in the order given, with the values of their sentences."""
    return [
        {
            "key": str(reason.key),
            "text": shown(say(reason.text).advised(ADVICE)),
            "values": plain(getattr(reason.text, "values", {})),
            "blocking": reason.blocking,
            "doubt": reason.doubt,
        }
        for reason in reasons
    ]


def said_part(text: str) -> dict[str, str] | None:
    """Return a text of the robot or the library in both languages, if known; None for no text."""
    if not text:
        return None
    said = with_words(text)
    words = getattr(said, "values", {}).get("words")
    if words is not None:  # a status code alone: its meaning
        return {"text": printable(words.said("en")), "text_zh": printable(words.said("zh"))}
    return {"text": "".join(printable(said)), "text_zh": printable(translated(said, "zh"))}


def faults_part(faults: Faults) -> dict[str, object]:
    """The active faults, and whether the list is complete."""
    return {
        "known": faults.known,
        "present": faults.present,
        "text": say(str(faults)),
        "active": [
            {
                "code": fault.code,
                "level": fault.level.name,
                "identifier": fault.identifier,
                "text": printable(fault.english),
                "text_zh": printable(fault.chinese),
                "derived": fault.derived,
            }
            for fault in faults
        ],
    }


def lease_part(
    state: LeaseState, *, mine: str | None = None, is_page: Callable[[str], bool] = lambda name: True
) -> dict[str, object]:
    """Return the lease for the client named `mine`; `is_page` is true for names of pages."""
    part: dict[str, object] = {
        "holder": state.holder,
        "seconds": round(state.seconds, 1),
        "asking": list(state.asking),
    }
    if mine is not None:
        part["you"] = mine
        part["yours"] = state.holder == mine
        part["holder_is_program"] = state.holder is not None and not is_page(state.holder)
    return part


def stop_part(report: StopReport) -> dict[str, object]:
    """The result of a stop. Its text has the first problem: without a master all have the same cause."""
    others = len(report.problems) - 1
    more: list[str] = [say("{count} more problems", count=others)] if others > 0 else []
    return {
        "stands_still": report.standing,
        "text": str(replace(report, problems=report.problems[:1] + more)),
        "cancelled": list(report.cancelled),
        "problems": list(report.problems),
        "pending": list(report.pending),
        "looked": report.looked,
    }


def points_part(points: Iterable[tuple[float, float]]) -> list[list[float]]:
    """Return points in m, rounded to mm, without those that have NaN or infinity."""
    return [[round(x, 3), round(y, 3)] for x, y in points if math.isfinite(x) and math.isfinite(y)]
