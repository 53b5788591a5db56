"""Record a live graph into bags, and play bags into a live graph, without decoding the messages."""

from rosproto.recording.buffer import MessageBuffer
from rosproto.recording.files import BagSeries, bag_name
from rosproto.recording.pacer import Pacer
from rosproto.recording.player import Player
from rosproto.recording.recorder import Recorder, RecorderStats, TopicSelection
from rosproto.recording.timeline import Timeline

__all__ = [
    "BagSeries",
    "MessageBuffer",
    "Pacer",
    "Player",
    "Recorder",
    "RecorderStats",
    "Timeline",
    "TopicSelection",
    "bag_name",
]
