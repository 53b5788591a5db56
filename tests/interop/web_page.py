"""A page of npm's `roslib`, in Node.js: a connection `ros`, and what it says."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from tests.support import web_peers
from tests.support.ros import RosProcess
from tests.support.victim import eventually

__all__ = ["Page", "pages"]


class Page:
    """A program with a connection `ros`, which says what happens."""

    def __init__(self, process: RosProcess) -> None:
        self._process = process

    def said(self, first: str, count: int = 1) -> list[list[Any]]:
        """What it said that begins with this word, so many times at least."""
        found: list[list[Any]] = []

        def enough() -> bool:
            assert "FAILED" not in self._process.output, self._process.output
            lines = [line for line in self._process.output.splitlines() if line.startswith("[")]
            found[:] = [said[1:] for said in map(json.loads, lines) if said[0] == first]
            return len(found) >= count

        eventually(enough, 90, f"{first!r} was not said:\n{self._process.output}")
        return found


@contextmanager
def pages(url: str) -> Iterator[Callable[[str], Page]]:
    """`open(program)` runs it in a page that is connected, and waits for its end; its callbacks go on."""
    module = web_peers.npm_module("roslib/dist/RosLib.js").as_uri()
    processes: list[RosProcess] = []

    def run(program: str) -> Page:
        process = web_peers.start_module(
            f"import * as ROSLIB from '{module}';\n"
            f"const ros = new ROSLIB.Ros({{url: '{url}'}});\n"
            "ros.on('error', e => console.log('FAILED', e));\n"
            "await new Promise(done => ros.on('connection', done));\n"
            "ros.transport.on('message', m => { if (m.op === 'status') say('status', m.level, m.msg); });\n"
            "const asked = (method, ...args) => new Promise((yes, no) => ros[method](...args, yes, no));\n"
            "const topic = (name, messageType, more) => new ROSLIB.Topic({ros, name, messageType, ...more});\n"
            "const call = (name, serviceType, args) => new Promise(done =>\n"
            "  new ROSLIB.Service({ros, name, serviceType})\n"
            "    .callService(args, v => done([true, v]), e => done([false, e])));\n"
            f"{program}\nsay('ready');\n"
        )
        processes.append(process)
        opened = Page(process)
        opened.said("ready")
        return opened

    try:
        yield run
    finally:
        for process in processes:
            process.stop()
