"""Missions: named lists of steps in `*.mission.toml` files, their queue, and their runs over a `Chassis`."""

from woosh_pure.missions.file import StoredMission, parse, text_of
from woosh_pure.missions.machine import Entry, Notice, Phase, Question, Run, State
from woosh_pure.missions.mission import KINDS, STEP_KEYS, Mission, MissionError, Step, mission_of
from woosh_pure.missions.missions import MissionFailed, MissionHandle, Missions

__all__ = [
    "KINDS", "STEP_KEYS", "Entry", "Mission", "MissionError", "MissionFailed", "MissionHandle", "Missions",
    "Notice", "Phase", "Question", "Run", "State", "Step", "StoredMission", "mission_of",
    "parse", "text_of",
]  # fmt: skip
