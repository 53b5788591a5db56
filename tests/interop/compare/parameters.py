"""rosparam: load, set, get, list, delete and dump, by the command and by the functions of the module."""

from __future__ import annotations

import random

import yaml

from rosproto.node import MasterClient
from tests.interop.compare import yaml_texts
from tests.interop.compare.asked import plain
from tests.interop.compare.comparison import Answer, Case, Kind, Peer, environment, run_command

NAMES = ["/", "/a", "a", "b", "/a/b", "/c/d/", "speed", "a/b", "/robot", "/robot/a", "/nosuch", "x1"]
BEFORE = {
    "a": {"b": 1, "c": {"speed": 2.5}},
    "speed": "fast",
    "robot": {"a": 7, "b": {"x1": True}},
    "b": [1, 2],
}


def space(chance: random.Random) -> str:
    """A namespace for $ROS_NAMESPACE."""
    return chance.choice(["", "", "/robot", "robot", "/robot/"])


class RosparamCommand(Kind):
    """`rosparam` beside `rosproto param`."""

    asked = "rosparam_command"

    def __init__(self, master_uri: str, peer: Peer) -> None:
        self._master_uri = master_uri
        self.peer = (
            peer  # rosparam changes PyYAML's loader for its process: deg(90) is a number everywhere then
        )

    def draw(self, chance: random.Random) -> Case:
        steps = [self._step(chance) for _ in range(chance.choice([1, 1, 1, 2, 3]))]
        return {"namespace": space(chance) or "/", "before": BEFORE, "steps": steps}

    def _step(self, chance: random.Random) -> Case:
        name = chance.choice(NAMES)
        kind = chance.choice(["load", "load", "set", "set", "get", "get", "dump", "list", "delete"])
        stdin = ""
        if kind == "load":
            stdin = yaml_texts.document(chance)
            words = ["-", *([name] if chance.random() < 0.7 else [])]
        elif kind == "set":
            words = [name, yaml_texts.flow(chance)]
        elif kind == "get":
            words = [*(["-p"] if chance.random() < 0.3 else []), name]
        elif kind == "list":
            words = [name] if chance.random() < 0.7 else []
        else:
            words = [name] if kind == "delete" else []
        return {"words": [kind, *words], "stdin": stdin}

    def ours(self, case: Case) -> Answer:
        with MasterClient(self._master_uri, "/test") as master:
            master.set_param("/", case["before"])
            steps = []
            with environment(ROS_NAMESPACE=case["namespace"], ROS_MASTER_URI=self._master_uri):
                for step in case["steps"]:
                    answer = run_command("param", *step["words"], stdin=step["stdin"])
                    steps.append(
                        {key: answer[key] for key in ("out", "error", "code", "says") if key in answer}
                    )
            return {"steps": steps, "tree": plain(master.get_param("/"))}

    def same(self, theirs: Answer, ours: Answer) -> bool:
        """Printed values are compared as YAML: we quote some texts that rosparam does not."""
        return super().same(_read(theirs), _read(ours))


def _read(answer: Answer) -> Answer:
    return {**answer, "steps": [_read_step(step) for step in answer["steps"]]}


def _read_step(step: Answer) -> Answer:
    try:
        return {"out": plain(yaml.load(step["out"], yaml.SafeLoader))} if "out" in step else step
    except yaml.YAMLError:
        return step


class RosparamFunctions(Kind):
    """The functions of the module, in both layers."""

    asked = "rosparam_functions"

    def __init__(self, layer: Peer, peer: Peer) -> None:
        self._layer = layer
        self.peer = peer

    def draw(self, chance: random.Random) -> Case:
        steps = [self._step(chance) for _ in range(chance.choice([1, 1, 1, 2, 3]))]
        return {"namespace": space(chance) or "/", "before": BEFORE, "steps": steps}

    def _step(self, chance: random.Random) -> Case:
        name = chance.choice([name for name in NAMES if name.startswith("/")])
        kind = chance.choice(
            ["load", "load", "set_param", "get_param", "list_params", "delete_param", "load_str"]
        )
        if kind in ("load", "load_str"):
            text = yaml_texts.document(chance)
            return [kind, [text, name] if kind == "load" else [text, "file"]]
        return [kind, [name, yaml_texts.flow(chance)] if kind == "set_param" else [name]]

    def ours(self, case: Case) -> Answer:
        return self._layer.ask(self.asked, case)
