"""Kill -9 on the way: nothing that was acknowledged is lost, no action runs twice, and the state is true soon.

    python -m tests.interop.fleet.test_kills [TRIALS] [SEED] [VICTIM,VICTIM...]

runs many, and prints what each showed; here are a few.
"""

from __future__ import annotations

import statistics
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support.fleet_kills import VICTIMS, Hall, Trial

pytestmark = [pytest.mark.interop, pytest.mark.slow]
pytest.importorskip("paho.mqtt.client", reason="paho-mqtt is not installed")
TRUE_AFTER = {"broker": 2.0, "robot": 2.0, "process": 2.0}
PATIENCE = 4.0  # times that, in CI's company


@pytest.fixture(scope="module")
def hall(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Hall]:
    with Hall(tmp_path_factory.mktemp("kills"), seed=1) as hall:
        yield hall


@pytest.mark.parametrize("victim", VICTIMS)
def test_what_is_killed_comes_back_as_it_was(hall: Hall, victim: str) -> None:
    """The process with the order that it had; the broker with a state of now; the robot where it stands."""
    trial = hall.trial(victim)
    assert trial.wrong == []
    assert trial.true_after < PATIENCE * TRUE_AFTER[victim]


def main(trials: int = 30, seed: int = 1, victims: str = ",".join(VICTIMS)) -> int:
    found: dict[str, list[Trial]] = {}
    with tempfile.TemporaryDirectory() as folder, Hall(Path(folder), seed) as hall:
        try:
            for _ in range(trials):
                for victim in victims.split(","):
                    trial = hall.trial(victim)
                    found.setdefault(victim, []).append(trial)
                    print(f"{victim:8} {trial.seed:8} true after {trial.true_after:5.2f} s, ONLINE after "
                          f"{trial.online_after:5.2f} s, silence after {hall.silence_after:4.2f} s, processor {trial.processor:4.2f} s {'; '.join(trial.wrong)}", flush=True)  # fmt: skip
        finally:
            print((Path(folder) / "vehicle.log").read_text()[-2000:])
    for victim, each in found.items():
        times = [trial.true_after for trial in each]
        wrong = sum(bool(trial.wrong) for trial in each)
        late = sum(time > TRUE_AFTER[victim] for time in times)
        print(f"{victim}: {len(each)} trials, {wrong} wrong, true after {statistics.median(times):.2f} s (at most "
              f"{max(times):.2f}), {late} later than {TRUE_AFTER[victim]} s")  # fmt: skip
    return int(any(trial.wrong for each in found.values() for trial in each))


if __name__ == "__main__":
    given = [*sys.argv[1:], *("30", "1", ",".join(VICTIMS))[len(sys.argv) - 1 :]]
    sys.exit(main(int(given[0]), int(given[1]), given[2]))
