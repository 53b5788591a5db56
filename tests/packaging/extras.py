"""Each extra by itself: its command starts in an environment with that extra and nothing else.

`python tests/packaging/extras.py`: one line for each extra; the first that fails ends it with an AssertionError. The
interpreter that runs it needs the project, `build`, `hatchling` and `uv`, which fills thirteen environments in the time that
pip needs for one.
"""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import tempfile
import time
import venv
from collections.abc import Sequence
from pathlib import Path

from rosproto.bag import BagWriter
from rosproto.codec import message_class
from woosh_pure import SimulatedChassis

ROOT = Path(__file__).resolve().parents[2]
OF_USERS = {
    "cli": ["rosproto param set /extra 'a:\n  b: 1'"],
    "mcap": ["rosproto bag convert {bag} {out}/a.mcap"],
    "arrow": ["rosproto bag export --format parquet --topics /n -o {out}/n.parquet {bag}"],
    "remote": ["rosproto bag info file://{bag}"],
    "ros2": ["rosproto bag convert --ros2 {bag} {out}/ros2"],
    "bridge": ["rosproto bridge --port 0 => ws://"],
    "foxglove": ["rosproto foxglove --port 0 => ws://"],
    "api": ["woosh sim --port 0 --robot-api 0 => ws://"],
    "web": ["woosh web --port 0 --no-browser => http://"],
    "mcp": ["woosh mcp < /dev/null", "woosh mcp --http 0 => http://"],
    "missions": ["woosh mission check {examples}/missions/round.mission.toml"],
    "fleet": ["woosh vda5050 --broker mqtt://127.0.0.1:9 --manufacturer m --serial s => cannot be reached"],
}
"""The commands of each extra; behind `=>` the output of a command that runs until interrupted."""
OF_THE_PROJECT = {
    "test": [
        "pytest -q -n 0 -p no:cacheprovider tests/unit/test_names.py"
    ],  # all of them: README's second command
    "docs": ["mkdocs build --strict -d {out}/site"],
    "dev": ["ruff check .", "ruff format --check -q .", "mypy --version", "coverage --version"],
}
"""Development extras run in the project's folder."""


def run(words: Sequence[object], *, seconds: float = 900, **options: object) -> str:
    """Run it; its output, when it succeeds."""
    done = subprocess.run(
        [str(word) for word in words], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=seconds, **options
    )  # fmt: skip
    assert done.returncode == 0, f"{' '.join(map(str, words))}: exit code {done.returncode}\n{done.stdout}"
    return done.stdout


def install(python: Path, what: str) -> None:
    """With uv, or with pip where uv does not know the way to the registry; that is a network: two attempts."""
    uv = [sys.executable, "-m", "uv", "pip", "install", "-q", "--python", python, what]
    pip = [sys.executable, "-m", "pip", "--python", python, "install", "-q", "--no-compile", what]
    for command, pause in ((uv, 0), (pip, 5), (pip, None)):
        try:
            run(command)
            return
        except (AssertionError, subprocess.TimeoutExpired):
            if pause is None:
                raise
            time.sleep(pause)


def start(line: str, folder: Path, environment: dict[str, str]) -> None:
    """Run one command to its end, or until its expected output."""
    command, _, shown = line.partition(" => ")
    if not shown:
        run(["sh", "-c", command], cwd=folder, env=environment)
        return
    with tempfile.TemporaryFile("w+") as output:
        process = subprocess.Popen(command.split(), cwd=folder, env=environment, stdout=output, stderr=output)
        try:
            end = time.monotonic() + 180
            while shown not in text_of(output) and process.poll() is None and time.monotonic() < end:
                time.sleep(0.1)
            assert shown in text_of(output), f"{command}\n{text_of(output)}"
            process.send_signal(signal.SIGINT)
            process.wait(30)
        finally:
            process.kill()
            process.wait()


def text_of(file: object) -> str:
    file.seek(0)  # type: ignore[attr-defined]
    return str(file.read())  # type: ignore[attr-defined]


def main() -> None:
    """All extras, or the named ones."""
    text = (ROOT / "pyproject.toml").read_text("utf-8").partition("[project.optional-dependencies]")[2]
    extras = re.findall(r"^(\w+) = \[", text.partition("\n[")[0], re.MULTILINE)
    assert sorted(extras) == sorted(OF_USERS | OF_THE_PROJECT), extras
    with tempfile.TemporaryDirectory(prefix="woosh-extras-") as name, SimulatedChassis() as robot:
        work = Path(name)
        bag = work / "a.bag"
        with BagWriter(bag) as writer:
            for number in range(5):
                writer.write("/n", message_class("std_msgs/Float64")(data=number), 1.0 + number)
        run([sys.executable, "-m", "build", "--no-isolation", "--wheel", "--outdir", work, ROOT])
        (wheel,) = work.glob("*.whl")
        for extra in sys.argv[1:] or extras:
            began = time.monotonic()
            place, out = work / extra / "venv", work / extra / "out"
            out.mkdir(parents=True)
            venv.create(place, with_pip=False, symlinks=True)
            project = extra in OF_THE_PROJECT
            source = ROOT if project else wheel
            install(place / "bin" / "python", f"woosh-pure[{extra}] @ {source.as_uri()}")
            environment = {
                **os.environ, "PATH": f"{place / 'bin'}{os.pathsep}/usr/bin{os.pathsep}/bin",
                "VIRTUAL_ENV": str(place), "ROS_MASTER_URI": robot.master_uri, "NO_MKDOCS_2_WARNING": "1",
            }  # fmt: skip
            for line in (OF_USERS | OF_THE_PROJECT)[extra]:
                start(
                    line.format(bag=bag, out=out, examples=ROOT / "examples"),
                    ROOT if project else out,
                    environment,
                )
            print(f"{time.monotonic() - began:6.1f} s  {extra}", flush=True)


if __name__ == "__main__":
    main()
