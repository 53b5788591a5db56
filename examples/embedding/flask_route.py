"""A web page for a chassis: Flask routes over one Chassis that all requests share (`pip install flask`)."""

from flask import Flask, Response, jsonify, request

from rosproto import RosError
from woosh_pure import Chassis, SimulatedChassis


def make_app(chassis: Chassis) -> Flask:
    """A Chassis may be used by many threads at once, so one serves all requests."""
    app = Flask(__name__)

    @app.get("/battery")
    def battery() -> Response:
        return jsonify(percent=chassis.battery.wait(timeout=2, new=False).percent)

    @app.post("/move")
    def move() -> Response:
        chassis.move(float(request.args["metres"])).wait(timeout=30)  # raises unless it arrived
        return jsonify(arrived=True)

    @app.post("/stop")
    def stop() -> Response:
        return jsonify(stopped=str(chassis.stop()))  # needs no permission, works while another request moves

    @app.errorhandler(RosError)
    def failed(error: RosError) -> tuple[Response, int]:
        return jsonify(error=str(error)), 503

    return app


if __name__ == "__main__":
    with SimulatedChassis(speed=4, full_graph=False) as sim, Chassis(sim.master_uri) as chassis:
        app = make_app(chassis)
        page = (
            app.test_client()
        )  # in production: app.run(host="127.0.0.1", threaded=True), or any WSGI server
        print(page.get("/battery").json, page.post("/move?metres=0.2").json, page.post("/stop").status)
