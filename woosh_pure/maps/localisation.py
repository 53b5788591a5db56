"""Where the robot is: giving it its position after power-up, starting and stopping its localisation."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

from woosh_pure.errors import ChassisError
from woosh_pure.geometry import Pose2D
from woosh_pure.interface.table import row
from woosh_pure.values.messages import pose_with_covariance

if TYPE_CHECKING:
    from woosh_pure.core import Core

__all__ = ["Localisation", "require_success"]


class Localisation:
    """The part of `Chassis` that tells the robot where it is; see there."""

    _core: Core

    def set_pose(
        self,
        pose: Pose2D,
        *,
        position_deviation: float = 0.25,
        yaw_deviation: float = 0.26,
        via: Literal["topic", "service"] = "topic",
        service: str | None = None,
    ) -> None:
        """Tell the localisation where the robot stands (`/initialpose`), after power-up for example.

        Whether it has found itself there is told by `readiness()`, `faults` and `/status_code`.

        Args:
            pose: In the map, m and rad.
            position_deviation: How sure you are, 1 sigma, m.
            yaw_deviation: 1 sigma, rad.
            via: "topic" sends to `/initialpose`. "service" calls the chassis's service of type
                woosh_msgs/InitPose, which answers; its name is not documented (the simulator has it at
                `/init_pose`, a name of ours), so it is found by its type, and not every chassis has it.
            service: Name of that service, where you know it: it is called without a search.

        Raises:
            ValueError: A number is not finite, a deviation is not positive, or the pose is not in the map.
            RosTimeout: Nobody listens to `/initialpose`.
            ChassisError: This chassis has no such service, or several, or it refused.
        """
        if pose.frame.lstrip("/") != "map":
            raise ValueError(f"the pose is in {pose.frame!r}; the localisation takes a pose in the map")
        if via not in ("topic", "service"):
            raise ValueError(f'via={via!r}: expected "topic" or "service"')
        message = pose_with_covariance(
            pose, position_deviation=position_deviation, yaw_deviation=yaw_deviation
        )
        if via == "topic":
            self._core.clients.send("/initialpose", message)
        else:
            self._call_by_type("/init_pose", service=service, initial_pose=message)

    def initialise(self, *, timeout: float = 30.0, service: str | None = None) -> None:
        """Initialise the robot: the chassis's service of type woosh_msgs/WooshInit.

        Its name is not documented (the simulator has it at `/woosh_init`, a name of ours), so it is found by
        its type; what a real chassis does then is not documented either. It takes no values: no units, no
        frame.

        Args:
            timeout: Seconds for the answer.
            service: Name of the service, where you know it: it is called without a search.

        Raises:
            ChassisError: This chassis has no such service, or several, or it refused.
            RosTimeout: No answer in time.
        """
        self._call_by_type("/woosh_init", timeout, service)

    def start_localization(self, on: bool = True) -> None:
        """Start the localisation module, or stop it (`/start_localization`).

        Args:
            on: False stops it. No units, no frame.

        Raises:
            ChassisError: The chassis refused.
            ServiceError: This chassis has no such service.
            RosTimeout: No answer in time.
        """
        require_success(self._core.clients.call("/start_localization", data=on), "start_localization")

    def _call_by_type(
        self, name: str, timeout: float | None = None, service: str | None = None, **fields: Any
    ) -> None:
        type_name = row(name).type
        found = self._core.clients.services_of_type(type_name) if service is None else [service]
        if not found:
            raise ChassisError(
                f"this chassis offers no service of type {type_name}; give its position with "
                'set_pose(..., via="topic"), or initialise it at its own display'
            )
        if len(found) > 1:
            raise ChassisError(
                f"this chassis offers several services of type {type_name}: {', '.join(found)}; say which, "
                "with service="
            )
        reply = self._core.clients.call_found(found[0], type_name, timeout=timeout, **fields)
        require_success(reply, f"{found[0]} ({type_name})")


def require_success(reply: Any, what: str) -> None:
    """Turn a `success: false` into an error.

    Raises:
        ChassisError: With the chassis's own words.
    """
    if not reply.success:
        raise ChassisError(
            f"{what}: the chassis refused: {getattr(reply, 'message', '') or 'no reason given'}"
        )
