"""Recording a live graph into bags, and playing bags to it."""

from rosproto.recording.player import Player
from rosproto.recording.recorder import Recorder

__all__ = ["Player", "Recorder"]
