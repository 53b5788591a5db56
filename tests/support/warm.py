"""A Python process with our packages loaded that forks once per program.

Starting an interpreter and loading numpy and our packages takes longer than most small programs run. Each program runs
in a separate process, forked from one that has only loaded the packages: as by `python FILE`, with its own `sys.argv`,
folder, environment and output, and with a complete interpreter exit. Without fork, it is started as usual.

    with WarmPython() as python:
        done = python.run(path, folder)
"""

from __future__ import annotations

import gc
import json
import os
import runpy
import signal
import subprocess
import sys
import threading
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path

__all__ = ["WarmPython"]

ROOT = Path(__file__).resolve().parents[2]


class WarmPython:
    """The process that forks. Use it in a `with` block, from one thread."""

    def __init__(self) -> None:
        environment = {**os.environ, "PYTHONPATH": str(ROOT), "PYTHONIOENCODING": "utf-8"}
        environment.pop("ROS_MASTER_URI", None)
        self._environment = environment
        self._process: subprocess.Popen[str] | None = None

    def __enter__(self) -> WarmPython:
        return self

    def __exit__(self, *_: object) -> None:
        if self._process is not None:
            self._process.communicate(timeout=20)  # the process ends with its input

    def run(
        self,
        script: Path,
        folder: Path,
        arguments: Sequence[str] = (),
        *,
        before: str = "",
        timeout: float = 100.0,
        interrupts: Mapping[float, int] | None = None,
        errors: str = "strict",
    ) -> subprocess.CompletedProcess[str]:
        """Run a program to its end; return its exit code and output.

        Args:
            script: The program.
            folder: Its working directory.
            arguments: Its `sys.argv[1:]`.
            before: Statements to run in its process first (only with fork).
            timeout: Seconds after which it is killed.
            interrupts: Seconds -> signal to send if it still runs.
            errors: Error handler of its standard output, as for `open`.
        """
        if not hasattr(os, "fork"):
            return subprocess.run(
                # The embeddable Python of Windows ignores PYTHON... variables.
                [sys.executable, "-X", "utf8", str(script), *arguments],
                cwd=folder, env=self._environment, capture_output=True, text=True, encoding="utf-8",
                timeout=timeout, check=False, stdin=subprocess.DEVNULL,
            )  # fmt: skip
        if self._process is None:
            self._process = subprocess.Popen(
                [sys.executable, "-c", "from tests.support.warm import serve; serve()"],
                stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=ROOT, env=self._environment,
            )  # fmt: skip
        written = [folder / f"{script.stem}.stdout", folder / f"{script.stem}.stderr"]
        order = {"script": str(script), "arguments": list(arguments), "folder": str(folder), "before": before}
        pid = self._ask({**order, "out": str(written[0]), "err": str(written[1]), "errors": errors})

        def tell(number: int) -> None:
            with suppress(ProcessLookupError):  # it has just ended
                os.kill(pid, number)

        due = {timeout: signal.SIGKILL, **(interrupts or {})}
        late = [threading.Timer(seconds, tell, (number,)) for seconds, number in due.items()]
        for each in late:
            each.start()
        code = self._answer()
        for each in late:
            each.cancel()
        out, err = (path.read_bytes().decode("utf-8", errors) for path in written)
        return subprocess.CompletedProcess([str(script), *arguments], code, out, err)

    def _ask(self, order: Mapping[str, object]) -> int:
        assert self._process is not None
        assert self._process.stdin is not None
        self._process.stdin.write(json.dumps(order) + "\n")
        self._process.stdin.flush()
        return self._answer()

    def _answer(self) -> int:
        assert self._process is not None
        assert self._process.stdout is not None
        return int(self._process.stdout.readline())


def serve() -> None:
    """Run in the process that forks: read one program per line, print its process id and its exit code."""
    load()
    gc.freeze()  # the programs' collectors skip the loaded objects
    while line := sys.stdin.readline():
        order = json.loads(line)
        pid = os.fork()
        if pid == 0:
            become(order)
            return  # the interpreter exits
        print(pid, flush=True)
        print(os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]), flush=True)


def load() -> None:
    """Import the modules of programs and do their lazy initialisation, without a thread or a socket."""
    import asyncio  # noqa: F401

    import numpy  # noqa: F401

    import rosproto
    import woosh_pure
    from woosh_pure import (
        interface,
        sim,  # noqa: F401
    )
    from woosh_pure.values.messages import message_type

    for package in (rosproto, woosh_pure):
        for name in package.__all__:
            getattr(package, name)
    for row in interface.topics():
        if row.definition_known:
            message_type(row.type)


def become(order: Mapping[str, object]) -> None:
    """Run the program in this process."""
    for number, path in ((0, os.devnull), (1, order["out"]), (2, order["err"])):
        opened = os.open(str(path), os.O_RDWR | os.O_CREAT | os.O_TRUNC, 0o600)
        os.dup2(opened, number)
        os.close(opened)
    os.chdir(str(order["folder"]))
    script = str(order["script"])
    sys.argv = [script, *order["arguments"]]  # type: ignore[misc]
    sys.path.insert(0, str(Path(script).parent))
    sys.stdout.reconfigure(errors=str(order["errors"]))  # type: ignore[union-attr]
    exec(str(order["before"]), {})
    runpy.run_path(script, run_name="__main__")
