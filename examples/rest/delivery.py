"""A delivery over the REST API, with a client that a generator makes from /openapi.json.

Nothing of this project is imported here: the same works in any language that has an OpenAPI generator.

    woosh --sim web                                                        # in another terminal
    pip install openapi-python-client
    openapi-python-client generate --url http://127.0.0.1:8080/openapi.json \\
        --meta none --output-path woosh_client
    PYTHONPATH=. python examples/rest/delivery.py

The generator warns that it leaves out pictures and map.yaml. Arguments: another address, and the token if the
server was started with one.
"""

import sys
from typing import Any

try:
    import httpx
    from woosh_client import AuthenticatedClient, Client
    from woosh_client.api.goals import create_goal, wait_for_goal
    from woosh_client.api.lease import ask_for_lease, give_lease_back
    from woosh_client.api.marks import get_marks
    from woosh_client.api.state import get_readiness
    from woosh_client.api.stop import stop
    from woosh_client.models import CarryGoal, CarryGoalDirection, LeaseRequest, MarkGoal, ProblemDocument
except ModuleNotFoundError as error:
    sys.exit(
        f"{error}: generate the client first, and name its folder in PYTHONPATH (see the top of this file)"
    )


def checked(answer: Any) -> Any:
    """The answer, unless it is a problem: then its sentence ends the program."""
    if answer is None:
        sys.exit("the server gave an answer that its /openapi.json does not describe")
    if isinstance(answer, ProblemDocument):
        sys.exit(f"{answer.title}: {answer.detail}")
    return answer


def drive(robot: Any, order: Any) -> None:
    """Send the order, and wait until the robot has arrived."""
    goal = checked(create_goal.sync(client=robot, body=order))
    while not goal.done:
        goal = checked(wait_for_goal.sync(goal.id, client=robot, timeout=30.0))
    print(goal.text, flush=True)
    if not goal.arrived:
        sys.exit(1)


def main(address: str = "http://127.0.0.1:8080", token: str = "") -> None:
    """Load at the first mark, unload at the second, and go back."""
    options = {"base_url": address, "timeout": 70.0}
    robot = AuthenticatedClient(token=token, **options) if token else Client(**options)
    ready = checked(get_readiness.sync(client=robot))
    if ready.answer == "no":
        sys.exit(ready.text)
    marks = [mark.name for mark in checked(get_marks.sync(client=robot)) if not mark.charger]
    if len(marks) < 2:
        sys.exit("a delivery takes two marks: start the server with --marks FILE")
    fetch, deliver = marks[:2]
    lease = checked(ask_for_lease.sync(client=robot, body=LeaseRequest(seconds=300.0)))
    if not lease.yours:
        sys.exit(f"{lease.holder} commands this robot; it has been asked to hand over")
    try:
        drive(robot, CarryGoal(kind="carry", mark=fetch, direction=CarryGoalDirection.LOAD))
        drive(robot, CarryGoal(kind="carry", mark=deliver, direction=CarryGoalDirection.UNLOAD))
        drive(robot, MarkGoal(kind="mark", mark=fetch))
    except BaseException:  # Ctrl-C, a server that is gone: the robot does not go on alone
        print(checked(stop.sync(client=robot)).text)
        raise
    finally:
        give_lease_back.sync(client=robot)
    print(f"delivered from {fetch} to {deliver}")


if __name__ == "__main__":
    try:
        main(*sys.argv[1:3])
    except httpx.TransportError as error:
        sys.exit(f"no answer from the server: {error}; is `woosh web` running at this address?")
