"""Kill a program at a random moment of its mission, and let another one go on with it.

`python -m tests.support.mission_kills 50` does so until 50 kills have met a running mission, and prints the seed; `--seed`
repeats it.
"""

from __future__ import annotations

import argparse
import os
import random
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from tests.support.waiting import until
from woosh_pure import Chassis, SimulatedChassis
from woosh_pure.missions import Missions, Phase, parse

ROOT = Path(__file__).resolve().parents[2]
STEPS = 6
MAX_SECONDS = 0.8
"""For which the mission is under way here; a kill comes at a random moment of them."""
AFTER = "after its end"
STEP = '[[step]]\ndo = "move"\nmetres = 0.1\n[[step]]\ndo = "wait"\nseconds = 0.05\n'
TEXT = 'mission = 1\nname = "killed"\n' + STEP * (STEPS // 2)
PROGRAM = """
import sys
from woosh_pure import Chassis
from woosh_pure.missions import Missions
with Chassis(sys.argv[1]) as chassis:
    missions = Missions(chassis, sys.argv[2])
    handle = missions.run(sys.argv[3])
    print("begun", flush=True)
    handle.wait(60)
    missions.close()
"""


def kill_once(sim: SimulatedChassis, folder: Path, seconds: float) -> str:
    """Kill it after some seconds, resume, and check what must hold; return where it was."""
    file = folder / "killed.mission.toml"
    file.write_text(TEXT)
    sim.teleport(0.0, 0.0, 0.0)
    words = [sys.executable, "-c", PROGRAM, sim.master_uri, str(folder), str(file)]
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True, cwd=ROOT, env={**os.environ}) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "begun\n"
        time.sleep(seconds)  # the random moment
        process.kill()
        process.wait(10)
    with Chassis(sim.master_uri) as chassis:
        missions = Missions(chassis, folder)
        before = missions.state.run
        assert before is not None
        if before.phase.over:
            assert before.phase is Phase.DONE
            return AFTER
        until(
            lambda: chassis.measured_velocity.wait(5.0).is_standing(), what="the step of the killed program"
        )
        pose = sim.pose
        missions.pause(by="a look")  # opens the state, and moves nothing
        run = missions.state.run
        assert run is not None
        assert run.phase is Phase.INTERRUPTED
        until(lambda: not missions.state.run or missions.state.run.phase is Phase.INTERRUPTED, 1.0)
        assert sim.pose.distance_to(pose) < 0.005, "it moved before anybody said so"
        missions.resume(by="a person")

        def asked() -> bool:
            now = missions.state.run
            assert now is not None
            return now.question is not None or now.phase.over

        missions.wait_for(asked, 30.0)
        now = missions.state.run
        assert now is not None
        if now.question is not None:
            assert now.question.unknown
            missions.answer("done", by="a person")
            missions.wait_for(asked, 30.0)
        end = missions.state.run
        assert end is not None
        assert end.phase is Phase.DONE, end
        assert [at for at, _ in end.ended] == list(range(STEPS)), end.ended
        begun = [
            each.step for each in missions.state.notices if each.kind == "step" and each.run == end.entry.id
        ]
        twice = [at for at in set(begun) if begun.count(at) > 1]
        assert all(parse(TEXT).steps[at].do == "wait" for at in twice), "a motion was begun twice"
        assert sim.pose.x < 0.1 * STEPS / 2 + 0.03, sim.pose
        missions.close()
        return f"step {run.at + 1}, {'begun' if run.begun else 'between'}"


def main() -> None:
    parser = argparse.ArgumentParser(allow_abbrev=False)
    parser.add_argument("kills", type=int)
    parser.add_argument("--seed", type=int, default=time.time_ns() % 10_000)
    arguments = parser.parse_args()
    chance = random.Random(arguments.seed)
    print("seed", arguments.seed)
    with SimulatedChassis(speed=4, full_graph=False) as sim:
        met = 0
        while met < arguments.kills:
            with tempfile.TemporaryDirectory() as folder:
                where = kill_once(sim, Path(folder), chance.uniform(0.0, MAX_SECONDS))
            met += where != AFTER
            print(met, where, flush=True)


if __name__ == "__main__":
    main()
