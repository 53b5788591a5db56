"""Send an assistant's random goals at the limits of `woosh mcp`; none may lead the simulated robot outside.

`python -m tests.support.assistant_goals 1000` prints how many were refused and reached, and how far the robot's centre was
from what is allowed at most. A third of the goals are poses, a third steps, a third marks.
"""

from __future__ import annotations

import argparse
import asyncio
import math
import random
import threading
import time
from collections import Counter
from dataclasses import dataclass, field
from typing import Any

from woosh_pure import Chassis, SimulatedChassis
from woosh_pure.geometry import Pose2D

__all__ = ["AREA", "MAX_DISTANCE", "Goals", "run"]

AREA = ((-0.8, -1.8), (3.6, -1.8), (3.6, 1.6), (1.5, 0.4), (-0.8, 1.6))
"""With a notch, so that a straight way between two of its places can lead through the outside."""
MAX_DISTANCE = 3.0  # m


@dataclass
class Goals:
    """What came of them.

    Attributes:
        outcomes: How many ended by each word.
        outside: How far outside the area the centre was at most, m.
        farthest: How far it was from where a goal began at most, m.
        wrong: Goals outside that were not refused.
    """

    outcomes: Counter[str] = field(default_factory=Counter)
    outside: float = 0.0
    farthest: float = 0.0
    wrong: list[object] = field(default_factory=list)


def outside(x: float, y: float) -> float:
    """How far a point is outside the area, m; 0.0 if it is inside."""
    inside, nearest = False, math.inf
    for (ax, ay), (bx, by) in zip(AREA, (*AREA[1:], AREA[0]), strict=True):
        if (ay > y) != (by > y) and x < (bx - ax) * (y - ay) / (by - ay) + ax:
            inside = not inside
        share = ((x - ax) * (bx - ax) + (y - ay) * (by - ay)) / ((bx - ax) ** 2 + (by - ay) ** 2)
        share = min(1.0, max(0.0, share))
        nearest = min(nearest, math.hypot(x - ax - share * (bx - ax), y - ay - share * (by - ay)))
    return 0.0 if inside else nearest


def goal_of(chance: random.Random, marks: list[str]) -> tuple[str, dict[str, Any]]:
    """A tool and its arguments."""
    kind = chance.choice(("go_to_pose", "move", "go_to_mark"))
    if kind == "go_to_mark":
        return kind, {"mark": chance.choice(marks)}
    if kind == "move":
        return kind, {"distance_m": round(chance.uniform(-2.5, 2.5), 2), "speed_m_per_s": 0.5}
    x, y = chance.uniform(-1.8, 4.6), chance.uniform(-2.8, 2.6)
    return kind, {"x_m": round(x, 2), "y_m": round(y, 2), "heading_deg": round(chance.uniform(-180, 180))}


def run(count: int, seed: int = 0, speed: float = 12.0) -> Goals:
    """Send so many goals, one after the other; see above."""
    from mcp import Client

    from woosh_pure.mcp import Limits, server

    chance, goals, over = random.Random(seed), Goals(), threading.Event()
    with (
        SimulatedChassis(full_graph=False, speed=speed) as sim,
        Chassis(sim.master_uri, robot_api=False) as chassis,
    ):
        begun: list[Pose2D] = [sim.pose]

        def look() -> None:
            while not over.is_set():
                pose = sim.pose
                goals.outside = max(goals.outside, outside(pose.x, pose.y))
                goals.farthest = max(goals.farthest, *(pose.distance_to(start) for start in begun), 0.0)
                time.sleep(0.002)

        async def send() -> None:
            limits = Limits(area=AREA, max_distance=MAX_DISTANCE, max_seconds=20.0)
            known = sim.world.site.user_marks().values()
            made = server(chassis, limits=limits, allow_motion=True, confirm="never", marks=known)
            async with Client(made) as client:
                for _ in range(count):
                    tool, arguments = goal_of(chance, list(sim.marks))
                    begun[:] = [sim.pose]
                    result = await client.call_tool(tool, arguments)
                    outcome = str((result.structured_content or {}).get("outcome", "error"))
                    goals.outcomes[outcome] += 1
                    # Against a wall its bumper keeps it from moving; outside, nothing leads it back in.
                    if outcome == "failed" or outside(sim.pose.x, sim.pose.y) > 0.0:
                        begun.clear()  # it is put back, which is no drive
                        sim.reset()
                        chassis.pose.wait(5.0)
                    target = sim.marks.get(str(arguments.get("mark")))
                    place = (target.x, target.y) if target else (arguments.get("x_m"), arguments.get("y_m"))
                    if place[0] is not None and outside(*place) > 0.0 and outcome != "refused":
                        goals.wrong.append((tool, arguments, outcome))

        watch = threading.Thread(target=look, daemon=True)
        watch.start()
        asyncio.run(send())
        over.set()
        watch.join(5.0)
    return goals


def main() -> None:
    parser = argparse.ArgumentParser(allow_abbrev=False)
    parser.add_argument("goals", type=int)
    parser.add_argument("--seed", type=int, default=time.time_ns() % 10_000)
    parser.add_argument("--speed", type=float, default=12.0, help="simulated seconds per second (12)")
    arguments = parser.parse_args()
    print("seed", arguments.seed)
    goals = run(arguments.goals, arguments.seed, arguments.speed)
    print(dict(goals.outcomes))
    print(
        f"outside the area by {goals.outside:.3f} m at most, {goals.farthest:.2f} m from where a goal began"
    )
    print(f"{len(goals.wrong)} goals outside were not refused {goals.wrong[:5]}")


if __name__ == "__main__":
    main()
