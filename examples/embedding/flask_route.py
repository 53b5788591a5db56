"""A web page for a robot: Flask routes over one Chassis that all requests share (`pip install flask`).

    python examples/embedding/flask_route.py --stay                  # a simulated robot, at http://127.0.0.1:5000/
    python examples/embedding/flask_route.py --stay 169.254.128.2

No route waits for the end of a drive: a drive is begun, and its end is noted by a callback, so no number of
drives keeps a STOP from being served. Whoever reaches this server can drive: for other computers than this
one it needs a log-in and https, as `woosh web` has.
"""

import argparse
import itertools
from contextlib import ExitStack
from typing import Any

from flask import Flask, Response, jsonify, request

from rosproto import RosError
from woosh_pure import Chassis, MotionRefused, Outcome, SimulatedChassis
from woosh_pure.language import said
from woosh_pure.motion import StepHandle

PAGE = """<!doctype html><meta charset="utf-8"><title>My robot</title>
<p id="state"></p>
<form><input id="metres" value="0.5"> m <button>Move</button></form>
<button id="stop" style="background: #b00020; color: white; font-size: 2em; width: 100%">STOP</button>
<p id="answer"></p>
<script>
const element = (id) => document.getElementById(id);
const show = async (id, path, method, lost) => {
  try {
    const answer = await fetch(path, {method, signal: AbortSignal.timeout(10000)});
    element(id).textContent = JSON.stringify(await answer.json());
  } catch (error) { element(id).textContent = `${lost} (${error.message})`; }
};
const post = (path) => show("answer", path, "POST", "NOT confirmed: use the red button");
element("stop").onclick = () => post("/stop");
document.forms[0].onsubmit = (event) => {
  event.preventDefault();
  post(`/move?metres=${encodeURIComponent(element("metres").value)}`);
};
setInterval(() => show("state", "/status", "GET", "NO CONNECTION to the server"), 500);
</script>"""


def make_app(chassis: Chassis) -> Flask:
    """A Chassis may be used by many threads at once, so one serves all requests."""
    app = Flask(__name__)
    goals: dict[int, dict[str, Any]] = {}
    handles: dict[int, StepHandle] = {}  # of the drives under way
    numbers = itertools.count(1)
    link = {"connected": False}
    chassis.on_connection(lambda connected: link.update(connected=connected))

    @app.before_request
    def own_page_only() -> tuple[Response, int] | None:
        """Pages of other sites may stop the robot, and nothing else."""
        foreign = request.origin not in (None, request.host_url.rstrip("/"))
        if request.method == "POST" and request.path != "/stop" and foreign:
            return jsonify(error=f"pages of {request.origin} may not drive"), 403
        return None

    @app.get("/")
    def page() -> str:
        return PAGE

    @app.get("/status")
    def status() -> Response:
        battery = chassis.battery.latest  # never waits; None until something was heard
        percent = None if battery is None else battery.percent
        return jsonify(percent=percent, **link, ready=chassis.readiness().sentence())

    @app.post("/move")
    def move() -> tuple[Response, int]:
        """Begin a move; its end is at /goals/NUMBER."""
        metres = request.args.get("metres", type=float)  # None: missing, or not a number
        if metres is None:  # the error of float() would be Python's words, in English
            return jsonify(error="metres: give a number, such as 0.5"), 422
        handle = chassis.move(metres)  # ValueError: not finite, or too far
        number = next(numbers)
        goals[number] = {"number": number, "done": False, "what": said(handle.description)}

        def done(outcome: Outcome) -> None:
            ended = {"done": True, "arrived": bool(outcome), "text": outcome.sentence()}
            goals[number] = {**goals[number], **ended}
            del handles[number]

        handles[number] = handle
        handle.on_done(done)  # called in a thread of its own
        return jsonify(goals[number]), 202

    @app.get("/goals/<int:number>")
    def goal(number: int) -> tuple[Response, int]:
        if number not in goals:
            return jsonify(error=f"there is no goal {number}"), 404
        handle = handles.get(number)
        progress = {"metres_left": handle.progress.metres_left} if handle else {}  # never waits
        return jsonify(**goals[number], **progress), 200

    @app.post("/stop")
    def stop() -> Response:
        report = chassis.stop(everything=True)  # needs no permission, and works while others drive
        return jsonify(stands_still=report.standing, text=report.sentence())

    @app.errorhandler(ValueError)
    def wrong(error: ValueError) -> tuple[Response, int]:
        return jsonify(error=said(error)), 422

    @app.errorhandler(MotionRefused)
    def refused(error: MotionRefused) -> tuple[Response, int]:
        return jsonify(error=said(error)), 409

    @app.errorhandler(RosError)
    def failed(error: RosError) -> tuple[Response, int]:
        return jsonify(error=said(error)), 503

    return app


def main() -> None:
    parser = argparse.ArgumentParser(description="A web page for a robot.")
    parser.add_argument("address", nargs="?", help="of the robot; without it one is simulated")
    parser.add_argument("--stay", action="store_true", help="serve until Ctrl-C, not only some requests")
    parser.add_argument("--port", type=int, default=5000)
    args = parser.parse_args()
    with ExitStack() as stack:  # leaving it cancels what is under way
        address = args.address or stack.enter_context(SimulatedChassis(speed=4, full_graph=False)).master_uri
        chassis = stack.enter_context(Chassis(address))
        app = make_app(chassis)
        if args.stay:
            # One process (two would replace each other's goals), many threads.
            app.run(host="127.0.0.1", port=args.port, threaded=True)
            return
        page = app.test_client()
        print(page.post("/move?metres=far").status, page.post("/move?metres=0.2").status)
        chassis.battery.wait(timeout=5, new=False)
        print(page.post("/stop").status, page.get("/status").json)


if __name__ == "__main__":
    main()
